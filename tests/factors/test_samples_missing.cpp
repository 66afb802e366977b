#include "good_citizen.hpp"

namespace holdfast::testing {
TEST(Samples, MissingFactorsAreExact) { expect_good_citizens<MissingFactors>(); }
}  // namespace holdfast::testing
