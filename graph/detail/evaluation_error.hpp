// What went wrong while factors were evaluated by code that may fail: functions of another language, as factors
// (graph/function_factor.hpp) or as losses.
#pragma once

#include <holdfast/graph/batch.hpp>

namespace holdfast::detail {

/// A loss of the user's (Loss::own) whose evaluation may fail: its ρ is not a number then, and it remembers why.
class FallibleLoss {
 public:
  /// Since it was last asked, and forgets it; "": nothing. Any number of threads may ask.
  virtual std::string take_error() const = 0;

 protected:
  ~FallibleLoss() = default;
};

/// Of the batch's factors and losses.
std::string take_error(const FactorBatch& batch);

}  // namespace holdfast::detail
