// How sure an answer is of where a variable is.
#pragma once

#include <holdfast/solvers/marginals.hpp>
#include <optional>

namespace holdfast::common {

/// space × space, world frame [m²]; `marginals` are at `answer`. std::nullopt: the variable has no position, the factors leave it free, or
/// none touches it. A variable that is held fixed has zeros.
std::optional<Eigen::MatrixXd> position_covariance(const Marginals& marginals, const Values& answer, Key key);

}  // namespace holdfast::common
