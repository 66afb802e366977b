#include "test_backends.hpp"

namespace holdfast::testing {
using RangeOnPairs = OnPairs<Range>;
HOLDFAST_CONFORMANCE_TESTS(RangeOnPairs)
}  // namespace holdfast::testing
