#include "good_citizen.hpp"

namespace holdfast::testing {
TEST(Samples, LinearFactorsAreExact) { expect_good_citizens<LinearFactors>(); }
}  // namespace holdfast::testing
