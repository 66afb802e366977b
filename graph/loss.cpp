#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <holdfast/graph/error.hpp>
#include <holdfast/graph/internal/digits.hpp>
#include <holdfast/graph/loss.hpp>
#include <limits>
#include <map>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

namespace holdfast {
namespace {

constexpr std::array<const char*, 10> kNames{"squared",       "absolute", "huber", "pseudo_huber",      "cauchy",
                                             "geman_mcclure", "welsch",   "tukey", "truncated_squares", "student_t"};

const char* name_of(Loss::Kind kind) { return kNames[static_cast<std::size_t>(kind)]; }

// Within these the square of a threshold is a number that can be divided by.
constexpr double kLeast = 1e-100, kLargest = 1e100;
bool is_threshold(double scale) { return scale >= kLeast && scale <= kLargest; }

Rho huber(double s, double a) {
  if (s <= a * a) return {s, 1, 0};
  const double root = std::sqrt(s);
  return {2 * a * root - a * a, a / root, -a / (2 * s * root)};
}

Rho tukey(double s, double c2) {
  if (s > c2) return {c2 / 3, 0, 0};
  const double t = s / c2, u = 1 - t;
  return {s * (1 - t + t * t / 3), u * u, -2 * u / c2};  // = c²/3 (1 − u³), without the cancellation near 0
}

struct NamedLoss {
  std::type_index type;
  std::function<Loss(const double*)> make;
};
std::map<std::string, NamedLoss, std::less<>>& registered() {
  static std::map<std::string, NamedLoss, std::less<>> all;
  return all;
}

/// A loss by its name with this threshold, or with its default; nothing where the name is not known.
std::optional<Loss> loss_named(std::string_view name, const double* threshold) {
  static const std::array<Loss, 10> defaults{Squared{},      Absolute{}, Huber{}, PseudoHuber{},      Cauchy{},
                                             GemanMcClure{}, Welsch{},   Tukey{}, TruncatedSquares{}, StudentT{}};
  const auto kind = std::find(kNames.begin(), kNames.end(), name);
  if (kind != kNames.end()) {
    Loss loss = defaults[kind - kNames.begin()];
    if (threshold != nullptr) loss.scale = *threshold;
    return loss;
  }
  const auto own = registered().find(name);
  if (own == registered().end()) return std::nullopt;
  return own->second.make(threshold);
}

}  // namespace

Rho Loss::rho(double s, int d) const {
  const double c2 = scale * scale;
  switch (kind) {
    case Kind::Squared:
      return {s, 1, 0};
    case Kind::Absolute: {
      const double root = std::sqrt(s + c2);
      return {2 * s / (root + scale), 1 / root, -0.5 / (root * root * root)};
    }
    case Kind::Huber:
      return huber(s, scale);
    case Kind::PseudoHuber: {
      const double root = std::sqrt(1 + s / c2);
      return {2 * s / (root + 1), 1 / root, -0.5 / (c2 * root * root * root)};
    }
    case Kind::Cauchy: {
      const double u = 1 / (1 + s / c2);
      return {c2 * std::log1p(s / c2), u, -u * u / c2};
    }
    case Kind::GemanMcClure: {
      const double u = 1 / (1 + s / c2);
      return {s * u, u * u, -2 * u * u * u / c2};
    }
    case Kind::Welsch: {
      const double u = std::exp(-s / c2);
      return {-c2 * std::expm1(-s / c2), u, -u / c2};
    }
    case Kind::Tukey:
      return tukey(s, c2);
    case Kind::TruncatedSquares:
      return s <= c2 ? Rho{s, 1, 0} : Rho{c2, 0, 0};
    case Kind::StudentT: {
      const double u = 1 / (scale + s);
      return {(scale + d) * std::log1p(s / scale), (scale + d) * u, -(scale + d) * u * u};
    }
    case Kind::Own:
      return own->rho(s, d);
  }
  return {s, 1, 0};
}

Loss Loss::relaxed() const {
  if (is_convex()) return *this;
  Loss convex = kind == Kind::Own ? own->relaxed() : Loss(Huber{kind == Kind::StudentT ? std::sqrt(scale) : scale});
  convex.per_component = per_component;
  convex.one_sided = one_sided;
  return convex;
}

Loss detail::huber_up_to_bend(const OwnLoss& loss) {
  for (double s = 1e-12; s < 1e12; s *= 1.02) {
    const Rho rho = loss.rho(s, 1);
    if (!(rho.first + 2 * s * rho.second > 0)) return Huber{std::sqrt(s)};
  }
  fail<BadOption>("loss ", loss.name(), " bends down nowhere between 1e-6 and 1e6 sigmas: state is_convex = true, or a convex relaxed()");
}

void detail::register_loss(std::string name, std::type_index type, std::function<Loss(const double*)> make) {
  const auto known = registered().find(name);
  const bool is_word = !name.empty() && name.find_first_of(": \t\n") == std::string::npos && name != "component" && name != "one_sided";
  if (!is_word || std::find(kNames.begin(), kNames.end(), name) != kNames.end() ||
      (known != registered().end() && known->second.type != type))
    fail<BadOption>("a loss cannot be called '", name, "': that is no single word, or another loss has it; give it another name()");
  registered().insert_or_assign(std::move(name), NamedLoss{type, std::move(make)});
}

bool Loss::is_named() const {
  if (kind != Kind::Own) return true;
  const auto known = registered().find(own->name());
  return known != registered().end() && known->second.type == own->type();
}

void Loss::validate(int residual_dim) const {
  if (kind == Kind::Own)
    own->validate();
  else if (!is_threshold(scale))
    fail<BadNumber>("loss ", str(), ": its threshold ", scale, " must be finite and > 0, from ", kLeast, " to ", kLargest, " [sigmas]");
  if (one_sided && !per_component && residual_dim != 1)
    fail<BadOption>("loss ", str(), " is one-sided, but a block of ", residual_dim, " components has no sign; use per_component(…)");
}

std::string Loss::str() const {
  std::string text = kind == Kind::Own ? own->name() : name_of(kind);
  const double* threshold = kind == Kind::Own ? own->scale() : kind == Kind::Squared ? nullptr : &scale;
  if (threshold != nullptr) text.append(":").append(Digits(*threshold));
  if (per_component) text += ":component";
  if (one_sided) text += ":one_sided";
  return text;
}

Loss Loss::parse(std::string_view text) {
  const auto refuse = [&] {
    std::ostringstream names;
    for (const char* name : kNames) names << ' ' << name;
    for (const auto& [name, loss] : registered()) names << ' ' << name;
    fail<BadOption>("'", text, "' is no loss: expected NAME[:THRESHOLD][:component][:one_sided] with a threshold > 0 and NAME one of",
                    names.str());
  };
  std::vector<std::string_view> parts;
  for (std::string_view rest = text;; rest.remove_prefix(parts.back().size() + 1)) {
    parts.push_back(rest.substr(0, rest.find(':')));
    if (parts.back().size() == rest.size()) break;
  }
  std::optional<double> threshold;
  bool component = false, sided = false;
  for (std::size_t i = 1; i < parts.size(); ++i) {
    const std::string_view part = parts[i];
    if (part == "component" && !component) {
      component = true;
    } else if (part == "one_sided" && !sided) {
      sided = true;
    } else {
      double number = 0;
      const auto [end, error] = std::from_chars(part.data(), part.data() + part.size(), number);
      if (threshold || error != std::errc{} || end != part.data() + part.size() || !is_threshold(number)) refuse();
      threshold = number;
    }
  }
  std::optional<Loss> loss = loss_named(parts.front(), threshold ? &*threshold : nullptr);
  if (!loss || (threshold && loss->kind == Kind::Squared)) refuse();
  loss->per_component = component;
  loss->one_sided = sided;
  return *loss;
}

}  // namespace holdfast
