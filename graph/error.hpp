// Typed errors. Every message names the culprit, its value, the rule it breaks and the cure.
#pragma once

#include <locale>
#include <sstream>
#include <stdexcept>
#include <string>

namespace holdfast {

/// Base of everything holdfast throws.
class Error : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A number that breaks its rule: NaN, infinite, a sigma that is not positive, a covariance that is not positive definite.
class BadNumber : public Error {
 public:
  using Error::Error;
};

/// A key that is not there, or is there already.
class BadKey : public Error {
 public:
  using Error::Error;
};

/// A key whose variable has another type than the one asked for.
class BadType : public Error {
 public:
  using Error::Error;
};

/// An option, a name or a combination that does not exist.
class BadOption : public Error {
 public:
  using Error::Error;
};

/// A file that cannot be read or written: names the file, the line number, the text and what was expected.
class BadFile : public Error {
 public:
  using Error::Error;
};

/// Throws E with the parts streamed into one message.
template <class E, class... Parts>
[[noreturn]] void fail(const Parts&... parts) {
  std::ostringstream text;
  text.imbue(std::locale::classic());
  text.precision(17);
  (text << ... << parts);
  throw E(text.str());
}

}  // namespace holdfast
