#include <holdfast/common/position_covariance.hpp>

namespace holdfast::common {
namespace {

/// d position / d tangent of one variable, by central differences: exact enough for a picture.
Eigen::MatrixXd position_jacobian(const PoolBase& pool, int index) {
  constexpr double kStep = 1e-6;
  const std::unique_ptr<PoolBase> moved = pool.clone();
  Eigen::MatrixXd J(pool.space(), pool.dim());
  Eigen::VectorXd ahead(pool.space()), behind(pool.space()), delta = Eigen::VectorXd::Zero(pool.dim());
  for (int i = 0; i < pool.dim(); ++i) {
    delta[i] = kStep;
    moved->retract(index, pool, delta.data());
    moved->position(index, ahead.data());
    delta[i] = -kStep;
    moved->retract(index, pool, delta.data());
    moved->position(index, behind.data());
    delta[i] = 0;
    J.col(i) = (ahead - behind) / (2 * kStep);
  }
  return J;
}

}  // namespace

std::optional<Eigen::MatrixXd> position_covariance(const Marginals& marginals, const Values& answer, Key key) {
  const Values::Slot& slot = answer.slot(key);
  const PoolBase& pool = answer.pool(slot.pool);
  if (pool.space() == 0) return std::nullopt;
  std::vector<double> covariance;
  try {
    covariance = marginals.covariance(key);
  } catch (const UnobservableError&) {
    return std::nullopt;
  } catch (const BadKey&) {  // touched by no factor
    return std::nullopt;
  }
  const Eigen::MatrixXd J = position_jacobian(pool, slot.index);
  return J * Eigen::Map<const Eigen::MatrixXd>(covariance.data(), pool.dim(), pool.dim()) * J.transpose();
}

}  // namespace holdfast::common
