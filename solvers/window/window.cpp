#include <algorithm>
#include <cmath>
#include <holdfast/solvers/table.hpp>
#include <holdfast/solvers/window/window.hpp>

namespace holdfast {

void WindowOptions::validate() const {
  if (!(lag > 0)) fail<BadOption>("lag = ", lag, " must be > 0 [s]");
  if (max_states < 0) fail<BadOption>("max_states = ", max_states, " must be >= 0 (0: no limit)");
  if (!(arrival_limit > 0)) fail<BadOption>("arrival_limit = ", arrival_limit, " must be > 0 [sigmas]");
  if (!(deadline > 0)) fail<BadOption>("deadline = ", deadline, " must be > 0 [s]");
  if (!(max_gap > 0)) fail<BadOption>("max_gap = ", max_gap, " must be > 0 [s]");
  solver.validate();
}

Window::Window(WindowOptions options) : options_(std::move(options)) {
  options_.validate();
  backend_ = make_backend(options_.backend, options_.solver);
}
Window::Window(WindowOptions options, std::unique_ptr<Backend> backend) : options_(std::move(options)), backend_(std::move(backend)) {
  if (!backend_)
    fail<BadOption>("a window needs a back-end, and was given none; pass make_backend(\"irls\"), or a name in WindowOptions::backend");
  options_.backend = backend_->name();
  options_.solver = backend_->options;
  options_.validate();
}
Window::Window(Window&&) noexcept = default;
Window& Window::operator=(Window&&) noexcept = default;
Window::~Window() = default;

// ---- a step

const WindowStep& Window::step(double now) {
  if (!std::isfinite(now)) fail<BadTime>("step(", now, "): the time is not finite");
  if (now > newest_) require_time(now);
  step_.time = std::max(now, newest_);
  step_.left.clear();
  step_.removed.clear();
  step_.lost.clear();
  step_.reacquired.clear();
  step_.arrivals_let_go = 0;
  step_.report.clear();
  step_.marginals.reset();
  step_.seconds = {};
  step_.seconds.add = std::exchange(seconds_add_, 0.0);
  Stopwatch watch;
  for (Member& member : members_)
    if (member.lock && member.lock->is_new && !member.states.empty()) place_first(member);
  solve();
  if (step_.summary.usable()) let_arrivals_go();
  for (Member& member : members_)
    if (member.lock && !member.states.empty() && step_.summary.usable()) Window::watch(member);
  watch.lap(step_.seconds.solve);
  if (options_.covariances && graph_.size() > 0) {
    try {
      step_.marginals.emplace(graph_, values_);
    } catch (const BadNumber&) {  // of a failed solve
    }
    watch.lap(step_.seconds.covariances);
  }
  if (options_.report) {
    step_.report = outlier_report(graph_, values_, times());
    watch.lap(step_.seconds.report);
  }
  let_leave();
  watch.lap(step_.seconds.marginalize);
  step_.deadline_kept = step_.seconds.total() <= options_.deadline;
  return step_;
}

void Window::solve() {
  step_.summary = {};
  step_.summary.termination = Termination::converged;
  step_.summary.rule = "nothing is measured yet";
  if (graph_.size() == 0) return;
  constexpr double kLeastShare = 0.01;  // of the deadline: late as it is, one iteration is better than none
  if (std::isfinite(options_.deadline))
    backend_->options.time_limit =
        std::min(options_.solver.time_limit, std::max(options_.deadline - step_.seconds.add, kLeastShare * options_.deadline));
  try {
    step_.summary = backend_->solve(graph_, values_);
    if (!step_.summary.usable() && remove_non_finite() && graph_.size() > 0) step_.summary = backend_->solve(graph_, values_);
  } catch (const BadProblem&) {
    step_.summary.rule = "nothing is free";
  }
}

void Window::solve_again() { step_.summary = backend_->solve(graph_, values_); }

// Truncated squares of the whole arrival cost: beyond the limit it costs less to do without.
void Window::let_arrivals_go() {
  if (!std::isfinite(options_.arrival_limit)) return;
  for (std::size_t b = 0; b < graph_.batches().size(); ++b) {
    const FactorBatch& batch = *graph_.batches()[b];
    if (batch.factor_type() != typeid(LinearPrior) || batch.size() == 0) continue;
    const FactorId id = graph_.id_of(static_cast<int>(b), 0);
    if (detail::residual_norm(graph_, values_, id) <= options_.arrival_limit) continue;
    graph_.remove(id);
    ++step_.arrivals_let_go;
  }
  if (step_.arrivals_let_go > 0) solve();
}

// What cannot be solved with is taken out; false where the failure has another reason.
bool Window::remove_non_finite() {
  for (const MeasurementReport& one : outlier_report(graph_, values_)) {
    if (one.verdict != MeasurementReport::Verdict::not_finite) continue;
    const Graph::Place& place = graph_.place(one.id);
    step_.removed.push_back(graph_.batches()[place.batch]->describe(place.index));
    remove(one.id);
  }
  return !step_.removed.empty();
}

void Window::let_leave() {
  const double cutoff = newest_ - options_.lag;
  const auto most = static_cast<std::size_t>(options_.max_states > 0 ? options_.max_states : std::numeric_limits<int>::max());
  for (;;) {  // the oldest of all agents first
    Member* next = nullptr;
    for (Member& member : members_) {
      const bool goes = member.states.size() > most || (member.states.size() > 1 && member.states[1].time <= cutoff);
      if (goes && (next == nullptr || member.states.front().time < next->states.front().time)) next = &member;
    }
    if (next == nullptr) break;
    const Key key = next->states.front().key;
    if (options_.on_leaving) options_.on_leaving(key, next->states.front().time);
    if (next->lock) next->lock->leave(key, next->states.front().time, values_, next->states.size() - 1);
    leave(key);
    step_.left.push_back(key);
    next->states.erase(next->states.begin());
    if (!next->states.empty()) next->states.front().motion = {};
  }
  if (!step_.left.empty()) values_.erase(step_.left);
}

void Window::leave(Key key) {
  if (options_.leaving == WindowOptions::Leaving::drop) return marginalizer_.drop(graph_, key);
  try {
    marginalizer_.eliminate(graph_, values_, key);
  } catch (const BadNumber&) {  // of a failed solve: nothing can be kept of it
    marginalizer_.drop(graph_, key);
  }
}

}  // namespace holdfast
