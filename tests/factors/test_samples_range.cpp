#include "good_citizen.hpp"

namespace holdfast::testing {
TEST(Samples, RangeFactorsAreExact) { expect_good_citizens<RangeFactors>(); }
}  // namespace holdfast::testing
