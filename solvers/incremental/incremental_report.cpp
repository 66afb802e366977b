// What an update has to say of the measurements that it looked at.
#include <algorithm>
#include <holdfast/solvers/incremental/internal/incremental_state.hpp>

namespace holdfast {
namespace {

bool same(FactorId a, FactorId b) { return a.number == b.number && a.generation == b.generation; }

/// A point of the plane or of space: what ranges alone can place on two sides.
bool is_point(const PoolBase& pool) { return pool.is_vector_space() && pool.space() == pool.dim(); }

}  // namespace

void Incremental::describe() {
  State& s = *state_;
  std::vector<FactorId> ids;
  std::sort(s.looked_at.begin(), s.looked_at.end(), [](FactorId a, FactorId b) { return a.number < b.number; });
  for (const FactorId id : s.looked_at)
    if (graph_.contains(id) && (ids.empty() || !same(ids.back(), id))) ids.push_back(id);
  s.looked_at.clear();
  if (options_.report) report_measurements(ids);
  if (!options_.findings) return;
  for (const FactorId id : ids) {
    const Graph::Place& place = graph_.place(id);
    const FactorBatch& batch = *graph_.batches()[place.batch];
    s.touched.insert(batch.keys(place.index), batch.keys(place.index) + batch.arity());
  }
  find_stuck(ids);
  find_mirrors();
  s.touched.clear();
}

/// These factors alone, and the estimates of their variables; their ids there, in the same order.
std::vector<FactorId> Incremental::part_of(const std::vector<FactorId>& ids, Graph& part, Values& estimate) const {
  std::vector<FactorId> there;
  for (const FactorId id : ids) {
    const Graph::Place& place = graph_.place(id);
    const FactorBatch& batch = *graph_.batches()[place.batch];
    for (int k = 0; k < batch.arity(); ++k) insert_estimate(batch.keys(place.index)[k], part, estimate);
    there.push_back(part.add_from(graph_, id));
  }
  return there;
}

void Incremental::report_measurements(const std::vector<FactorId>& ids) {
  Graph part;
  Values estimate;
  const std::vector<FactorId> there = part_of(ids, part, estimate);
  step_.report = outlier_report(part, estimate);
  for (MeasurementReport& one : step_.report)
    one.id = ids[static_cast<std::size_t>(std::find_if(there.begin(), there.end(), [&](FactorId id) { return same(id, one.id); }) -
                                          there.begin())];
}

/// Ranges that stand at zero distance, each for itself.
void Incremental::find_stuck(const std::vector<FactorId>& ids) {
  State& s = *state_;
  const auto find = [&](const std::vector<FactorId>& some) {
    Graph part;
    Values estimate;
    part_of(some, part, estimate);
    return zero_distance(part, estimate);
  };
  const auto ended = [&](const State::Standing& one) {
    return one.finding.kind == Finding::Kind::zero_distance && (!graph_.contains(one.factor) || find({one.factor}).keys.empty());
  };
  for (auto it = s.standing.begin(); it != s.standing.end();) {
    if (ended(*it)) {
      step_.gone.push_back(std::move(it->finding));
      it = s.standing.erase(it);
    } else {
      ++it;
    }
  }
  if (ids.empty() || find(ids).keys.empty()) return;
  for (const FactorId id : ids) {
    if (std::any_of(s.standing.begin(), s.standing.end(), [&](const State::Standing& one) { return same(one.factor, id); })) continue;
    Finding finding = find({id});
    if (finding.keys.empty()) continue;
    step_.findings.push_back(finding);
    s.standing.push_back({std::move(finding), id});
  }
}

/// Of the touched points, and of those that factors tie to them.
void Incremental::find_mirrors() {
  State& s = *state_;
  std::set<Key> points;
  std::vector<Key> stack(s.touched.begin(), s.touched.end());
  std::vector<FactorId> ids;
  while (!stack.empty()) {
    const Key key = stack.back();
    stack.pop_back();
    if (!start_.contains(key) || graph_.is_fixed(key) || !is_point(start_.pool(start_.slot(key).pool))) continue;
    if (!points.insert(key).second) continue;
    for (const FactorId id : graph_.factors_on(key)) {
      const Graph::Place& place = graph_.place(id);
      const FactorBatch& batch = *graph_.batches()[place.batch];
      ids.push_back(id);
      stack.insert(stack.end(), batch.keys(place.index), batch.keys(place.index) + batch.arity());
    }
  }
  std::sort(ids.begin(), ids.end(), [](FactorId a, FactorId b) { return a.number < b.number; });
  ids.erase(std::unique(ids.begin(), ids.end(), same), ids.end());
  std::vector<Finding> now;
  if (!ids.empty()) {
    Graph part;
    Values estimate;
    part_of(ids, part, estimate);
    now = mirror_findings(part, estimate);
  }
  const auto concerned = [&](const Finding& one) {
    return one.kind == Finding::Kind::mirror_image &&
           std::any_of(one.keys.begin(), one.keys.end(), [&](Key key) { return points.count(key) != 0 || !start_.contains(key); });
  };
  const auto among = [](const std::vector<Finding>& all, const Finding& one) {
    return std::any_of(all.begin(), all.end(), [&](const Finding& other) { return other.keys == one.keys; });
  };
  std::vector<Finding> before;
  for (auto it = s.standing.begin(); it != s.standing.end();) {
    if (!concerned(it->finding)) {
      ++it;
      continue;
    }
    if (!among(now, it->finding)) step_.gone.push_back(it->finding);
    before.push_back(std::move(it->finding));
    it = s.standing.erase(it);
  }
  for (Finding& one : now) {
    if (!among(before, one)) step_.findings.push_back(one);
    s.standing.push_back({std::move(one), {}});
  }
}

}  // namespace holdfast
