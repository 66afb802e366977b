// What a solution may not depend on: the order and the history of a graph, the place of the world's origin, the unit of the weights.
#include "tests/problems.hpp"
#include "tests/properties.hpp"

namespace holdfast {
namespace {

using properties::any_rng;
using properties::decades;
using testing::largest_difference;
using testing::solve;

constexpr Agent P('P');

/// A factor on points, not yet in a graph. Priors and steps with the squared loss: one minimum, whatever is left out.
struct Term {
  int first, second;  ///< second < 0: a prior
  Point2 mean;
  double sigma;
  double weight;
};

FactorId add(Graph& graph, const Term& term, double scale = 1) {
  const auto key = [](int i) { return P(static_cast<std::uint64_t>(i)); };
  if (term.second < 0)
    return graph.add(Prior<Point2>::from_sigmas(term.mean, Vector<2>::Constant(term.sigma)), {key(term.first)}, Squared{},
                     scale * term.weight);
  return graph.add(PositionStep<Point2, Point2>{term.sigma}, {key(term.first), key(term.second)}, Squared{}, scale * term.weight);
}

struct Problem {
  std::vector<Term> terms;  ///< the first ones hold each point
  Values start;
};

Problem any_problem(std::mt19937_64& rng) {
  const int points = *rc::gen::inRange(1, 12).as("points"), steps = *rc::gen::inRange(0, 30).as("steps");
  Problem problem;
  for (int i = 0; i < points; ++i) {
    problem.start.insert(P(static_cast<std::uint64_t>(i)), Point2(testing::random_vector<2>(rng, 20)));
    problem.terms.push_back(
        {i, -1, Point2(testing::random_vector<2>(rng, 10)), testing::uniform(rng, 0.5, 5), testing::uniform(rng, 0.2, 3)});
  }
  for (int i = 0; i < steps && points > 1; ++i) {
    const int first = static_cast<int>(rng() % static_cast<unsigned>(points)),
              second = static_cast<int>(rng() % static_cast<unsigned>(points));
    if (first != second) problem.terms.push_back({first, second, {}, testing::uniform(rng, 0.2, 3), testing::uniform(rng, 0.2, 3)});
  }
  return problem;
}

Graph graph_of(const std::vector<Term>& terms, double scale = 1) {
  Graph graph;
  for (const Term& term : terms) add(graph, term, scale);
  return graph;
}

Values solved(const Graph& graph, Values values) {
  RC_ASSERT(solve("irls", graph, values).termination == Termination::converged);
  return values;
}

RC_GTEST_PROP(SolveProperties, OrderDoesNotMatter, ()) {
  std::mt19937_64 rng = any_rng();
  const Problem problem = any_problem(rng);
  std::vector<Term> shuffled = problem.terms;
  std::shuffle(shuffled.begin(), shuffled.end(), rng);
  std::vector<Key> keys = problem.start.keys();
  std::shuffle(keys.begin(), keys.end(), rng);
  Values start;
  for (Key key : keys) start.insert(key, problem.start.at<Point2>(key));
  const Values here = solved(graph_of(problem.terms), problem.start), there = solved(graph_of(shuffled), start);
  RC_ASSERT(largest_difference(here, there) < 1e-9);
}

// Adds and removes in any order; a solver that is kept over the changes.
RC_GTEST_PROP(SolveProperties, HistoryDoesNotMatter, ()) {
  std::mt19937_64 rng = any_rng();
  const Problem problem = any_problem(rng);
  const auto backend = make_backend("irls", testing::to_the_bottom());
  Graph graph;
  std::vector<std::pair<FactorId, std::size_t>> inside;
  const int changes = *rc::gen::inRange(1, 60).as("changes");
  for (int i = 0; i < changes; ++i) {
    if (!inside.empty() && rng() % 3 == 0) {
      std::swap(inside[rng() % inside.size()], inside.back());
      graph.remove(inside.back().first);
      inside.pop_back();
    } else {
      const std::size_t which = rng() % problem.terms.size();
      inside.emplace_back(add(graph, problem.terms[which]), which);
    }
    Values scratch = problem.start;
    if (rng() % 8 == 0 && graph.size() > 0) backend->solve(graph, scratch);
  }
  for (std::size_t point = 0; point < problem.start.size(); ++point) inside.emplace_back(add(graph, problem.terms[point]), point);
  std::vector<Term> terms;
  for (const auto& [id, which] : inside) terms.push_back(problem.terms[which]);
  const Graph fresh = graph_of(terms);
  RC_ASSERT(std::abs(graph.cost(problem.start) - fresh.cost(problem.start)) <= 1e-12 * fresh.cost(problem.start));
  Values lived = problem.start;
  RC_ASSERT(backend->solve(graph, lived).usable());
  RC_ASSERT(largest_difference(lived, solved(fresh, problem.start)) < 1e-9);
}

RC_GTEST_PROP(SolveProperties, AFactorOfAllWeightsScalesTheCostAlone, ()) {
  std::mt19937_64 rng = any_rng();
  const Problem problem = any_problem(rng);
  const double scale = decades(-3, 3);
  const Graph one = graph_of(problem.terms), other = graph_of(problem.terms, scale);
  RC_ASSERT(std::abs(other.cost(problem.start) - scale * one.cost(problem.start)) <= 1e-12 * other.cost(problem.start));
  RC_ASSERT(largest_difference(solved(one, problem.start), solved(other, problem.start)) < 1e-8);
}

RC_GTEST_PROP(SolveProperties, FixingAVariableAtItsAnswerMovesNoOther, ()) {
  std::mt19937_64 rng = any_rng();
  const Problem problem = any_problem(rng);
  RC_PRE(problem.start.size() > 1);
  Graph graph = graph_of(problem.terms);
  const Values answer = solved(graph, problem.start);
  const Key key = P(rng() % problem.start.size());
  graph.fix(key);
  Values start = problem.start;
  start.update(key, answer.at<Point2>(key));
  RC_ASSERT(largest_difference(solved(graph, start), answer) < 1e-8);
}

template <class V>
void expect_rigid_motion_moves_the_answer_along() {
  using Point = std::conditional_t<V::space_dim == 2, Point2, Point3>;
  std::mt19937_64 rng = any_rng();
  const auto problem = testing::slam<V>(rng(), 6, 0.05, *rc::gen::element<Loss>(Squared{}, Huber{2}, PseudoHuber{1}));
  const double far = decades(0, 5);
  testing::Motion<V::space_dim> world;
  const V there = V{}.retract(testing::random_vector<V::dim>(rng, 3));
  world.R = there.rotation();
  world.t = testing::random_vector<V::space_dim>(rng, far);
  Graph graph = problem.graph;
  for (std::size_t b = 0; b < graph.batches().size(); ++b)
    if (graph.batches()[b]->factor_type() == typeid(Prior<V>)) {
      Prior<V>& prior = graph.at<Prior<V>>(graph.id_of(static_cast<int>(b), 0));
      prior.mean = moved(world, prior.mean);
    }
  Values here = problem.start, shifted;
  for (Key key : here.keys())
    if (here.contains<V>(key))
      shifted.insert(key, moved(world, here.at<V>(key)));
    else
      shifted.insert(key, moved(world, here.at<Point>(key)));
  const double cost = problem.graph.cost(here);
  RC_ASSERT(std::abs(graph.cost(shifted) - cost) <= 1e-13 * far * 100 * (1 + cost));
  RC_ASSERT(solve("irls", problem.graph, here).usable() && solve("irls", graph, shifted).usable());
  RC_ASSERT(std::abs(graph.cost(shifted) - problem.graph.cost(here)) <= 1e-6 * (1 + problem.graph.cost(here)));
}

RC_GTEST_PROP(SolveProperties, ARigidMotionOfTheWorldMovesTheAnswerAlong, ()) {
  expect_rigid_motion_moves_the_answer_along<Pose2>();
  expect_rigid_motion_moves_the_answer_along<Pose3>();
}

}  // namespace
}  // namespace holdfast
