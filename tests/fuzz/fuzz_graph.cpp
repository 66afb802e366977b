// Random adds, removes, fixes, changes of weights, losses and numbers, copies, moves and solves, against a plain list of what the graph
// should hold: the cost of a graph built afresh from that list, and its solution, are those of the graph that lived through it all.
// A back-end that is kept gives the bits of a new one.
#include <algorithm>
#include <array>
#include <cmath>
#include <holdfast/factors/between.hpp>
#include <holdfast/factors/position_step.hpp>
#include <holdfast/factors/prior.hpp>
#include <holdfast/factors/range.hpp>
#include <holdfast/factors/relative_point.hpp>
#include <holdfast/graph/check.hpp>
#include <holdfast/solvers/table.hpp>
#include <variant>

#include "bytes.hpp"

namespace holdfast {
namespace {

using Factor = std::variant<Prior<Point2>, PositionStep<Point2, Point2>, Prior<Pose2>, Between<Pose2>, Range<Pose2, Point2>,
                            RelativePoint<Pose2, Point2>>;

struct Member {
  FactorId id;
  Factor factor;
  std::vector<Key> keys;
  Loss loss;
  double weight;
};

constexpr int kPoints = 4, kPoses = 3;
constexpr Agent L('L'), X('X');

template <class F>
FactorId add(Graph& graph, const F& factor, const std::vector<Key>& keys, const Loss& loss, double weight) {
  std::array<Key, F::Variables::size> array;
  std::copy(keys.begin(), keys.end(), array.begin());
  return graph.add(factor, array, loss, weight);
}

class Life {
 public:
  explicit Life(fuzz::Bytes bytes) : bytes_(bytes), kept_{make_backend("irls", options()), make_backend("nesterov", options())} {
    for (int i = 0; i < kPoints; ++i) values_.insert(L(static_cast<unsigned>(i)), Point2(i, 1));
    for (int i = 0; i < kPoses; ++i) values_.insert(X(static_cast<unsigned>(i)), Pose2(i, 0, 0.1 * i));
  }

  void live() {
    for (int step = 0; step < 100 && !bytes_.empty(); ++step) {
      switch (bytes_.below(12)) {
        case 0:
        case 1:
        case 2:
          add_one();
          break;
        case 3:
          remove_one();
          break;
        case 4:
          remove_again();
          break;
        case 5:
          fix_one();
          break;
        case 6:
          change_weight();
          break;
        case 7:
          change_loss();
          break;
        case 8:
          change_number();
          break;
        case 9:
          copy_or_move();
          break;
        case 10:
          replace_variable();
          break;
        case 11:
          solve();
          break;
      }
      if (step % 8 == 7) compare();
    }
    compare();
    solve();
  }

 private:
  static Options options() {
    Options options;
    options.max_iterations = 20;
    options.cost_tolerance = 1e-12;
    return options;
  }
  Key point() { return L(static_cast<unsigned>(bytes_.below(kPoints))); }
  Key pose() { return X(static_cast<unsigned>(bytes_.below(kPoses))); }
  double sigma() { return 0.25 * (1 + bytes_.below(8)); }
  Loss loss() {
    static const std::array<Loss, 6> all{Squared{}, Squared{}, Huber{1}, Cauchy{2}, Tukey{4}, per_component(PseudoHuber{1})};
    return all[static_cast<std::size_t>(bytes_.below(6))];
  }

  void add_one() {
    Member member{{}, Prior<Point2>{}, {}, loss(), 0.25 * bytes_.below(9)};
    switch (bytes_.below(6)) {
      case 0:
        member.factor = Prior<Point2>::from_sigmas(Point2(bytes_.small(), bytes_.small()), {sigma(), sigma()});
        member.keys = {point()};
        break;
      case 1:
        member.factor = PositionStep<Point2, Point2>{sigma()};
        member.keys = {point(), point()};
        break;
      case 2:
        member.factor = Prior<Pose2>::from_sigmas(Pose2(bytes_.small(), bytes_.small(), bytes_.small()), {sigma(), sigma(), sigma()});
        member.keys = {pose()};
        break;
      case 3:
        member.factor = Between<Pose2>::from_sigmas(Pose2(bytes_.small(), bytes_.small(), bytes_.small()), {sigma(), sigma(), sigma()});
        member.keys = {pose(), pose()};
        break;
      case 4:
        member.factor = Range<Pose2, Point2>{std::abs(bytes_.small()), sigma()};
        member.keys = {pose(), point()};
        break;
      case 5:
        member.factor = RelativePoint<Pose2, Point2>::from_sigmas({bytes_.small(), bytes_.small()}, {sigma(), sigma()});
        member.keys = {pose(), point()};
        break;
    }
    const bool twice = member.keys.size() == 2 && member.keys[0] == member.keys[1];
    try {
      member.id = std::visit([&](const auto& f) { return add(graph_, f, member.keys, member.loss, member.weight); }, member.factor);
    } catch (const BadKey&) {
      fuzz::require(twice, "add() refuses a good factor");
      return;
    }
    fuzz::require(!twice && graph_.contains(member.id), "add() takes a factor with a key twice, or forgets it");
    members_.push_back(member);
  }

  Member* member() { return members_.empty() ? nullptr : &members_[bytes_.byte() % members_.size()]; }

  void remove_one() {
    if (Member* gone = member()) {
      graph_.remove(gone->id);
      removed_ = gone->id;
      *gone = members_.back();
      members_.pop_back();
    }
  }
  void remove_again() {
    if (removed_.number < 0) return;
    try {
      graph_.remove(removed_);
      fuzz::require(false, "a factor is removed twice");
    } catch (const BadKey&) {
    }
  }
  void fix_one() {
    const Key key = bytes_.below(2) == 0 ? point() : pose();
    if (graph_.is_fixed(key))
      graph_.unfix(key);
    else
      graph_.fix(key);
  }
  void change_weight() {
    if (Member* one = member()) graph_.set_weight(one->id, one->weight = 0.25 * bytes_.below(9));
  }
  void change_loss() {
    Member* one = member();
    if (one == nullptr) return;
    const int batch = graph_.place(one->id).batch;
    const Loss chosen = loss();
    graph_.set_loss(batch, chosen);
    for (Member& other : members_)
      if (graph_.place(other.id).batch == batch) other.loss = chosen;
  }
  void change_number() {
    Member* one = member();
    if (one == nullptr) return;
    if (auto* range = std::get_if<Range<Pose2, Point2>>(&one->factor))
      graph_.at<Range<Pose2, Point2>>(one->id).distance = range->distance = std::abs(bytes_.small());
    if (auto* step = std::get_if<PositionStep<Point2, Point2>>(&one->factor))
      graph_.at<PositionStep<Point2, Point2>>(one->id).beta = step->beta = sigma();
  }
  void copy_or_move() {
    Graph copy = graph_;
    Values values = values_;
    if (bytes_.below(2) == 0) {
      graph_ = std::move(copy);
      values_ = std::move(values);
      fuzz::require(copy.size() == 0 && values.size() == 0, "a moved-from graph or values still hold something");
    } else {
      graph_ = copy;
      values_ = values;
    }
  }
  void replace_variable() {
    const Key key = point();
    const Point2 value(bytes_.small(), bytes_.small());
    if (values_.contains(key)) values_.erase(key);
    const bool back = bytes_.below(4) != 0;
    if (back) values_.insert(key, value);
  }

  Graph fresh() const {
    Graph graph;
    for (const Member& m : members_) std::visit([&](const auto& f) { add(graph, f, m.keys, m.loss, m.weight); }, m.factor);
    for (Key key : graph_.fixed()) graph.fix(key);
    return graph;
  }
  bool is_complete() const {
    return std::all_of(members_.begin(), members_.end(), [&](const Member& m) {
      return std::all_of(m.keys.begin(), m.keys.end(), [&](Key key) { return values_.contains(key); });
    });
  }
  /// Squared terms, linear in points, each of which has a prior: one minimum, and well conditioned.
  bool has_one_minimum() const {
    std::vector<Key> held, used;
    for (const Member& m : members_) {
      if (m.factor.index() > 1 || m.loss.kind != Loss::Kind::Squared) return false;
      if (m.factor.index() == 0 && m.weight > 0) held.push_back(m.keys[0]);
      used.insert(used.end(), m.keys.begin(), m.keys.end());
    }
    return std::all_of(used.begin(), used.end(),
                       [&](Key key) { return graph_.is_fixed(key) || std::find(held.begin(), held.end(), key) != held.end(); });
  }

  void compare() {
    fuzz::require(graph_.size() == members_.size(), "the graph holds another number of factors");
    for (const Member& m : members_) {
      const Graph::Place& place = graph_.place(m.id);
      const FactorBatch& batch = *graph_.batches()[static_cast<std::size_t>(place.batch)];
      fuzz::require(std::equal(m.keys.begin(), m.keys.end(), batch.keys(place.index)) && batch.weight(place.index) == m.weight &&
                        batch.loss(place.index) == m.loss,
                    "a factor has changed:", batch.describe(place.index));
    }
    if (!is_complete()) {
      try {
        graph_.cost(values_);
        fuzz::require(false, "a cost without its variables");
      } catch (const BadKey&) {
      }
      return;
    }
    const double cost = graph_.cost(values_), again = fresh().cost(values_);
    fuzz::require(std::abs(cost - again) <= 1e-12 * (1 + again),
                  "the cost is not that of a new graph:", std::to_string(cost) + " " + std::to_string(again));
  }

  static bool same(const Values& a, const Values& b, double tolerance) {
    for (const auto& pool : a.pools())
      for (int i = 0; i < pool->size(); ++i) {
        double delta[3];
        const Values::Slot& there = b.slot(pool->keys()[static_cast<std::size_t>(i)]);
        if (there.pool != a.slot(pool->keys()[static_cast<std::size_t>(i)]).pool || there.index != i) return false;
        pool->local(i, b.pool(there.pool), delta);
        for (int k = 0; k < pool->dim(); ++k)
          if (!(std::abs(delta[k]) <= tolerance)) return false;
      }
    return true;
  }

  void solve() {
    check(graph_, values_);
    const std::size_t which = static_cast<std::size_t>(bytes_.below(2));
    Values kept = values_, made = values_, scratch = values_;
    Summary summary;
    try {
      summary = kept_[which]->solve(graph_, kept);
    } catch (const Error&) {
      fuzz::require(same(kept, values_, 0), "a refused solve moved the values");
      return;
    }
    const auto backend = make_backend(kept_[which]->name(), options());
    const Summary other = backend->solve(graph_, made);
    fuzz::require(summary.cost == other.cost && same(kept, made, 0),
                  "a kept back-end differs from a new one:", summary.str() + other.str());
    fuzz::require(summary.usable() || same(kept, values_, 0), "a failed solve moved the values:", summary.str());
    if (!summary.usable()) return;
    fuzz::require(summary.cost <= summary.cost_first, "a solve ends above its start:", summary.str());
    const double cost = graph_.cost(kept);
    fuzz::require(std::abs(cost - summary.cost) <= 1e-12 * (1 + cost), "the summary states another cost:", summary.str());
    if (which == 0 && has_one_minimum()) {
      make_backend("irls", options())->solve(fresh(), scratch);
      fuzz::require(same(kept, scratch, 1e-6), "the solution is not that of a new graph:", summary.str());
    }
    if (bytes_.below(2) == 0) values_ = kept;
  }

  fuzz::Bytes bytes_;
  std::array<std::unique_ptr<Backend>, 2> kept_;
  Graph graph_;
  Values values_;
  std::vector<Member> members_;
  FactorId removed_;
};

}  // namespace
}  // namespace holdfast

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  holdfast::Life(holdfast::fuzz::Bytes(data, size)).live();
  return 0;
}
