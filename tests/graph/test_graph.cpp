#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>

#include "tests/problems.hpp"

namespace holdfast {
namespace {

using ::testing::HasSubstr;

constexpr Agent A('A'), L('L');
using PointRange = Range<Point2, Point2>;
using PointBall = RangeBall<Point2, Point2>;
using PointPrior = Prior<Point2>;

PointPrior prior_at(double x, double y) { return PointPrior::from_sigmas(Point2(x, y), Vector<2>(1, 1)); }

template <class E, class Fn>
std::string message_of(const Fn& fn) {
  try {
    fn();
  } catch (const E& error) {
    return error.what();
  }
  return "nothing was thrown";
}

Values square() {
  Values values;
  values.insert(A(0), Point2(0, 0));
  values.insert(A(1), Point2(3, 4));
  values.insert(L(0), Point2(6, 8));
  return values;
}

TEST(Graph, CostIsTheSumOfItsTerms) {
  Graph graph;
  graph.add(PointRange{4, 0.5}, {A(0), A(1)});              // r = 2
  graph.add(PointRange{2, 1}, {A(1), L(0)}, Huber{2});      // r = 3: ρ = 2·2·3 − 4
  graph.add(PointRange{10, 0.1}, {A(0), L(0)}, Squared{});  // r = 0
  graph.add(prior_at(0, 2), {A(0)}, Squared{}, 5);          // ‖r‖² = 4, five times
  EXPECT_DOUBLE_EQ(graph.cost(square()), 0.5 * (4 + 8 + 0 + 5 * 4));
  EXPECT_EQ(Graph().cost(square()), 0);
}

TEST(Graph, BatchesByTypeAndFamilyOfLosses) {
  Graph graph;
  for (int i = 0; i < 3; ++i) graph.add(PointRange{1, 1}, {A(0), A(1)}, Huber{2});
  graph.add(PointRange{1, 1}, {A(0), A(1)}, Cauchy{2});
  graph.add(PointRange{1, 1}, {A(0), A(1)}, per_component(Huber{2}));
  graph.add(prior_at(0, 0), {A(0)}, Huber{2});
  ASSERT_EQ(graph.batches().size(), 4u);
  EXPECT_EQ(graph.batches()[0]->size(), 3);
  EXPECT_EQ(graph.batches()[0]->name(), "Range");
  EXPECT_EQ(graph.batches()[0]->describe(1), "Range(A0, A1)");
  EXPECT_FALSE(graph.batches()[0]->is_linear());
  EXPECT_TRUE(graph.batches()[3]->is_linear());
  EXPECT_EQ(graph.size(), 6u);
}

TEST(Graph, TakesAFactorsOwnLossAndWeight) {
  Graph graph;
  const auto measurement = HuberMeasurement<Point2>::of_position({0, 0}, {0, 0}, Matrix<2, 2>(Matrix<2, 2>::Identity()), 0.5);
  graph.add(measurement, {A(0)});
  EXPECT_EQ(graph.batches()[0]->family(), per_component(Huber{2}));
  EXPECT_EQ(graph.batches()[0]->weight(0), 0.5);
  graph.add(measurement, {A(0)}, Squared{}, 7);
  EXPECT_EQ(graph.batches()[1]->weight(0), 7);
}

TEST(Graph, NumbersMayChangeBetweenSolves) {
  Graph graph;
  const FactorId id = graph.add(PointRange{4, 0.5}, {A(0), A(1)});
  const auto structure = graph.structure();
  graph.at<PointRange>(id).distance = 5;
  EXPECT_EQ(graph.cost(square()), 0);
  EXPECT_EQ(graph.structure(), structure);
}

TEST(Graph, WrongFactorTypeIsNamed) {
  Graph graph;
  const FactorId id = graph.add(PointRange{4, 0.5}, {A(0), A(1)});
  const std::string message = message_of<BadType>([&] { graph.at<PointPrior>(id); });
  EXPECT_THAT(message, HasSubstr("Range(A0, A1)"));
  EXPECT_THAT(message, HasSubstr("Prior"));
}

TEST(Graph, RefusesAKeyThatOccursTwice) {
  Graph graph;
  const std::string message = message_of<BadKey>([&] { graph.add(PointRange{4, 0.5}, {A(7), A(7)}); });
  EXPECT_THAT(message, HasSubstr("Range(A7, A7)"));
  EXPECT_EQ(graph.size(), 0u);
}

TEST(Graph, RefusesABadWeightNamingTheFactor) {
  for (const double weight : {-1.0, static_cast<double>(NAN), static_cast<double>(INFINITY)}) {
    Graph graph;
    const std::string message = message_of<BadNumber>([&] { graph.add(PointRange{4, 0.5}, {A(0), A(1)}, Squared{}, weight); });
    EXPECT_THAT(message, HasSubstr("Range(A0, A1)"));
    EXPECT_THAT(message, HasSubstr("weight"));
    EXPECT_EQ(graph.size(), 0u);
  }
  Graph graph;
  graph.add(PointRange{4, 0.5}, {A(0), A(1)}, Squared{}, 0);
  EXPECT_EQ(graph.cost(square()), 0);
}

TEST(Graph, RefusesABadFactorNamingIt) {
  Graph graph;
  const std::string message = message_of<BadNumber>([&] { graph.add(PointRange{4, -0.5}, {A(0), A(1)}); });
  EXPECT_THAT(message, HasSubstr("Range(A0, A1)"));
  EXPECT_THAT(message, HasSubstr("sigma"));
  EXPECT_THAT(message, HasSubstr("-0.5"));
  EXPECT_EQ(graph.size(), 0u);
}

TEST(Graph, RefusesABadLoss) {
  Graph graph;
  EXPECT_THROW(graph.add(PointRange{4, 0.5}, {A(0), A(1)}, Huber{-2}), BadNumber);
  EXPECT_THROW(graph.add(prior_at(0, 0), {A(0)}, one_sided(Huber{2})), BadOption);
  EXPECT_EQ(graph.size(), 0u);
}

TEST(Graph, RemoveKeepsTheOtherIds) {
  Graph graph;
  std::vector<FactorId> ids;
  for (int i = 0; i < 5; ++i) ids.push_back(graph.add(PointRange{static_cast<double>(i), 1}, {A(0), A(1)}));
  graph.remove(ids[1]);
  EXPECT_FALSE(graph.contains(ids[1]));
  EXPECT_THROW(graph.at<PointRange>(ids[1]), BadKey);
  EXPECT_THROW(graph.remove(ids[1]), BadKey);
  for (const int i : {0, 2, 3, 4}) EXPECT_EQ(graph.at<PointRange>(ids[i]).distance, i);
  const FactorId fresh = graph.add(PointRange{9, 1}, {A(0), A(1)});
  EXPECT_FALSE(graph.contains(ids[1]));  // a number used again is another factor
  EXPECT_EQ(graph.at<PointRange>(fresh).distance, 9);
}

TEST(Graph, NobodysIdIsRefused) {
  Graph graph;
  EXPECT_FALSE(graph.contains(FactorId{}));
  EXPECT_THROW(graph.remove(FactorId{}), BadKey);
  EXPECT_THROW(graph.remove(FactorId{17, 0}), BadKey);
}

TEST(Graph, IdOfIsTheInverseOfPlace) {
  Graph graph;
  const FactorId first = graph.add(PointRange{1, 1}, {A(0), A(1)});
  const FactorId second = graph.add(PointRange{2, 1}, {A(0), A(1)});
  graph.remove(first);
  const Graph::Place& place = graph.place(second);
  EXPECT_EQ(place.index, 0);
  EXPECT_EQ(graph.id_of(place.batch, place.index).number, second.number);
  for (const int index : {-1, 1}) EXPECT_THROW(graph.id_of(place.batch, index), BadKey);
  for (const int batch : {-1, 1}) {
    EXPECT_THROW(graph.id_of(batch, 0), BadKey);
    EXPECT_THROW(graph.set_loss(batch, Huber{2}), BadKey);
  }
}

TEST(Graph, CopyIsIndependentAndIdsStayValidInIt) {
  Graph original;
  const FactorId id = original.add(PointRange{4, 1}, {A(0), A(1)});
  Graph copy = original;
  EXPECT_EQ(copy.structure(), original.structure());
  copy.at<PointRange>(id).distance = 1;
  copy.add(PointRange{4, 1}, {A(0), A(1)});
  copy.fix(A(0));
  EXPECT_EQ(original.at<PointRange>(id).distance, 4);
  EXPECT_EQ(original.size(), 1u);
  EXPECT_FALSE(original.is_fixed(A(0)));
  original = copy;
  EXPECT_EQ(original.size(), 2u);
  EXPECT_EQ(original.cost(square()), copy.cost(square()));
}

TEST(Graph, RelaxedReplacesWhatHasAConvexCounterpart) {
  Graph graph;
  const FactorId gone = graph.add(PointRange{1, 1}, {A(0), A(1)});
  const FactorId shorter = graph.add(PointRange{4, 0.5}, {A(0), A(1)}, Squared{}, 3);  // 1 m too far: r = 2
  const FactorId longer = graph.add(PointRange{11, 0.5}, {A(0), L(0)}, Huber{1});      // 1 m too near: the ball is content
  graph.add(prior_at(0, 2), {A(0)});
  const FactorId robust = graph.add(PointRange{3, 0.5}, {A(0), A(1)}, one_sided(Cauchy{1}));  // r = 4, squared on this side
  const FactorId student = graph.add(prior_at(3, 4), {A(1)}, per_component(StudentT{4}));     // r = 0
  graph.remove(gone);
  graph.fix(L(0));
  const Graph convex = graph.relaxed();
  EXPECT_EQ(convex.at<PointBall>(shorter).distance, 4);
  EXPECT_EQ(convex.at<PointBall>(longer).distance, 11);
  EXPECT_EQ(convex.batches()[convex.place(longer).batch]->family(), Loss(Huber{1}));
  EXPECT_EQ(convex.batches()[convex.place(robust).batch]->family(), Loss());
  EXPECT_EQ(convex.batches()[convex.place(student).batch]->family(), per_component(Huber{2}));
  EXPECT_EQ(convex.size(), graph.size());
  EXPECT_TRUE(convex.is_fixed(L(0)));
  EXPECT_NE(convex.structure(), graph.structure());
  EXPECT_DOUBLE_EQ(graph.cost(square()), 0.5 * (3 * 4 + 3 + 4 + 16));
  EXPECT_DOUBLE_EQ(convex.cost(square()), 0.5 * (3 * 4 + 0 + 4 + 16));
}

TEST(Graph, StampChangesWithEveryChangeOfStructure) {
  Graph graph;
  std::vector<std::uint64_t> stamps{graph.structure()};
  const auto expect_new = [&] {
    for (const auto stamp : stamps) EXPECT_NE(graph.structure(), stamp);
    stamps.push_back(graph.structure());
  };
  const FactorId id = graph.add(PointRange{4, 1}, {A(0), A(1)});
  expect_new();
  graph.fix(A(0));
  expect_new();
  graph.fix(A(0));
  EXPECT_EQ(graph.structure(), stamps.back());  // it was fixed already
  graph.unfix(A(0));
  expect_new();
  graph.remove(id);
  expect_new();
}

// r = (5 − distance) / 1 under Huber{a}: beyond a the cost is a|r| − ½a².
double huber_cost(double distance, double a) {
  const double r = std::abs(5 - distance);
  return r <= a ? 0.5 * r * r : a * r - 0.5 * a * a;
}
Values five_apart() {
  Values values;
  values.insert(A(0), Point2(0, 0));
  values.insert(A(1), Point2(3, 4));
  return values;
}

TEST(Graph, AThresholdPerFactorTakesNoBatch) {
  Graph graph;
  double expected = 0;
  for (int i = 1; i <= 20; ++i) {
    graph.add(PointRange{5.0 + i, 1}, {A(0), A(1)}, Huber{0.5 * i});
    expected += huber_cost(5.0 + i, 0.5 * i);
  }
  ASSERT_EQ(graph.batches().size(), 1u);
  EXPECT_FALSE(graph.batches()[0]->has_one_loss());
  for (int i = 0; i < 20; ++i) EXPECT_EQ(graph.batches()[0]->loss(i), Loss(Huber{0.5 * (i + 1)}));
  EXPECT_NEAR(graph.cost(five_apart()), expected, 1e-12);
  EXPECT_NEAR(Graph(graph).cost(five_apart()), expected, 1e-12);
  Graph one;
  for (int i = 0; i < 20; ++i) one.add(PointRange{6, 1}, {A(0), A(1)}, Huber{2});
  EXPECT_TRUE(one.batches()[0]->has_one_loss());
}

// What is removed takes its own weight and threshold with it, and nobody else's.
TEST(Graph, RemoveKeepsTheOthersWeightsAndLosses) {
  Graph graph;
  std::vector<FactorId> ids;
  for (int i = 0; i < 5; ++i) ids.push_back(graph.add(PointRange{9, 1}, {A(0), A(1)}, Huber{1.0 + i}, 10.0 + i));
  for (const int gone : {1, 4, 0}) {
    graph.remove(ids[gone]);
    for (int i = 0; i < 5; ++i) {
      if (!graph.contains(ids[i])) continue;
      const Graph::Place& place = graph.place(ids[i]);
      EXPECT_EQ(graph.batches()[place.batch]->weight(place.index), 10.0 + i);
      EXPECT_EQ(graph.batches()[place.batch]->loss(place.index), Loss(Huber{1.0 + i}));
    }
  }
  EXPECT_NEAR(graph.cost(five_apart()), 12 * huber_cost(9, 3) + 13 * huber_cost(9, 4), 1e-12);
}

TEST(Graph, SetLossOfOneFactorKeepsItsIdAndTheOthersLosses) {
  Graph graph;
  std::vector<FactorId> ids;
  for (int i = 0; i < 3; ++i) ids.push_back(graph.add(PointRange{9, 1}, {A(0), A(1)}, Huber{1}, 1.0 + i));
  const std::uint64_t before = graph.structure();
  graph.set_loss(ids[1], Huber{2});  // another threshold: the same structure
  EXPECT_EQ(graph.structure(), before);
  EXPECT_NEAR(graph.cost(five_apart()), 4 * huber_cost(9, 1) + 2 * huber_cost(9, 2), 1e-12);
  graph.set_loss(ids[0], Squared{});  // another family: another batch
  EXPECT_NE(graph.structure(), before);
  ASSERT_EQ(graph.batches().size(), 2u);
  EXPECT_NEAR(graph.cost(five_apart()), 8 + 2 * huber_cost(9, 2) + 3 * huber_cost(9, 1), 1e-12);
  for (int i = 0; i < 3; ++i) {
    const Graph::Place& place = graph.place(ids[i]);
    EXPECT_EQ(graph.batches()[place.batch]->weight(place.index), 1.0 + i);
    EXPECT_EQ(graph.id_of(place.batch, place.index).number, ids[i].number);
  }
  EXPECT_THROW(graph.set_loss(ids[2], Huber{-1}), BadNumber);
  graph.remove(ids[2]);
  EXPECT_THROW(graph.set_loss(ids[2], Huber{1}), BadKey);
}

/// Factors by hand, one after the other.
struct Model {
  std::mt19937_64 rng;
  Graph graph;
  std::map<int, std::pair<FactorId, double>> distances;  // of the ranges
  std::map<int, std::pair<FactorId, double>> priors;
  int next = 0;

  double number() { return testing::uniform(rng, 0, 10); }
  void step() {
    const auto kind = rng() % 5;
    if (kind == 0) {
      const double d = number();
      distances[next++] = {graph.add(PointRange{d, 1}, {A(0), A(1)}, rng() % 2 == 0 ? Loss(Squared{}) : per_component(Squared{})), d};
    } else if (kind == 1) {
      const double x = number();
      priors[next++] = {graph.add(prior_at(x, 0), {L(0)}), x};
    } else if (kind == 2 && !distances.empty()) {
      remove_one(distances);
    } else if (kind == 3 && !priors.empty()) {
      remove_one(priors);
    }
  }
  void remove_one(std::map<int, std::pair<FactorId, double>>& from) {
    const auto it = std::next(from.begin(), static_cast<std::ptrdiff_t>(rng() % from.size()));
    graph.remove(it->second.first);
    from.erase(it);
  }
  double cost() const {  // at square(): ‖a0 a1‖ = 5, l0 = (6, 8)
    double sum = 0;
    for (const auto& [n, d] : distances) sum += 0.5 * (5 - d.second) * (5 - d.second);
    for (const auto& [n, x] : priors) sum += 0.5 * ((6 - x.second) * (6 - x.second) + 64);
    return sum;
  }
};

TEST(Graph, AgreesWithANaiveModelUnderRandomChanges) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    Model model;
    model.rng.seed(seed);
    for (int i = 0; i < 1500; ++i) {
      model.step();
      ASSERT_EQ(model.graph.size(), model.distances.size() + model.priors.size());
      if (i % 50 != 0) continue;
      ASSERT_NEAR(model.graph.cost(square()), model.cost(), 1e-9);
      for (const auto& [n, d] : model.distances) ASSERT_EQ(model.graph.at<PointRange>(d.first).distance, d.second);
      for (const auto& [n, x] : model.priors) ASSERT_EQ(model.graph.at<PointPrior>(x.first).mean.value[0], x.second);
    }
  }
}

TEST(Graph, ForgetsNothingOfAnEmptiedBatch) {
  Graph graph;
  const FactorId id = graph.add(PointRange{4, 1}, {A(0), A(1)});
  graph.add(prior_at(0, 0), {A(0)});
  graph.remove(id);
  EXPECT_EQ(graph.cost(square()), 0);
  EXPECT_EQ(gradient(graph, square()).value, (std::vector<double>{0, 0}));
}

// ---- what a person asks of it

TEST(Graph, TellsTheResidualOfAFactor) {
  Graph graph;
  const FactorId range = graph.add(PointRange{4, 0.5}, {A(0), A(1)}, Huber{1}, 3);  // without loss and weight
  const FactorId prior = graph.add(prior_at(2, 1), {A(1)});
  EXPECT_EQ(graph.residual(range, square()), Vector<1>(2));
  EXPECT_EQ(graph.residual(prior, square()), Vector<2>(1, 3));
  EXPECT_THAT(message_of<BadKey>([&] { graph.residual(range, Values()); }), HasSubstr("A0"));
  Values poses = square();
  poses.erase(A(1));
  poses.insert(A(1), Pose2(3, 4, 0));
  EXPECT_THAT(message_of<BadType>([&] { graph.residual(range, poses); }), HasSubstr("A1 is a Pose2"));
  graph.remove(range);
  EXPECT_THROW(graph.residual(range, square()), BadKey);
}

TEST(Graph, TellsTheFactorsOnAVariable) {
  Graph graph;
  const FactorId first = graph.add(PointRange{4, 1}, {A(0), A(1)});
  const FactorId gone = graph.add(PointRange{5, 1}, {L(0), A(0)});
  const FactorId prior = graph.add(prior_at(2, 1), {A(0)});
  graph.add(prior_at(2, 1), {L(0)});
  graph.remove(gone);
  const std::vector<FactorId> on = graph.factors_on(A(0));
  ASSERT_EQ(on.size(), 2u);
  EXPECT_EQ(on[0].number, first.number);
  EXPECT_EQ(on[1].number, prior.number);
  EXPECT_TRUE(graph.contains(on[1]));
  EXPECT_TRUE(graph.factors_on(A(9)).empty());
}

}  // namespace
}  // namespace holdfast
