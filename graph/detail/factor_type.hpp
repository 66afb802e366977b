// What files and reports want of a factor type beyond what solvers see of it (FactorBatch). Graph::add enters a type's description when
// the program starts: a program knows every factor type that it has code to add.
//
// In a file a factor is its fields by name (graph/fields.hpp), under its C++ name: readable by programs that have the same fields. A factor
// without fields() cannot be written.
#pragma once

#include <holdfast/graph/batch.hpp>

namespace holdfast {

struct FactorType {
  std::string name;  ///< "holdfast::Prior<holdfast::Pose2T<double> >"
  bool is_saved;     ///< it has fields() and can be made without arguments
  std::vector<FieldType> fields;
  std::unique_ptr<FactorBatch> (*make)(const Loss& loss);
  /// The fields of factor i one after the other, and a new factor from them.
  void (*put)(const FactorBatch& batch, int i, char* fields);
  void (*push)(FactorBatch& batch, const char* fields);
  /// The residual in the units of the measurement; false where the factor does not say (FactorConcept, raw()).
  bool (*raw)(const FactorBatch& batch, int i, const double* whitened, double* raw);
};

/// Null: no code of this program adds such a factor.
const FactorType* find_factor_type(std::type_index type);
const FactorType* find_factor_type(std::string_view name);
bool enter_factor_type(std::type_index type, FactorType description);

namespace detail {

template <class F, class = void>
struct HasRaw : std::false_type {};
template <class F>
struct HasRaw<F, std::void_t<decltype(std::declval<const F&>().raw(std::declval<const Residual<F>&>()))>> : std::true_type {};
template <class F, class = void>
struct HasSqrtInformation : std::false_type {};
template <class F>
struct HasSqrtInformation<F, std::enable_if_t<std::decay_t<decltype(std::declval<const F&>().sqrt_information)>::SizeAtCompileTime ==
                                              F::residual_dim * F::residual_dim>> : std::true_type {};

/// W x = r, W n × n, column-major. Where W is singular (partial information) and r in its range, one of the many solutions: a component of
/// which W says nothing is 0.
void solve_square(int n, const double* W, const double* r, double* x);

template <class F>
bool raw_residual(const FactorBatch& batch, int i, const double* whitened, double* raw) {
  const F& factor = static_cast<const Batch<F>&>(batch).factors()[i];
  if constexpr (HasRaw<F>::value) {
    const Residual<F> r = factor.raw(Eigen::Map<const Residual<F>>(whitened));
    std::copy_n(r.data(), F::residual_dim, raw);
    return true;
  } else if constexpr (HasSqrtInformation<F>::value) {
    solve_square(F::residual_dim, factor.sqrt_information.data(), whitened, raw);
    return true;
  } else {
    return false;
  }
}

template <class F>
void put_factor(const FactorBatch& batch, int i, char* fields) {
  if constexpr (HasFields<F>::value) put_field(static_cast<const Batch<F>&>(batch).factors()[i], fields);
}

template <class F>
void push_factor(FactorBatch& batch, const char* fields) {
  if constexpr (HasFields<F>::value && std::is_default_constructible_v<F>) {
    F factor{};
    get_field(factor, fields);
    static_cast<Batch<F>&>(batch).factors().push_back(factor);
  }
}

template <class F>
FactorType factor_type() {
  std::vector<FieldType> fields;
  if constexpr (HasFields<F>::value) fields = fields_of<F>();
  return {demangled(typeid(F)),
          HasFields<F>::value && std::is_default_constructible_v<F>,
          fields,
          [](const Loss& loss) -> std::unique_ptr<FactorBatch> { return std::make_unique<Batch<F>>(loss); },
          put_factor<F>,
          push_factor<F>,
          raw_residual<F>};
}

template <class F>
inline const bool factor_type_is_entered = enter_factor_type(typeid(F), factor_type<F>());

}  // namespace detail
}  // namespace holdfast
