#include <Eigen/Cholesky>
#include <algorithm>
#include <chrono>
#include <holdfast/graph/variables.hpp>
#include <holdfast/solvers/internal/independent_set.hpp>
#include <holdfast/solvers/pairwise_consistency.hpp>
#include <map>
#include <queue>
#include <random>
#include <set>
#include <sstream>

namespace holdfast {
namespace {

/// P(χ² > x) of 3 or 6 degrees of freedom.
double chi_squared_tail(int dim, double x) {
  if (dim == 3) return std::erfc(std::sqrt(x / 2)) + std::sqrt(2 * x / kPi) * std::exp(-x / 2);
  return std::exp(-x / 2) * (1 + x / 2 + x * x / 8);
}

double chi_squared_limit(int dim, double tail) {
  double low = 0, high = 1;
  while (chi_squared_tail(dim, high) > tail && high < 1e4) high *= 2;
  for (int i = 0; i < 100; ++i) {
    const double middle = 0.5 * (low + high);
    (chi_squared_tail(dim, middle) > tail ? low : high) = middle;
  }
  return high;
}

// The adjoint and the logarithm of SE(n), tangent (translation, rotation).
Matrix<3, 3> adjoint(const Pose2& T) {
  Matrix<3, 3> Ad = Matrix<3, 3>::Identity();
  Ad.topLeftCorner<2, 2>() = T.rotation();
  Ad(0, 2) = T.p[1];
  Ad(1, 2) = -T.p[0];
  return Ad;
}
Matrix<6, 6> adjoint(const Pose3& T) {
  Matrix<6, 6> Ad = Matrix<6, 6>::Zero();
  const Matrix<3, 3> R = T.rotation();
  Ad.topLeftCorner<3, 3>() = Ad.bottomRightCorner<3, 3>() = R;
  Ad.topRightCorner<3, 3>() = so3::hat(T.p) * R;
  return Ad;
}
Vector<3> log_of(const Pose2& T) {
  const double half = 0.5 * T.angle();
  const double c = std::abs(half) < 1e-4 ? 1 - half * half / 3 : half / std::tan(half);
  return {c * T.p[0] + half * T.p[1], c * T.p[1] - half * T.p[0], 2 * half};
}
Vector<6> log_of(const Pose3& T) {
  const Vector<3> phi = so3::log<double>(T.q);
  Vector<6> xi;
  xi << so3::right_jacobian_inverse(-phi) * T.p, phi;
  return xi;
}

/// One kind of pose.
template <class Pose>
class Consistency {
 public:
  static constexpr int dim = Pose::dim;
  using Square = Matrix<dim, dim>;
  static constexpr int kTwins = 25;  ///< steps between the ends of twins

  Consistency(const Graph& graph, const PairwiseConsistencyOptions& options) : graph_(graph), options_(options) {
    limit_ = chi_squared_limit(dim, options.false_alarm);
    find_edges();
    make_tracks();
    place_loops();
    for (auto& [tracks, group] : groups_)
      std::stable_sort(group.begin(), group.end(), [&](int a, int b) { return turn_at_first(a) < turn_at_first(b); });
    scale_ = options.noise_scale > 0 ? options.noise_scale : estimated_scale();
  }

  void add_to(ConsistentLoops& result, std::vector<char>& is_rejected) {
    result.tracks += tracks_;
    support_.assign(loops_.size(), 0);
    if (!groups_.empty()) result.noise_scale = std::min(result.noise_scale, scale_);
    for (auto& [tracks, group] : groups_) {
      if (group.size() < 2) {
        ++result.untested;
        continue;
      }
      ++result.groups;
      judge(group, tracks.first == tracks.second, result, is_rejected);
    }
    if (options_.second_look) vote(is_rejected);
  }
  const std::vector<FactorId>& loops() const { return ids_; }

 private:
  struct Edge {
    FactorId id;
    Key first, second;
    Pose measured;
    Square covariance;
  };
  /// A pose of a track.
  struct Place {
    int track = -1;
    int number = -1;  ///< in poses_ and the sums
  };
  /// A loop in the frame of its first track.
  struct Loop {
    int first, second;  ///< numbers of poses
    Pose X;
    Square noise, Ad;
    int edge;
  };

  Square covariance_of(const Square& information) const {
    Square whole = information;
    whole.diagonal().array() += 1e-9 * information.diagonal().maxCoeff();
    return whole.llt().solve(Square::Identity());
  }

  void find_edges() {
    std::set<Key> poses;
    std::vector<Edge> all;
    for (std::size_t b = 0; b < graph_.batches().size(); ++b) {
      const FactorBatch& batch = *graph_.batches()[b];
      const auto* const measured = dynamic_cast<const RelativePoses<Pose>*>(&batch);
      if (measured == nullptr) continue;
      for (int i = 0; i < batch.size(); ++i) {
        const Key first = batch.keys(i)[0], second = batch.keys(i)[1];
        poses.insert({first, second});
        if (!(batch.weight(i) > 0)) continue;
        const MeasuredPose<Pose> z = measured->measured_pose(i);
        all.push_back({graph_.id_of(static_cast<int>(b), i), first, second, z.pose, covariance_of(batch.weight(i) * z.information)});
      }
    }
    std::set<std::pair<Key, Key>> followed;  // one edge leads from a pose to the next
    std::set<int> chosen;
    for (const FactorId id : options_.odometry) chosen.insert(id.number);
    for (Edge& edge : all) {
      auto next = poses.find(std::min(edge.first, edge.second));
      ++next;
      const bool follows = next != poses.end() && *next == std::max(edge.first, edge.second) && edge.first.agent() == edge.second.agent();
      const bool is_odometry = options_.odometry.empty() ? follows : chosen.count(edge.id.number) != 0;
      if (is_odometry && followed.emplace(std::minmax(edge.first, edge.second)).second)
        odometry_.push_back(std::move(edge));
      else if (!is_odometry && edge.first != edge.second)
        loop_edges_.push_back(std::move(edge));
    }
    for (Key key : poses) places_[key] = {};
  }

  /// Dead reckoning from one end of each chain to the other, and the cumulative sums. Of odometry that branches one way is followed.
  void make_tracks() {
    std::unordered_map<Key, std::vector<int>> at;
    for (std::size_t e = 0; e < odometry_.size(); ++e) {
      at[odometry_[e].first].push_back(static_cast<int>(e));
      at[odometry_[e].second].push_back(static_cast<int>(e));
    }
    std::vector<Key> starts;
    for (const auto& [key, place] : places_)  // ends of chains first, then whatever is left (rings)
      if (at[key].size() <= 1) starts.push_back(key);
    for (const auto& [key, place] : places_) starts.push_back(key);
    for (const Key start : starts) {
      if (places_[start].track >= 0) continue;
      Pose T;
      Square sum = Square::Zero();
      Key here = start;
      put(here, T, sum);
      for (bool goes_on = true; goes_on;) {
        goes_on = false;
        for (const int e : at[here]) {
          const Edge& edge = odometry_[e];
          const bool forwards = edge.first == here;
          const Key there = forwards ? edge.second : edge.first;
          if (places_[there].track >= 0) continue;
          const Pose next = forwards ? T * edge.measured : T * edge.measured.inverse();
          const Square Ad = adjoint(forwards ? next : T);
          sum += Ad * edge.covariance * Ad.transpose();
          T = next;
          here = there;
          put(here, T, sum);
          goes_on = true;
          break;
        }
      }
      ++tracks_;
    }
  }
  /// A measurement between two poses, by number.
  struct Tie {
    int first, second;
    const Edge* edge;
  };
  void put(Key key, const Pose& T, const Square& sum) {
    places_[key] = {tracks_, static_cast<int>(poses_.size())};
    poses_.push_back(T);
    sums_.push_back(sum);
    constexpr int turns = dim - Pose::space_dim;
    turns_.push_back(sum.template bottomRightCorner<turns, turns>().trace() / turns);
  }

  void place_loops() {
    for (std::size_t e = 0; e < loop_edges_.size(); ++e) {
      const Edge& edge = loop_edges_[e];
      const Place a = places_[edge.first], b = places_[edge.second];
      const bool forwards = a.number <= b.number;  // numbers grow along a track, and from track to track
      const Pose z = forwards ? edge.measured : edge.measured.inverse();
      const Place first = forwards ? a : b, second = forwards ? b : a;
      const Pose end = poses_[first.number] * z;
      const Square of_noise = adjoint(forwards ? end : poses_[first.number]);
      Loop loop{first.number, second.number,      end * poses_[second.number].inverse(), of_noise * edge.covariance * of_noise.transpose(),
                {},           static_cast<int>(e)};
      loop.Ad = adjoint(loop.X);
      groups_[{first.track, second.track}].push_back(static_cast<int>(loops_.size()));
      loops_.push_back(loop);
      ids_.push_back(edge.id);
    }
  }
  /// χ² of pairs at some distance from each other (twins say nothing of the odometry), at most so many, of up to 3 rad under this scale:
  /// where angles wrap round, χ² is too small by a third of that at most, and a smaller estimate is believed.
  std::vector<double> sample(double scale) const {
    constexpr std::size_t kMost = 100'000;
    std::size_t count = 0;
    const auto visit_all = [&](const auto& visit) {
      for (const auto& [tracks, group] : groups_)
        for_each_pair(group, 10 / scale, [&, same = tracks.first == tracks.second, &of = group](std::size_t k, std::size_t l) {
          const Loop &a = loops_[of[k]], &b = loops_[of[l]];
          if (turn_between(a, b) > 0.1 / scale) visit(a, b, same);
        });
    };
    visit_all([&](const Loop&, const Loop&, bool) { ++count; });
    const std::size_t every = count / kMost + 1;
    std::size_t number = 0;
    std::vector<double> all;
    visit_all([&](const Loop& a, const Loop& b, bool same) {
      if (number++ % every != 0) return;
      const double chi2 = chi_squared(a, b, same);
      if (std::isfinite(chi2)) all.push_back(chi2);
    });
    return all;
  }

  double estimated_scale() const {
    constexpr std::size_t kFewest = 100;
    constexpr double kSafety = 3, kLeast = 1e-4, kBelieved = 0.3, kStep = 0.1;
    constexpr double kQuantile = dim == 3 ? 1.869 : 4.570;  // 40 % of χ² with dim degrees of freedom
    double scale = 1;
    while (scale > kLeast) {
      std::vector<double> chi2 = sample(scale);
      if (chi2.size() < kFewest) break;
      const auto at = chi2.begin() + static_cast<std::ptrdiff_t>(chi2.size() / 5);
      std::nth_element(chi2.begin(), at, chi2.end());
      const double estimate = *at / kQuantile;
      if (estimate > kBelieved * scale) break;
      scale = std::max(estimate, kStep * scale);
    }
    return scale < 1 ? std::min(1.0, kSafety * std::max(scale, kLeast)) : 1;
  }

  // ---- the second look: each loop against the map that the others make

  /// The paths of least uncertainty from one pose to all, over odometry and some loops.
  struct Tree {
    std::vector<int> parent, depth, part;  ///< part: the root's number
    std::vector<Pose> T;
    std::vector<Square> sums;
    std::vector<char> has_loop;  ///< by loop: it is an edge of the tree

    int common_ancestor(int a, int b) const {
      while (a != b) (depth[a] >= depth[b] ? a : b) = parent[depth[a] >= depth[b] ? a : b];
      return a;
    }
  };

  std::vector<Tie> ties() const {
    std::vector<Tie> all;
    for (const std::vector<Edge>* edges : {&loop_edges_, &odometry_})  // loops first: their numbers
      for (const Edge& edge : *edges) all.push_back({places_.at(edge.first).number, places_.at(edge.second).number, &edge});
    return all;
  }

  Tree tree(const std::vector<Tie>& all, const std::vector<char>& is_used, const std::vector<std::vector<int>>& at, int root) const {
    constexpr int turns = dim - Pose::space_dim;
    const int n = static_cast<int>(poses_.size());
    Tree tree{std::vector<int>(n, -1), std::vector<int>(n, 0), std::vector<int>(n, -1),
              std::vector<Pose>(n),    std::vector<Square>(n), std::vector<char>(loop_edges_.size(), 0)};
    std::vector<double> distance(n, std::numeric_limits<double>::infinity());
    std::vector<int> by(n, -1);
    using Entry = std::pair<double, int>;
    std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
    for (int k = 0; k < n; ++k) {
      const int start = (root + k) % n;
      if (tree.part[start] >= 0) continue;
      tree.sums[start].setZero();
      queue.emplace(distance[start] = 0, start);
      while (!queue.empty()) {
        const auto [so_far, here] = queue.top();
        queue.pop();
        if (tree.part[here] >= 0) continue;
        tree.part[here] = start;
        if (by[here] >= 0) grow(tree, all[by[here]], by[here], here);
        for (const int t : at[here]) {
          if (is_used[t] == 0) continue;
          const int there = all[t].first == here ? all[t].second : all[t].first;
          const double next = so_far + all[t].edge->covariance.template bottomRightCorner<turns, turns>().trace();
          if (tree.part[there] >= 0 || !(next < distance[there])) continue;
          distance[there] = next;
          by[there] = t;
          queue.emplace(next, there);
        }
      }
    }
    return tree;
  }
  void grow(Tree& tree, const Tie& tie, int number, int here) const {
    const bool forwards = tie.second == here;
    const int from = forwards ? tie.first : tie.second;
    tree.parent[here] = from;
    tree.depth[here] = tree.depth[from] + 1;
    tree.T[here] = forwards ? tree.T[from] * tie.edge->measured : tree.T[from] * tie.edge->measured.inverse();
    const Square Ad = adjoint(tree.T[forwards ? here : from]);
    tree.sums[here] = tree.sums[from] + Ad * tie.edge->covariance * Ad.transpose();
    if (number < static_cast<int>(loop_edges_.size())) tree.has_loop[number] = 1;
  }

  /// 1: it agrees with the tree, −1: it does not, 0: the tree does not say.
  int verdict(const Tree& tree, const Tie& loop) const {
    constexpr int turns = dim - Pose::space_dim;
    constexpr double kSays = 0.1;  // of the limit [rad²]: with more, nearly everything agrees
    const int a = loop.first, b = loop.second;
    if (tree.part[a] != tree.part[b]) return 0;
    const Square way = tree.sums[a] + tree.sums[b] - 2 * tree.sums[tree.common_ancestor(a, b)];
    const double turn = scale_ * way.template bottomRightCorner<turns, turns>().trace() / turns;
    if (turn > kSays * options_.informative * options_.informative) return 0;
    const Pose end = tree.T[a] * loop.edge->measured;
    const Square Ad = adjoint(end);
    const Square S = way + Ad * loop.edge->covariance * Ad.transpose();
    const Vector<dim> e = log_of(end * tree.T[b].inverse());
    const auto cholesky = S.llt();
    if (cholesky.info() != Eigen::Success) return 0;
    return e.dot(cholesky.solve(e)) > limit_ * scale_ ? -1 : 1;
  }

  /// Loops from about the same place to about the same place: they stand and fall together.
  std::vector<std::vector<int>> twins(const std::vector<Tie>& all) const {
    const int loops = static_cast<int>(loop_edges_.size());
    std::map<std::pair<int, int>, std::vector<int>> cells;
    const auto low = [&](int l) { return std::min(all[l].first, all[l].second); };
    const auto high = [&](int l) { return std::max(all[l].first, all[l].second); };
    for (int l = 0; l < loops; ++l) cells[{low(l) / kTwins, high(l) / kTwins}].push_back(l);
    std::vector<std::vector<int>> result(static_cast<std::size_t>(loops));
    for (int l = 0; l < loops; ++l)
      for (int i = -1; i <= 1; ++i)
        for (int j = -1; j <= 1; ++j) {
          const auto cell = cells.find({low(l) / kTwins + i, high(l) / kTwins + j});
          if (cell == cells.end()) continue;
          for (const int other : cell->second)
            if (other != l && std::abs(low(other) - low(l)) <= kTwins && std::abs(high(other) - high(l)) <= kTwins)
              result[l].push_back(other);
        }
    return result;
  }

  /// The better half of the kept loops.
  std::vector<char> supported(const std::vector<char>& was_rejected) const {
    std::vector<int> kept;
    for (std::size_t l = 0; l < was_rejected.size(); ++l)
      if (was_rejected[l] == 0) kept.push_back(support_[l]);
    std::vector<char> result(was_rejected.size(), 0);
    if (kept.empty()) return result;
    std::nth_element(kept.begin(), kept.begin() + static_cast<std::ptrdiff_t>(kept.size() / 2), kept.end());
    for (std::size_t l = 0; l < was_rejected.size(); ++l)
      result[l] = static_cast<char>(was_rejected[l] == 0 && support_[l] >= kept[kept.size() / 2]);
    return result;
  }

  /// Half of the loops make a map, the others are asked; what most maps without a twin of it disagree with goes, the worst first, so
  /// that the maps get better.
  void vote(std::vector<char>& is_rejected) const {
    constexpr int kTrees = 24, kCell = 80, kFewestVotes = 3;
    constexpr double kAgainst[] = {0.95, 0.9, 0.8, 0.7, 0.6, 0.5, 0.5}, kReadmitted = 0.25;
    if (loop_edges_.empty()) return;
    const std::vector<Tie> all = ties();
    const std::size_t loops = loop_edges_.size();
    const auto rejected = [&](std::size_t l) -> char& { return is_rejected[static_cast<std::size_t>(loop_edges_[l].id.number)]; };
    std::vector<char> was_rejected(loops);
    for (std::size_t l = 0; l < loops; ++l) was_rejected[l] = rejected(l);
    std::vector<std::vector<int>> at(poses_.size());
    for (std::size_t t = 0; t < all.size(); ++t) {
      at[all[t].first].push_back(static_cast<int>(t));
      at[all[t].second].push_back(static_cast<int>(t));
    }
    const std::vector<std::vector<int>> twins_of = twins(all);
    std::vector<char> makes_maps = supported(was_rejected);
    std::mt19937_64 rng(1);
    for (const double limit : kAgainst) {
      std::vector<int> votes(loops, 0), against(loops, 0);
      for (int k = 0; k < kTrees; ++k) {
        const int shift = static_cast<int>(rng() % kCell);
        const std::uint64_t salt = rng();
        std::vector<char> is_used(all.size(), 1);
        for (std::size_t l = 0; l < loops; ++l) {
          const auto [low, high] = std::minmax(all[l].first, all[l].second);
          std::uint64_t cell = salt + 0x9E3779B97F4A7C15u * static_cast<std::uint64_t>((low + shift) / kCell) +
                               0xC2B2AE3D27D4EB4Fu * static_cast<std::uint64_t>((high + shift) / kCell);
          cell = (cell ^ (cell >> 31)) * 0xBF58476D1CE4E5B9u;
          is_used[l] = static_cast<char>(makes_maps[l] != 0 && (cell >> 40 & 1) != 0);
        }
        const Tree map = tree(all, is_used, at, static_cast<int>(rng() % poses_.size()));
        for (std::size_t l = 0; l < loops; ++l) {
          if (is_used[l] != 0) continue;
          if (std::any_of(twins_of[l].begin(), twins_of[l].end(), [&](int other) { return map.has_loop[other] != 0; })) continue;
          const int says = verdict(map, all[l]);
          votes[l] += says != 0;
          against[l] += says < 0;
        }
      }
      for (std::size_t l = 0; l < loops; ++l)
        if (votes[l] >= kFewestVotes) rejected(l) = static_cast<char>(against[l] > (was_rejected[l] != 0 ? kReadmitted : limit) * votes[l]);
      for (std::size_t l = 0; l < loops; ++l)
        if (rejected(l) != 0)
          makes_maps[l] = 0;
        else if (votes[l] >= kFewestVotes)
          makes_maps[l] = 1;
    }
  }

  double turn_at_first(int loop) const { return turns_[loops_[loop].first]; }

  /// Variance of heading between the ends of two loops [rad²].
  double turn_between(const Loop& a, const Loop& b) const {
    return std::abs(turns_[a.first] - turns_[b.first]) + std::abs(turns_[a.second] - turns_[b.second]);
  }

  /// Calls visit(k, l) for the pairs of a group, sorted by turn_at_first, within the limit [rad²].
  template <class Visit>
  void for_each_pair(const std::vector<int>& group, double limit, const Visit& visit) const {
    for (std::size_t k = 0; k < group.size(); ++k) {
      const Loop& a = loops_[group[k]];
      for (std::size_t l = k + 1; l < group.size() && turn_at_first(group[l]) - turn_at_first(group[k]) <= limit; ++l)
        if (turn_between(a, loops_[group[l]]) <= limit) visit(k, l);
    }
  }

  void judge(const std::vector<int>& group, bool same_track, ConsistentLoops& result, std::vector<char>& is_rejected) {
    double limit = options_.informative * options_.informative / scale_;
    std::size_t count = 0;
    for (int tries = 0; tries < 60; ++tries) {
      count = 0;
      for_each_pair(group, limit, [&](std::size_t, std::size_t) { ++count; });
      if (count <= options_.most_pairs) break;
      limit *= 0.5;
    }
    result.informative = std::min(result.informative, std::sqrt(limit * scale_));
    result.pairs += count;
    std::vector<std::vector<int>> conflicts(group.size());
    constexpr double kClose = 0.1;  // of the limit: a pair whose agreement says much
    std::vector<char> tried(group.size(), 0);
    for_each_pair(group, limit, [&](std::size_t k, std::size_t l) {
      tried[k] = tried[l] = 1;
      const Loop &a = loops_[group[k]], &b = loops_[group[l]];
      if (agree(a, b, same_track)) {
        const bool are_twins = std::abs(a.first - b.first) <= kTwins && std::abs(a.second - b.second) <= kTwins;
        if (!are_twins && turn_between(a, b) <= kClose * limit) {
          ++support_[group[k]];
          ++support_[group[l]];
        }
        return;
      }
      conflicts[k].push_back(static_cast<int>(l));
      conflicts[l].push_back(static_cast<int>(k));
      ++result.disagreeing;
    });
    for (auto& of_one : conflicts) std::sort(of_one.begin(), of_one.end());
    const detail::IndependentSet kept = detail::largest_independent_set(conflicts, options_.time_limit);
    result.is_exact = result.is_exact && kept.is_exact;
    std::vector<char> is_kept(group.size(), 0);
    for (int k : kept.members) is_kept[k] = 1;
    for (std::size_t k = 0; k < group.size(); ++k) {
      if (is_kept[k] == 0) is_rejected[static_cast<std::size_t>(ids_[group[k]].number)] = 1;
      if (tried[k] == 0) ++result.untested;
    }
  }

  /// The noise that a track has gathered between two of its poses, in its frame.
  Square gathered(int i, int j) const { return sums_[std::max(i, j)] - sums_[std::min(i, j)]; }

  bool agree(const Loop& a, const Loop& b, bool same_track) const { return !(chi_squared(a, b, same_track) > limit_ * scale_); }

  /// With the covariances as they are given; NaN where they are singular.
  double chi_squared(const Loop& a, const Loop& b, bool same_track) const {
    const Vector<dim> e = log_of(a.X * b.X.inverse());
    Square S = a.noise + b.noise + gathered(a.first, b.first) + a.Ad * gathered(a.second, b.second) * a.Ad.transpose();
    if (same_track) {
      const int low = std::max(std::min(a.first, b.first), std::min(a.second, b.second));
      const int high = std::min(std::max(a.first, b.first), std::max(a.second, b.second));
      if (low < high) {
        const double sign = (a.first < b.first) == (a.second < b.second) ? -1 : 1;
        const Square common = a.Ad * gathered(low, high);
        S += sign * (common + common.transpose());
      }
    }
    const auto cholesky = S.llt();
    return cholesky.info() != Eigen::Success ? NAN : e.dot(cholesky.solve(e));
  }

  const Graph& graph_;
  const PairwiseConsistencyOptions& options_;
  double limit_;
  double scale_ = 1;  ///< of every covariance
  std::vector<Edge> odometry_, loop_edges_;
  std::map<Key, Place> places_;
  std::vector<Pose> poses_;    ///< by dead reckoning, track after track
  std::vector<Square> sums_;   ///< of the noise of each step, in the frame of the track
  std::vector<double> turns_;  ///< [rad²] an axis
  int tracks_ = 0;
  std::vector<Loop> loops_;
  std::vector<FactorId> ids_;
  std::vector<int> support_;  ///< of each loop: others that are no twins, and agree where it says much
  std::map<std::pair<int, int>, std::vector<int>> groups_;
};

void require_relative_poses(const Graph& graph, const std::vector<FactorId>& odometry) {
  for (const FactorId id : odometry) {
    const Graph::Place& place = graph.place(id);
    const FactorBatch& batch = *graph.batches()[place.batch];
    if (dynamic_cast<const RelativePoses<Pose2>*>(&batch) == nullptr && dynamic_cast<const RelativePoses<Pose3>*>(&batch) == nullptr)
      fail<BadType>("PairwiseConsistencyOptions.odometry has ", batch.describe(place.index), ", which is no relative pose; leave it out");
  }
}

}  // namespace

void PairwiseConsistencyOptions::validate() const {
  const auto require = [](bool holds, const char* field, double value, const char* rule) {
    if (!holds) fail<BadOption>("PairwiseConsistencyOptions.", field, " = ", value, " must be ", rule);
  };
  require(false_alarm > 0 && false_alarm < 1, "false_alarm", false_alarm, "between 0 and 1; 1e-4 is usual");
  require(informative > 0, "informative", informative, "> 0 [rad]");
  require(most_pairs >= 1, "most_pairs", static_cast<double>(most_pairs), ">= 1");
  require(time_limit >= 0, "time_limit", time_limit, ">= 0 [s]");
  require(noise_scale >= 0 && std::isfinite(noise_scale), "noise_scale", noise_scale, "finite and >= 0; 0 estimates it");
}

ConsistentLoops consistent_loops(const Graph& graph, const PairwiseConsistencyOptions& options) {
  const auto begin = std::chrono::steady_clock::now();
  options.validate();
  require_relative_poses(graph, options.odometry);
  ConsistentLoops result;
  result.informative = options.informative;
  std::vector<char> is_rejected(graph.numbers().generations.size(), 0);
  Consistency<Pose2> flat(graph, options);
  Consistency<Pose3> spatial(graph, options);
  flat.add_to(result, is_rejected);
  spatial.add_to(result, is_rejected);
  for (const auto* loops : {&flat.loops(), &spatial.loops()})
    for (const FactorId id : *loops) (is_rejected[static_cast<std::size_t>(id.number)] != 0 ? result.rejected : result.kept).push_back(id);
  result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return result;
}

std::vector<FactorId> agreeing_loops(const Graph& graph, const Values& values, const std::vector<FactorId>& loops, double false_alarm) {
  if (!(false_alarm > 0 && false_alarm < 1)) fail<BadOption>("false_alarm = ", false_alarm, " must be between 0 and 1; 0.01 is usual");
  const double limits[] = {chi_squared_limit(3, false_alarm), chi_squared_limit(6, false_alarm)};
  std::vector<FactorId> agreeing;
  for (const FactorId id : loops) {
    const Eigen::VectorXd r = graph.residual(id, values);
    if (r.squaredNorm() < limits[r.size() == 3 ? 0 : 1]) agreeing.push_back(id);
  }
  return agreeing;
}

std::string ConsistentLoops::str() const {
  std::ostringstream text;
  text << kept.size() << " of " << kept.size() + rejected.size() << " loops agree with each other, " << rejected.size() << " rejected; "
       << disagreeing << " of " << pairs << " pairs disagree, " << untested << (untested == 1 ? " loop has" : " loops have")
       << " no pair to be tested with; " << groups << (groups == 1 ? " group, " : " groups, ") << "noise scale " << noise_scale << ", "
       << (is_exact ? "largest sets" : "sets found in the time there was") << ", " << seconds << " s";
  return text.str();
}

}  // namespace holdfast
