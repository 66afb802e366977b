#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <holdfast/graph/values.hpp>
#include <map>
#include <random>

namespace other_library {
struct Pose {
  double x, y, theta;
};
}  // namespace other_library

namespace holdfast {

template <>
struct StandsFor<other_library::Pose> {
  using type = Pose2;
  static Pose2 ours(const other_library::Pose& pose) { return {pose.x, pose.y, pose.theta}; }
  static other_library::Pose theirs(const Pose2& pose) { return {pose.p[0], pose.p[1], pose.angle()}; }
};

namespace {

using ::testing::HasSubstr;

constexpr Agent A('A'), B('B');

template <class Fn>
std::string message_of(const Fn& fn) {
  try {
    fn();
  } catch (const Error& error) {
    return error.what();
  }
  return "nothing was thrown";
}

Values some_values() {
  Values values;
  values.insert(A(0), Pose2(1, 2, 0.5));
  values.insert(A(1), Pose2(3, 4, 1));
  values.insert(B(0), Point3(1, 2, 3));
  return values;
}

TEST(Values, HoldsWhatWasInserted) {
  Values values = some_values();
  EXPECT_EQ(values.size(), 3u);
  EXPECT_EQ(values.at<Point3>(B(0)).value, Vector<3>(1, 2, 3));
  EXPECT_DOUBLE_EQ(values.at<Pose2>(A(1)).angle(), 1);
  values.at<Point3>(B(0)).value[2] = 9;
  values.update(A(0), Pose2(7, 7, 0));
  EXPECT_EQ(values.at<Point3>(B(0)).value[2], 9);
  EXPECT_EQ(values.at<Pose2>(A(0)).p, Vector<2>(7, 7));
  EXPECT_TRUE(values.contains(A(0)));
  EXPECT_TRUE(values.contains<Pose2>(A(0)));
  EXPECT_FALSE(values.contains<Point2>(A(0)));
  EXPECT_FALSE(values.contains(A(2)));
}

TEST(Values, TakesAndGivesWhatStandsForOneOfOurs) {
  Values values;
  values.insert(A(3), other_library::Pose{1, 2, 0.5});
  EXPECT_EQ(values.at<Pose2>(A(3)).p, Vector<2>(1, 2));
  values.at<Pose2>(A(3)).p[0] = 4;
  EXPECT_EQ(values.at<other_library::Pose>(A(3)).x, 4);
  values.update(A(3), other_library::Pose{7, 8, -0.5});
  const Values& unchanged = values;
  EXPECT_DOUBLE_EQ(unchanged.at<other_library::Pose>(A(3)).theta, -0.5);
  EXPECT_THROW(values.insert(A(3), other_library::Pose{}), BadKey);
}

TEST(Values, KeysAreSortedOverAllTypes) {
  Values values;
  values.insert(B(1), Point2(0, 0));
  values.insert(A(7), Pose3());
  values.insert(B(0), Scalar(1));
  values.insert(A(3), Point2(0, 0));
  EXPECT_EQ(values.keys(), (std::vector<Key>{A(3), A(7), B(0), B(1)}));
}

TEST(Values, MissingKeyIsNamedWithItsType) {
  const Values values = some_values();
  const std::string message = message_of([&] { values.at<Motion2>(A(9)); });
  EXPECT_THAT(message, HasSubstr("A9"));
  EXPECT_THAT(message, HasSubstr("Motion2"));
  EXPECT_THROW(values.at<Motion2>(A(9)), BadKey);
  EXPECT_THROW(values.slot(A(9)), BadKey);
  EXPECT_THROW(Values().erase(A(9)), BadKey);
  EXPECT_THROW(Values().update(A(9), Point2(0, 0)), BadKey);
}

TEST(Values, WrongTypeIsNamedWithBothTypes) {
  const Values values = some_values();
  const std::string message = message_of([&] { values.at<Pose3>(A(1)); });
  EXPECT_THAT(message, HasSubstr("A1"));
  EXPECT_THAT(message, HasSubstr("Pose2"));
  EXPECT_THAT(message, HasSubstr("Pose3"));
  EXPECT_THROW(values.at<Pose3>(A(1)), BadType);
}

TEST(Values, KeyIsTakenOnce) {
  Values values = some_values();
  EXPECT_THROW(values.insert(A(0), Pose2()), BadKey);
  EXPECT_THROW(values.insert(A(0), Point2()), BadKey);
  EXPECT_THAT(message_of([&] { values.insert(A(0), Point2()); }), HasSubstr("A0"));
  EXPECT_THAT(message_of([&] { values.insert(A(0), Point2()); }), HasSubstr("Pose2"));
  EXPECT_EQ(values.size(), 3u);
  EXPECT_EQ(values.at<Pose2>(A(0)).p, Vector<2>(1, 2));
}

TEST(Values, CopyIsIndependent) {
  const Values original = some_values();
  Values copy = original;
  copy.at<Point3>(B(0)).value[0] = 100;
  copy.insert(B(1), Point3(0, 0, 0));
  copy.erase(A(0));
  EXPECT_EQ(original.at<Point3>(B(0)).value[0], 1);
  EXPECT_EQ(original.size(), 3u);
  EXPECT_TRUE(original.contains(A(0)));
}

TEST(Values, AssignmentTakesStructureAndNumbers) {
  const Values original = some_values();
  Values other;
  other.insert(A(0), Scalar(1));
  other = original;
  EXPECT_EQ(other.keys(), original.keys());
  EXPECT_EQ(other.at<Point3>(B(0)).value, Vector<3>(1, 2, 3));
  other.at<Point3>(B(0)).value[0] = 5;
  other = original;
  EXPECT_EQ(other.at<Point3>(B(0)).value[0], 1);
  EXPECT_EQ(original.structure(), other.structure());
}

TEST(Values, AssignmentForgetsKeysThatTheOtherDoesNotHave) {
  const Values original = some_values();
  Values other;  // the same types, other keys
  other.insert(A(1), Pose2(9, 9, 0));
  other.insert(A(7), Pose2(8, 8, 0));
  other.insert(B(5), Point3(0, 0, 0));
  other = original;
  EXPECT_EQ(other.keys(), original.keys());
  EXPECT_EQ(other.structure(), original.structure());
  EXPECT_EQ(other.at<Pose2>(A(0)).p, Vector<2>(1, 2));
  EXPECT_EQ(other.at<Pose2>(A(1)).p, Vector<2>(3, 4));
  EXPECT_EQ(other.at<Point3>(B(0)).value, Vector<3>(1, 2, 3));
  EXPECT_FALSE(other.contains(A(7)));
  EXPECT_THROW(other.at<Point3>(B(5)), BadKey);
  other.insert(A(7), Pose2(5, 5, 0));
  other.erase(A(0));
  EXPECT_EQ(other.at<Pose2>(A(7)).p, Vector<2>(5, 5));
  EXPECT_EQ(other.at<Pose2>(A(1)).p, Vector<2>(3, 4));
  EXPECT_EQ(original.size(), 3u);
}

TEST(Values, StampChangesWithTheKeysOnly) {
  Values values = some_values();
  const auto before = values.structure();
  values.at<Pose2>(A(0)).p[0] = 8;
  values.update(A(1), Pose2());
  EXPECT_EQ(values.structure(), before);
  EXPECT_EQ(Values(values).structure(), before);
  values.insert(A(2), Pose2());
  const auto more = values.structure();
  EXPECT_NE(more, before);
  values.erase(A(2));
  EXPECT_NE(values.structure(), before);  // the same keys again, but who knows in which slots
  EXPECT_NE(values.structure(), more);
  EXPECT_NE(Values().structure(), Values().structure());
}

// The promise of structure(): the same stamp, the same keys in the same slots.
TEST(Values, MovedFromIsAsGoodAsNew) {
  Values source = some_values();
  const Values target = std::move(source);
  EXPECT_EQ(target.size(), 3u);
  source = target;  // NOLINT: assigning to a moved-from object is legal
  EXPECT_EQ(source.size(), 3u);
  ASSERT_EQ(source.keys(), target.keys());
  EXPECT_EQ(source.at<Point3>(B(0)).value, Vector<3>(1, 2, 3));
}

TEST(Values, FailedInsertLeavesCopiesExchangeable) {
  Values values = some_values();
  const Values copy = values;
  EXPECT_THROW(values.insert(A(0), Scalar(1)), BadKey);  // the first Scalar there ever was
  EXPECT_EQ(values.pools().size(), copy.pools().size());
  if (values.structure() == copy.structure() && values.pools().size() != copy.pools().size())
    return;  // assigning would read beyond the pools
  values.at<Point3>(B(0)).value[0] = 77;
  values = copy;
  EXPECT_EQ(values.at<Point3>(B(0)).value[0], 1);
}

TEST(Values, PoolKeepsOneTypeSideBySide) {
  const Values values = some_values();
  const Pose2* poses = values.data<Pose2>();
  ASSERT_NE(poses, nullptr);
  EXPECT_EQ(poses[values.slot(A(0)).index].p, Vector<2>(1, 2));
  EXPECT_EQ(poses[values.slot(A(1)).index].p, Vector<2>(3, 4));
  EXPECT_EQ(values.data<Motion3>(), nullptr);
  EXPECT_EQ(values.pool(values.slot(A(0)).pool).ambient(), 4);
  EXPECT_EQ(values.pool(values.slot(B(0)).pool).space(), 3);
}

/// The naive model: one map a type.
class Model {
 public:
  explicit Model(std::uint64_t seed) : rng_(seed) {}

  void step() {
    const Key key = A(rng_() % 40);
    const bool known = points_.count(key) + poses_.count(key) > 0;
    const double x = static_cast<double>(rng_() % 1000);
    if (known && rng_() % 2 == 0) {
      values_.erase(key);
      points_.erase(key);
      poses_.erase(key);
    } else if (known) {
      EXPECT_THROW(values_.insert(key, Point2(x, x)), BadKey);
      if (points_.count(key) != 0) values_.at<Point2>(key) = points_[key] = Point2(x, 0);
    } else if (rng_() % 2 == 0) {
      values_.insert(key, points_[key] = Point2(x, -x));
    } else {
      values_.insert(key, poses_[key] = Pose2(x, 1, 0.3));
    }
  }
  void expect_equal() const {
    ASSERT_EQ(values_.size(), points_.size() + poses_.size());
    for (const auto& [key, point] : points_) ASSERT_EQ(values_.at<Point2>(key).value, point.value) << key;
    for (const auto& [key, pose] : poses_) ASSERT_EQ(values_.at<Pose2>(key).p, pose.p) << key;
    for (const auto& pool : values_.pools())
      for (int i = 0; i < pool->size(); ++i) ASSERT_EQ(values_.slot(pool->keys()[i]).index, i);
  }

 private:
  std::mt19937_64 rng_;
  Values values_;
  std::map<Key, Point2> points_;
  std::map<Key, Pose2> poses_;
};

TEST(Values, AgreesWithANaiveModelUnderRandomChanges) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    Model model(seed);
    for (int i = 0; i < 2000; ++i) {
      model.step();
      if (i % 20 == 0) model.expect_equal();
    }
  }
}

TEST(Values, VisitsTheVariablesOfAType) {
  Values values;
  values.insert(Key('A', 2), Point2(1, 2));
  values.insert(Key('A', 0), Pose2(9, 9, 0));
  values.insert(Key('A', 1), Point2(10, 20));
  std::map<Key, double> seen;
  values.for_each<Point2>([&](Key key, const Point2& point) { seen[key] = point.y(); });
  EXPECT_EQ(seen, (std::map<Key, double>{{Key('A', 2), 2}, {Key('A', 1), 20}}));
  values.for_each<Pose3>([](Key, const Pose3&) { FAIL() << "there is none"; });
}

}  // namespace
}  // namespace holdfast
