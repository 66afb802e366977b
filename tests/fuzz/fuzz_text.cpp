// Small texts and numbers: losses, keys, names of starts and back-ends, options. What is accepted reads back as itself and works.
#include <cmath>
#include <holdfast/adapters/files/problem.hpp>
#include <holdfast/factors/prior.hpp>
#include <holdfast/solvers/table.hpp>

#include "bytes.hpp"

namespace holdfast {
namespace {

void as_loss(std::string_view text) {
  const Loss loss = Loss::parse(text);
  fuzz::require(Loss::parse(loss.str()) == loss, "a loss is not the one its text says:", loss.str());
  loss.validate(1);
  double before = 0;
  for (double s : {0.0, 1e-12, 1e-3, 0.5, 1.0, 2.0, 50.0, 1e6, 1e12}) {
    const Rho rho = loss.rho(s, 1);
    fuzz::require(std::isfinite(rho.value) && std::isfinite(rho.first) && std::isfinite(rho.second), "a loss is not finite:", loss.str());
    fuzz::require(rho.value >= before * (1 - 1e-12) && rho.first >= 0 && rho.second <= 0, "a loss breaks its contract:", loss.str());
    before = rho.value;
  }
}

void as_key(std::string_view text) {
  const Key key = Key::parse(text);
  fuzz::require(Key::parse(key.str()) == key, "a key is not the one its text says:", key.str());
}

void as_options(fuzz::Bytes bytes) {
  Options options;
  options.max_iterations = bytes.byte() - 2;
  options.threads = bytes.byte() - 1;
  options.cost_tolerance = bytes.any();
  options.gradient_tolerance = bytes.any();
  options.time_limit = bytes.any();
  options.trace = bytes.below(2) == 1;
  if (options.threads > 2) return;  // a thread is a thread
  const auto backend = make_backend(bytes.below(2) == 0 ? "irls" : "nesterov", options);
  Graph graph;
  Values values;
  const Key key('A', 0);
  values.insert(key, Point2(bytes.any(), bytes.any()));
  graph.add(Prior<Point2>::from_sigmas(Point2(1, 2), {0.5, 0.5}), {key}, Huber{1});
  const Values start = values;
  const Summary summary = backend->solve(graph, values);
  const Vector<2> moved = start.at<Point2>(key).local(values.at<Point2>(key));
  if (summary.usable())
    fuzz::require(summary.cost <= summary.cost_first && values.at<Point2>(key).is_finite(), "no answer:", summary.str());
  else
    fuzz::require(!(moved.array().abs() > 0).any(), "a failed solve moved the values:", summary.str());
}

template <class Fn>
void typed_errors_only(const Fn& fn) {
  try {
    fn();
  } catch (const Error&) {
  }
}

}  // namespace
}  // namespace holdfast

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace holdfast;
  fuzz::Bytes bytes(data, size);
  typed_errors_only([&] { as_loss(bytes.rest()); });
  typed_errors_only([&] { as_key(bytes.rest()); });
  typed_errors_only([&] { start_named(std::string(bytes.rest())); });
  typed_errors_only([&] { make_backend(std::string(bytes.rest())); });
  typed_errors_only([&] { as_options(bytes); });
  return 0;
}
