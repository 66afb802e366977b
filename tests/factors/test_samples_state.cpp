#include "good_citizen.hpp"

namespace holdfast::testing {
TEST(Samples, StateFactorsAreExact) { expect_good_citizens<StateFactors>(); }
}  // namespace holdfast::testing
