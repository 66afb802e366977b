// A ceres::Manifold from a struct with these members (vectors and matrices by pointer, matrices by columns):
//
//   int ambient() const, dim() const;
//   void plus(const double* x, const double* delta, double* out) const;      // x ⊕ δ
//   void minus(const double* y, const double* x, double* delta) const;       // y ⊖ x
//   void plus_jacobian(const double* x, double* P) const;                    // ambient × dim
//   void minus_jacobian(const double* x, double* M) const;                   // dim × ambient
#pragma once

#include <ceres/manifold.h>

#include <Eigen/Core>
#include <utility>

namespace holdfast {

template <class Geometry>
class CeresManifold final : public ceres::Manifold {
 public:
  explicit CeresManifold(Geometry geometry) : geometry_(std::move(geometry)) {}
  int AmbientSize() const override { return geometry_.ambient(); }
  int TangentSize() const override { return geometry_.dim(); }
  bool Plus(const double* x, const double* delta, double* out) const override {
    geometry_.plus(x, delta, out);
    return true;
  }
  bool PlusJacobian(const double* x, double* jacobian) const override {
    Eigen::MatrixXd P(AmbientSize(), TangentSize());
    geometry_.plus_jacobian(x, P.data());
    RowMajor(jacobian, P.rows(), P.cols()) = P;
    return true;
  }
  bool Minus(const double* y, const double* x, double* delta) const override {
    geometry_.minus(y, x, delta);
    return true;
  }
  bool MinusJacobian(const double* x, double* jacobian) const override {
    Eigen::MatrixXd M(TangentSize(), AmbientSize());
    geometry_.minus_jacobian(x, M.data());
    RowMajor(jacobian, M.rows(), M.cols()) = M;
    return true;
  }

 private:
  using RowMajor = Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>;
  Geometry geometry_;
};

}  // namespace holdfast
