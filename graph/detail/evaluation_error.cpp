#include <holdfast/graph/detail/evaluation_error.hpp>

namespace holdfast::detail {

std::string take_error(const FactorBatch& batch) {
  std::string error = batch.take_error();
  if (batch.family().kind != Loss::Kind::Own) return error;
  const int losses = batch.has_one_loss() ? 1 : batch.size();
  for (int i = 0; i < losses; ++i)
    if (const auto* loss = dynamic_cast<const FallibleLoss*>(batch.loss(i).own.get())) {
      const std::string of_loss = loss->take_error();
      if (error.empty()) error = of_loss;
    }
  return error;
}

}  // namespace holdfast::detail
