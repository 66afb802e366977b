#include <algorithm>
#include <holdfast/benchmarks/papers/lifted_map.hpp>
#include <holdfast/benchmarks/papers/lifted_table.hpp>
#include <holdfast/benchmarks/papers/missing_map.hpp>
#include <holdfast/solvers/table.hpp>

namespace holdfast::bench {
namespace {

constexpr double kGap = 1e-6;  // of the least cost
constexpr int kMost = 20000;
constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

enum class Way { printed, lifted, nesterov, newton };

/// What a solver's trace needs to come within the gap; a limit on the iterations, raised until it does, tells it to one.
int iterations_of(const std::string& backend, const MapProblem& problem, double target) {
  Options options;
  options.cost_tolerance = 0;
  for (int most = 1; most <= 1000; ++most) {
    options.max_iterations = most;
    Values values = problem.start;
    if (make_backend(backend, options)->solve(problem.graph, values).cost <= target) return most;
  }
  return kMost;
}

template <int S>
int iterations_of(LiftedSteps steps, const Network<S>& network, const MapProblem& problem, double target) {
  Values values = problem.start;
  const int nodes = static_cast<int>(network.steps[0].nodes.size());
  return LiftedMap<S>(network, Missing::nothing).minimize(steps, kMost, [&](const Eigen::VectorXd& x) {
    for (int i = 0; i < x.size() / S; ++i) values.at<Kinematic<double, S, 1>>(node_key(i % nodes, i / nodes)).value = x.segment<S>(S * i);
    return problem.graph.cost(values) <= target;
  });
}

template <int S>
double iterations(const NetworkOptions& options, unsigned seed, Way way) {
  const Network<S> network = make_network<S>(options, seed);
  const MapProblem problem = map_problem(network, Missing::nothing);
  Options tight;
  tight.cost_tolerance = 1e-14;
  Values values = problem.start;
  const double target = (1 + kGap) * make_backend("irls", tight)->solve(problem.graph, values).cost;
  switch (way) {
    case Way::printed:
      return iterations_of(LiftedSteps::printed, network, problem, target);
    case Way::lifted:
      return iterations_of(LiftedSteps::restarted, network, problem, target);
    default:
      return iterations_of(way == Way::nesterov ? "nesterov" : "irls", problem, target);
  }
}

}  // namespace

PaperTable lifted_table() {
  struct Case {
    NetworkOptions options;
    unsigned seed;
  };
  std::vector<NetworkOptions> columns;
  std::vector<std::string> names;
  for (const bool whole : {false, true})
    for (const Course course : {Course::linear, Course::spiral, Course::non_formation, Course::helix}) {
      NetworkOptions options;
      options.course = course;
      options.steps = 10;
      options.whole_network = whole;
      columns.push_back(options);
      names.push_back(to_string(course) + std::string(whole ? ", network" : ", edges"));
    }
  std::vector<Contender<Case>> contenders;
  const auto enter = [&](const char* name, Way way) {
    contenders.push_back({{{name}}, [way](const Case& one) {
                            const double n = one.options.course == Course::helix ? iterations<3>(one.options, one.seed, way)
                                                                                 : iterations<2>(one.options, one.seed, way);
                            return std::vector<Score>{{n, kNone}};
                          }});
  };
  enter("lifted, constants as printed (35)(37)", Way::printed);
  enter("lifted, L of M, restarts, cone", Way::lifted);
  enter("eliminated, nesterov", Way::nesterov);
  enter("eliminated, Newton (irls)", Way::newton);
  PaperTable made = table_of<Case>(
      "iterations",
      "Ten steps, half of the packets lost (each edge its own, or all of a step), all steps together, a random walk. Iterations until the "
      "cost of the eliminated form is within 1e-6 of the least, from the middle of the anchors; 20000: not in so many.",
      names,
      [columns](std::size_t column, unsigned seed) {
        return Case{columns[column], seed};
      },
      contenders);
  made.most_runs = 5;
  return made;
}

}  // namespace holdfast::bench
