// What files and reports want of a factor type beyond what solvers see of it (FactorBatch). Graph::add enters a type's description when
// the program starts: a program knows every factor type that it has code to add.
//
// In a file a factor is the bytes of its struct, under its C++ name: readable by programs of the same struct and the same compiler
// conventions. A factor that owns memory (a vector, a string) cannot be written.
#pragma once

#include <holdfast/graph/batch.hpp>

namespace holdfast {

struct FactorType {
  std::string name;   ///< "holdfast::Prior<holdfast::Pose2T<double> >"
  std::size_t bytes;  ///< of the struct; 0: it owns memory
  std::unique_ptr<FactorBatch> (*make)(const Loss& loss);
  const void* (*at)(const FactorBatch& batch, int i);
  void (*push)(FactorBatch& batch, const void* factor);
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
FactorType factor_type() {
  return {demangled(typeid(F)),
          std::is_trivially_destructible_v<F> ? sizeof(F) : 0,
          [](const Loss& loss) -> std::unique_ptr<FactorBatch> { return std::make_unique<Batch<F>>(loss); },
          [](const FactorBatch& batch, int i) -> const void* { return &static_cast<const Batch<F>&>(batch).factors()[i]; },
          [](FactorBatch& batch, const void* factor) {
            std::vector<F>& all = static_cast<Batch<F>&>(batch).factors();
            if constexpr (std::is_trivially_destructible_v<F>) {
              alignas(F) unsigned char copy[sizeof(F)];
              std::memcpy(copy, factor, sizeof(F));
              all.push_back(*reinterpret_cast<const F*>(copy));
            }
          },
          raw_residual<F>};
}

template <class F>
inline const bool factor_type_is_entered = enter_factor_type(typeid(F), factor_type<F>());

}  // namespace detail
}  // namespace holdfast
