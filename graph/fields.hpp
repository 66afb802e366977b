// The fields of a factor by name: what a file keeps of it (graph/files/binary.hpp, Window::save). A factor that is to be saved lists them:
//
//   static constexpr auto fields() { return std::tuple(field("distance", &Range::distance), field("sigma", &Range::sigma)); }
//
// All of them: a list that leaves out a member does not compile. A field is a number, a truth value, an enum, a matrix of fixed size, a
// variable, a std::array of such, or a struct that lists fields of its own; nothing else (a pointer, a string) can be saved. Their bits
// come back as they were. A factor without a list runs everywhere, and is refused by name when it is to be saved.
#pragma once

#include <algorithm>
#include <array>
#include <cstring>
#include <holdfast/graph/error.hpp>
#include <holdfast/graph/math.hpp>
#include <string>
#include <tuple>
#include <type_traits>
#include <vector>

namespace holdfast {

template <class F, class T>
struct Field {
  using type = T;
  const char* name;
  T F::*member;
};
template <class F, class T>
constexpr Field<F, T> field(const char* name, T F::*member) {
  return {name, member};
}

/// A field as a file names it.
struct FieldType {
  std::string name;
  std::string type;  ///< "double", "int32", "double[3x3]", "Pose2[4]" (its ambient coordinates), "{bias double, rate double}"
  std::size_t bytes;
  bool in_doubles;  ///< all of it is doubles, one after the other
};

namespace detail {

template <class F, class = void>
struct HasFields : std::false_type {};
template <class F>
struct HasFields<F, std::void_t<decltype(F::fields())>> : std::true_type {};

template <class T, class = void>
struct IsVariable : std::false_type {};
template <class T>
struct IsVariable<T, std::void_t<decltype(T::dim), decltype(T::name()), decltype(&T::is_finite)>>
    : std::bool_constant<std::is_standard_layout_v<T> && sizeof(T) % sizeof(double) == 0> {};

template <class T>
struct IsFixedMatrix : std::false_type {};
template <class S, int R, int C, int O, int MR, int MC>
struct IsFixedMatrix<Eigen::Matrix<S, R, C, O, MR, MC>> : std::bool_constant<(R > 0 && C > 0 && std::is_arithmetic_v<S>)> {};

template <class T>
struct ArrayOf {
  static constexpr std::size_t size = 0;
};
template <class T, std::size_t N>
struct ArrayOf<std::array<T, N>> {
  static constexpr std::size_t size = N;
};

template <class T>
inline constexpr bool is_number = std::is_arithmetic_v<T> && !std::is_same_v<T, bool>;
/// Its memory is its numbers.
template <class T>
inline constexpr bool is_plain = is_number<T> || std::is_enum_v<T> || IsFixedMatrix<T>::value || IsVariable<T>::value;

/// All of it is doubles.
template <class T>
constexpr bool is_doubles() {
  if constexpr (IsFixedMatrix<T>::value)
    return std::is_same_v<typename T::Scalar, double>;
  else if constexpr (ArrayOf<T>::size > 0)
    return is_doubles<typename T::value_type>();
  else
    return std::is_same_v<T, double> || IsVariable<T>::value;
}

template <class F>
std::string types_of_fields();

template <class T>
std::string number_type() {
  const std::string bits = std::to_string(8 * sizeof(T));
  if constexpr (std::is_floating_point_v<T>)
    return std::is_same_v<T, double> ? "double" : "float" + bits;
  else
    return (std::is_signed_v<T> ? "int" : "uint") + bits;
}

template <class T>
std::string field_type() {
  if constexpr (std::is_same_v<T, bool>) {
    return "bool";
  } else if constexpr (is_number<T>) {
    return number_type<T>();
  } else if constexpr (std::is_enum_v<T>) {
    return "enum " + number_type<std::underlying_type_t<T>>();
  } else if constexpr (IsVariable<T>::value) {
    return std::string(T::name()) + "[" + std::to_string(sizeof(T) / sizeof(double)) + "]";
  } else if constexpr (IsFixedMatrix<T>::value) {
    return number_type<typename T::Scalar>() + "[" + std::to_string(T::RowsAtCompileTime) + "x" + std::to_string(T::ColsAtCompileTime) +
           "]";
  } else if constexpr (ArrayOf<T>::size > 0) {
    return field_type<typename T::value_type>() + "[" + std::to_string(ArrayOf<T>::size) + "]";
  } else {
    static_assert(
        HasFields<T>::value,
        "a field is a number, a bool, an enum, a matrix of fixed size, a variable, a std::array of such, or a struct with fields()");
    return "{" + types_of_fields<T>() + "}";
  }
}

template <class T>
constexpr std::size_t field_bytes() {
  if constexpr (std::is_same_v<T, bool>)
    return 1;
  else if constexpr (is_plain<T>)
    return sizeof(T);
  else if constexpr (ArrayOf<T>::size > 0)
    return ArrayOf<T>::size * field_bytes<typename T::value_type>();
  else
    return std::apply([](const auto&... f) { return (std::size_t{0} + ... + field_bytes<typename std::decay_t<decltype(f)>::type>()); },
                      T::fields());
}

/// Most of the struct's bytes that its fields do not hold and may be padding, between them or inside.
template <class F>
constexpr std::size_t most_padding() {
  const auto padding = [](std::size_t size, std::size_t bytes) { return size - bytes + (alignof(F) - size % alignof(F)) % alignof(F); };
  return std::apply(
      [&](const auto&... f) {
        return (std::size_t{0} + ... +
                padding(sizeof(typename std::decay_t<decltype(f)>::type), field_bytes<typename std::decay_t<decltype(f)>::type>()));
      },
      F::fields());
}

template <class T>
void put_field(const T& value, char*& out) {
  if constexpr (std::is_same_v<T, bool>) {
    *out++ = value ? 1 : 0;
  } else if constexpr (is_plain<T>) {
    std::memcpy(out, static_cast<const void*>(&value), sizeof(T));
    out += sizeof(T);
  } else if constexpr (ArrayOf<T>::size > 0) {
    for (const auto& one : value) put_field(one, out);
  } else {
    std::apply([&](const auto&... f) { (put_field(value.*f.member, out), ...); }, T::fields());
  }
}

template <class T>
void get_field(T& value, const char*& in) {
  if constexpr (std::is_same_v<T, bool>) {
    const char byte = *in++;
    if (byte != 0 && byte != 1) fail<BadFile>("a truth value is ", int{byte}, ", neither 0 nor 1");
    value = byte == 1;
  } else if constexpr (is_plain<T>) {
    std::memcpy(static_cast<void*>(&value), in, sizeof(T));
    in += sizeof(T);
  } else if constexpr (ArrayOf<T>::size > 0) {
    for (auto& one : value) get_field(one, in);
  } else {
    std::apply([&](const auto&... f) { (get_field(value.*f.member, in), ...); }, T::fields());
  }
}

template <class F>
std::vector<FieldType> fields_of() {
  constexpr std::size_t bytes = field_bytes<F>();
  static_assert(sizeof(F) <= std::max<std::size_t>(bytes + most_padding<F>(), 1), "fields() leaves out a member");
  return std::apply(
      [](const auto&... f) {
        return std::vector<FieldType>{FieldType{f.name, field_type<typename std::decay_t<decltype(f)>::type>(),
                                                field_bytes<typename std::decay_t<decltype(f)>::type>(),
                                                is_doubles<typename std::decay_t<decltype(f)>::type>()}...};
      },
      F::fields());
}

template <class F>
std::string types_of_fields() {
  std::string text;
  for (const FieldType& f : fields_of<F>()) text += (text.empty() ? "" : ", ") + f.name + " " + f.type;
  return text;
}

}  // namespace detail
}  // namespace holdfast
