// A factor wants as many keys as it has variables: others do not compile, in a graph and in a window.
#include <gtest/gtest.h>

#include <holdfast/solvers/window/window.hpp>

#include "tests/problems.hpp"

namespace holdfast {
namespace {

template <class Host, class F, class... K>
struct CanAdd {
  template <class H>
  static auto test(H* host) -> decltype(host->add(std::declval<const F&>(), {std::declval<K>()...}), std::true_type{});
  static std::false_type test(...);
  static constexpr bool value = decltype(test(static_cast<Host*>(nullptr)))::value;
};

using PoseRange = Range<Pose2, Point2>;

template <class Host>
void expect_as_many_keys_as_variables() {
  EXPECT_TRUE((CanAdd<Host, Prior<Pose2>, Key>::value));
  EXPECT_TRUE((CanAdd<Host, PoseRange, Key, Key>::value));
  EXPECT_FALSE((CanAdd<Host, Prior<Pose2>>::value));
  EXPECT_FALSE((CanAdd<Host, Prior<Pose2>, Key, Key>::value));
  EXPECT_FALSE((CanAdd<Host, PoseRange>::value));
  EXPECT_FALSE((CanAdd<Host, PoseRange, Key>::value));
  EXPECT_FALSE((CanAdd<Host, PoseRange, Key, Key, Key>::value));
  EXPECT_FALSE((CanAdd<Host, PoseRange, Key, int>::value));  // no key
}

TEST(FactorKeys, AreAsManyAsVariablesInAGraph) { expect_as_many_keys_as_variables<Graph>(); }
TEST(FactorKeys, AreAsManyAsVariablesInAWindow) { expect_as_many_keys_as_variables<Window>(); }

TEST(FactorKeys, ComeFromAnArrayOfTheirSize) {
  EXPECT_TRUE((std::is_convertible_v<std::array<Key, 2>, FactorKeys<2>>));
  EXPECT_FALSE((std::is_constructible_v<FactorKeys<2>, std::array<Key, 1>>));
  EXPECT_FALSE(std::is_default_constructible_v<FactorKeys<1>>);
  Graph graph;
  const std::array<Key, 2> keys{Key('A', 0), Key('L', 1)};
  graph.add(PoseRange{1, 1}, keys);
  EXPECT_EQ(graph.batches()[0]->describe(0), "Range(A0, L1)");
}

}  // namespace
}  // namespace holdfast
