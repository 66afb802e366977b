#include "good_citizen.hpp"

namespace holdfast::testing {
TEST(Samples, DirectionFactorsAreExact) { expect_good_citizens<DirectionFactors>(); }
}  // namespace holdfast::testing
