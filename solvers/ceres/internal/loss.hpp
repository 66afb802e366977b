// A loss of a whole residual block as Ceres has it: total += ½ρ(s), with our ρ scaled by the weight of the term.
#pragma once

#include <ceres/loss_function.h>

#include <holdfast/graph/loss.hpp>

namespace holdfast {

class CeresLoss final : public ceres::LossFunction {
 public:
  /// d: components of the residual (StudentT asks for it).
  CeresLoss(const Loss& loss, double weight, int d) : loss_(loss), weight_(weight), d_(d) {}
  void Evaluate(double s, double out[3]) const override {
    const Rho rho = loss_.rho(s, d_);
    out[0] = weight_ * rho.value;
    out[1] = weight_ * rho.first;
    out[2] = weight_ * rho.second;
  }

 private:
  Loss loss_;
  double weight_;
  int d_;
};

}  // namespace holdfast
