// check_backend: does a back-end keep the contract of solvers/backend.hpp? For tests of yours (installed):
//
//   EXPECT_EQ(holdfast::testing::check_backend(MyBackend()), "");
//
// The answer is what is wrong, in words; empty where nothing is. It solves four small problems whose answers are known by hand (a linear
// one, a position by three ranges, a robust loss with an outlier, a fixed variable), and asks for errors. Checked: the answer; that the
// summary is what Graph::cost says of it; the same bits again from the same start; an empty graph, a missing variable and a residual that
// is not finite are refused with values as they were; the progress callback stops it.
#pragma once

#include <cstring>
#include <holdfast/factors/prior.hpp>
#include <holdfast/factors/range.hpp>
#include <holdfast/graph/variables.hpp>
#include <holdfast/solvers/backend.hpp>
#include <sstream>
#include <string>

namespace holdfast::testing {

namespace detail {

/// Templates, so that only a test that asks for them compiles them.
template <class Variable>
class BackendChecker {
 public:
  explicit BackendChecker(Backend& backend) : backend_(backend) {}

  std::string broken() {
    check_answer("two priors on a point", two_priors(), Variable(0.3, -7), Variable(1.5, 2), 0.25);
    check_answer("a position by three ranges", three_ranges(), Variable(2.5, 3.5), Variable(3, 4), 0);
    check_answer("a Huber loss with an outlier", outlier(), Variable(4, 1), Variable(0.5, 0), 9.25);
    check_fixed();
    check_refusals();
    check_stop();
    return text_.str();
  }

 private:
  static constexpr Agent X{'X'};

  static Prior<Variable> at(double x, double y) { return Prior<Variable>::from_sigmas(Variable(x, y), Vector<2>(1, 1)); }
  static Graph two_priors() {  // x = (1, 2) and (2, 2): in the middle, ½ (½² + ½²)
    Graph graph;
    graph.add(at(1, 2), {X(0)});
    graph.add(at(2, 2), {X(0)});
    return graph;
  }
  static Graph three_ranges() {  // from (0, 0), (6, 0) and (3, 0), which are fixed, to (3, 4)
    Graph graph;
    graph.add(Range<Variable, Variable>{5, 0.1}, {X(0), X(1)});
    graph.add(Range<Variable, Variable>{5, 0.1}, {X(0), X(2)});
    graph.add(Range<Variable, Variable>{4, 0.1}, {X(0), X(3)});
    for (int i = 1; i <= 3; ++i) graph.fix(X(i));
    return graph;
  }
  static Graph outlier() {  // 0, 0 and 10 with Huber{1}: 2 x = 1; ½ (¼ + ¼) + ½ (2 · 9.5 − 1)
    Graph graph;
    graph.add(at(0, 0), {X(0)});
    graph.add(at(0, 0), {X(0)});
    graph.add(at(10, 0), {X(0)}, Huber{1});
    return graph;
  }
  static Values start_at(const Graph& graph, const Variable& x) {
    Values values;
    values.insert(X(0), x);
    const double anchors[] = {0, 6, 3};
    for (int i = 1; i <= 3; ++i)
      if (graph.is_fixed(X(i))) values.insert(X(i), Variable(anchors[i - 1], 0));
    return values;
  }
  static bool same(const Values& a, const Values& b, Key key) {
    return std::memcmp(&a.at<Variable>(key), &b.at<Variable>(key), sizeof(Variable)) == 0;
  }

  void check_answer(const char* problem, const Graph& graph, const Variable& from, const Variable& to, double cost) {
    const Values start = start_at(graph, from);
    Values answer = start;
    const Summary summary = backend_.solve(graph, answer);
    if (!summary.usable()) {
      text_ << problem << ": it failed: " << summary.why() << "\n";
      return;
    }
    const double off = (answer.at<Variable>(X(0)).value - to.value).norm();
    if (!(off < 1e-3)) text_ << problem << ": the answer is " << off << " m off " << to.value.transpose() << "\n";
    if (!(std::abs(summary.cost - cost) < 1e-4)) text_ << problem << ": the cost is " << summary.cost << ", not " << cost << "\n";
    const double first = graph.cost(start), last = graph.cost(answer);
    if (!(std::abs(summary.cost_first - first) <= 1e-9 * first))
      text_ << problem << ": cost_first is " << summary.cost_first << ", but Graph::cost of the start " << first << "\n";
    if (!(std::abs(summary.cost - last) <= 1e-9 * (1 + last)))
      text_ << problem << ": cost is " << summary.cost << ", but Graph::cost of the answer " << last << "\n";
    if (summary.why().empty()) text_ << problem << ": the summary does not say why it stopped\n";
    Values again = start;
    backend_.solve(graph, again);
    if (!same(again, answer, X(0))) text_ << problem << ": solved again from the same start, the answer has other bits\n";
  }
  void check_fixed() {
    const Graph graph = three_ranges();
    const Values start = start_at(graph, Variable(2.5, 3.5));
    Values answer = start;
    backend_.solve(graph, answer);
    for (int i = 1; i <= 3; ++i)
      if (!same(answer, start, X(i))) text_ << "it moved " << X(i).str() << ", which is fixed\n";
  }
  template <class E>
  void expect_error(const char* what, const Graph& graph, const Values& start) {
    Values values = start;
    try {
      const Summary summary = backend_.solve(graph, values);
      text_ << what << ": no error, but " << summary.str() << "\n";
    } catch (const E&) {
    } catch (const std::exception& error) {
      text_ << what << ": another error than expected: " << error.what() << "\n";
    }
  }
  void check_refusals() {
    const Values start = start_at(two_priors(), Variable(0.3, -7));
    expect_error<BadProblem>("an empty graph", Graph(), start);
    Graph of_another;
    of_another.add(at(1, 2), {X(7)});
    expect_error<BadKey>("a variable without a value", of_another, start);

    const Variable nowhere(std::numeric_limits<double>::quiet_NaN(), 0);
    const Values lost = start_at(two_priors(), nowhere);
    Values values = lost;
    const Summary summary = backend_.solve(two_priors(), values);
    if (summary.usable() || summary.culprit.empty()) text_ << "a residual that is not finite: no failure that names the factor\n";
    if (!same(values, lost, X(0))) text_ << "a residual that is not finite: values are not as they were\n";
  }
  void check_stop() {
    const auto before = backend_.options.progress;
    backend_.options.progress = [](const Iteration&) { return false; };
    const Graph graph = three_ranges();
    Values values = start_at(graph, Variable(2.5, 3.5));
    const double first = graph.cost(values);
    const Summary summary = backend_.solve(graph, values);
    backend_.options.progress = before;
    if (summary.termination != Termination::stopped) text_ << "the progress callback says stop: " << summary.str() << "\n";
    if (!(graph.cost(values) <= first)) text_ << "the progress callback says stop: the answer is worse than the start\n";
  }

  Backend& backend_;
  std::ostringstream text_;
};

}  // namespace detail

template <class AnyBackend>
std::string check_backend(AnyBackend&& backend) {
  Backend& checked = backend;
  return detail::BackendChecker<Point2>(checked).broken();
}

}  // namespace holdfast::testing
