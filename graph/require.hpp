// The rules that factors state about their own numbers; Graph::add calls a factor's validate(), which uses these.
#pragma once

#include <holdfast/graph/error.hpp>
#include <holdfast/graph/math.hpp>

namespace holdfast {

inline void require_finite(const char* what, double value) {
  if (!std::isfinite(value)) fail<BadNumber>(what, " = ", value, " is not finite; leave the measurement out, or repair its source");
}

template <class Derived>
void require_finite(const char* what, const Eigen::DenseBase<Derived>& value) {
  if (!value.derived().array().isFinite().all())
    fail<BadNumber>(what, " = [", value.derived().transpose(), "] is not finite; leave the measurement out, or repair its source");
}

inline void require_positive(const char* what, double value) {
  if (!(std::isfinite(value) && value > 0))
    fail<BadNumber>(what, " = ", value, " must be finite and > 0; give the standard deviation in the unit of the measurement");
}

inline void require_not_negative(const char* what, double value) {
  if (!(std::isfinite(value) && value >= 0)) fail<BadNumber>(what, " = ", value, " must be finite and >= 0");
}

template <class Derived>
void require_positive(const char* what, const Eigen::DenseBase<Derived>& sigmas) {
  for (Eigen::Index i = 0; i < sigmas.size(); ++i) require_positive(what, sigmas.derived().coeff(i));
}

}  // namespace holdfast
