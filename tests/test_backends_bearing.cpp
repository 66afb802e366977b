#include "test_backends.hpp"

namespace holdfast::testing {
using BearingOnPairs = OnPairs<VonMisesBearing>;
HOLDFAST_CONFORMANCE_TESTS(BearingOnPairs)
}  // namespace holdfast::testing
