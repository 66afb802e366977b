#include <Eigen/Cholesky>
#include <algorithm>
#include <chrono>
#include <holdfast/graph/variables.hpp>
#include <holdfast/solvers/chi_square.hpp>
#include <holdfast/solvers/internal/measured_distance.hpp>
#include <holdfast/solvers/range_consistency.hpp>
#include <map>
#include <sstream>

namespace holdfast {
namespace {

constexpr int kMostRefinements = 5, kGaussNewtonSteps = 5;

/// Of each of all ranges, windows that keep it less those that reject it.
struct Verdicts {
  std::vector<int> votes;
  std::vector<char> is_judged;
  std::size_t windows = 0, decided = 0;
};

/// Of a range that agrees with a place: r², its own variance, and the odometry's as it is given.
struct Misfit {
  double square, noise, drift;
};

/// The scale of the odometry's variances at which the lower quartile of r² / variance is the 40 % quantile of χ².
double fitting_scale(const std::vector<Misfit>& misfits) {
  constexpr double kLeast = 1e-4;
  const double quantile = chi_square_quantile(0.4, 1);
  std::vector<double> ratios(misfits.size());
  double low = kLeast, high = 1;
  for (int i = 0; i < 30 && !misfits.empty(); ++i) {
    const double scale = std::sqrt(low * high);
    for (std::size_t k = 0; k < misfits.size(); ++k) ratios[k] = misfits[k].square / (misfits[k].noise + scale * misfits[k].drift);
    std::nth_element(ratios.begin(), ratios.begin() + static_cast<std::ptrdiff_t>(ratios.size() / 4), ratios.end());
    (ratios[ratios.size() / 4] > quantile ? low : high) = scale;
  }
  return high;
}

/// A pose of a track.
template <int n>
struct Place {
  int track;
  int number;  ///< grows along a track, and from track to track
  Vector<n> p;
  double V, H;  ///< cumulated variances of the odometry, an axis: translation [m²], heading [rad²]
};

/// A range between a track and a point, whose q is 0, or between two tracks.
template <int n>
struct RangeOfTrack {
  int index;  ///< among all ranges
  int number;
  Vector<n> p, q;
  double r, sigma;
  double V[2], H[2];  ///< of both ends

  /// Of where its ends are as seen from those of c.
  double variance_from(const RangeOfTrack& c) const {
    return std::abs(V[0] - c.V[0]) + std::abs(V[1] - c.V[1]) +
           (std::abs(H[0] - c.H[0]) * (p - c.p).squaredNorm() + std::abs(H[1] - c.H[1]) * (q - c.q).squaredNorm()) / 3;
  }
};

/// Where the point is, or how the second track lies in the frame of the first.
template <int n>
struct Whereabouts {
  Vector<n> x = Vector<n>::Zero();
  double angle = 0;  ///< in the plane alone

  Vector<n> turned(const Vector<n>& q) const {
    if constexpr (n == 2) return {std::cos(angle) * q[0] - std::sin(angle) * q[1], std::sin(angle) * q[0] + std::cos(angle) * q[1]};
    return q;
  }
  Vector<n> way(const RangeOfTrack<n>& range) const { return turned(range.q) + x - range.p; }
};

/// Where two circles cross; the nearest place between them where they just do not.
std::vector<Vector<2>> crossings(const Vector<2>& a, double r, const Vector<2>& b, double s) {
  const Vector<2> way = b - a;
  const double d = way.norm();
  if (d < 1e-6) return {};
  const double along = (d * d + r * r - s * s) / (2 * d), across = std::sqrt(std::max(0.0, r * r - along * along));
  const Vector<2> u = way / d, foot = a + along * u;
  return {foot + across * Vector<2>(-u[1], u[0]), foot - across * Vector<2>(-u[1], u[0])};
}

/// Where three spheres cross.
std::vector<Vector<3>> crossings(const std::array<const RangeOfTrack<3>*, 3>& of) {
  const Vector<3> a = of[0]->p, ab = of[1]->p - a, ac = of[2]->p - a;
  const double d = ab.norm();
  if (d < 1e-6) return {};
  const Vector<3> ex = ab / d;
  const double i = ex.dot(ac);
  const Vector<3> rest = ac - i * ex;
  const double j = rest.norm();
  if (j < 1e-6) return {};
  const Vector<3> ey = rest / j;
  const double r = of[0]->r, s = of[1]->r, t = of[2]->r;
  const double x = (r * r - s * s + d * d) / (2 * d), y = (r * r - t * t + i * i + j * j - 2 * i * x) / (2 * j);
  const Vector<3> foot = a + x * ex + y * ey, up = std::sqrt(std::max(0.0, r * r - x * x - y * y)) * ex.cross(ey);
  return {foot + up, foot - up};
}

/// The ranges between one track and one point, or between two tracks, window by window.
template <int n>
class Group {
 public:
  using Range = RangeOfTrack<n>;

  Group(std::vector<Range> ranges, bool of_two_tracks, const RangeConsistencyOptions& options)
      : ranges_(std::move(ranges)),
        of_two_tracks_(of_two_tracks),
        options_(options),
        limit_(chi_square_quantile(1 - options.false_alarm, 1)) {
    std::stable_sort(ranges_.begin(), ranges_.end(), [](const Range& a, const Range& b) { return a.number < b.number; });
  }

  /// The odometry's variances count `scale` times.
  void judge(double scale, Verdicts& verdicts) {
    scale_ = scale;
    for_each_window(options_.window / 4, [&](const Whereabouts<n>* best) {
      ++verdicts.windows;
      if (best == nullptr) return;
      ++verdicts.decided;
      for (int k = begin_; k < end_; ++k) {
        verdicts.votes[ranges_[k].index] += agrees(k, *best) ? 1 : -1;
        verdicts.is_judged[ranges_[k].index] = 1;
      }
    });
  }

  void collect(double scale, std::vector<Misfit>& misfits) {
    scale_ = scale;
    for_each_window(options_.window, [&](const Whereabouts<n>* best) {
      for (int k = begin_; best != nullptr && k < end_; ++k) {
        if (!agrees(k, *best)) continue;
        const double r = best->way(ranges_[k]).norm() - ranges_[k].r, noise = ranges_[k].sigma * ranges_[k].sigma;
        misfits.push_back({r * r, noise, (variance_[k - begin_] - noise) / scale_});
      }
    });
  }

 private:
  /// visit(the place that the window's ranges agree with, null where they do not).
  template <class Visit>
  void for_each_window(int step, const Visit& visit) {
    for (int middle = 0; middle < static_cast<int>(ranges_.size()); middle += step) {
      open_window(middle);
      if (end_ - begin_ < fewest()) {
        visit(nullptr);
        continue;
      }
      const Whereabouts<n> best = refined(proposed());
      const bool has_decided = count(best) >= std::max<double>(fewest(), options_.least_share * (end_ - begin_));
      visit(has_decided ? &best : nullptr);
    }
  }

  int fewest() const { return n + 2 + (of_two_tracks_ ? 1 : 0); }

  void open_window(int middle) {
    const auto is_near = [&](int k) {
      const double most = options_.drift * ranges_[k].sigma;
      return scale_ * ranges_[k].variance_from(ranges_[middle]) <= most * most;
    };
    const int size = static_cast<int>(ranges_.size()), half = options_.window / 2;
    begin_ = middle;
    while (begin_ > std::max(0, middle - half) && is_near(begin_ - 1)) --begin_;
    end_ = middle + 1;
    while (end_ < std::min(size, middle + half) && is_near(end_)) ++end_;
    variance_.clear();
    for (int k = begin_; k < end_; ++k)
      variance_.push_back(ranges_[k].sigma * ranges_[k].sigma + scale_ * ranges_[k].variance_from(ranges_[middle]));
  }

  double chi_square(int k, const Whereabouts<n>& where) const {
    const double r = where.way(ranges_[k]).norm() - ranges_[k].r;
    return r * r / variance_[k - begin_];
  }
  bool agrees(int k, const Whereabouts<n>& where) const { return chi_square(k, where) < limit_; }
  int count(const Whereabouts<n>& where) const {
    int agreeing = 0;
    for (int k = begin_; k < end_; ++k) agreeing += agrees(k, where) ? 1 : 0;
    return agreeing;
  }

  /// The place that most ranges of the window agree with, of those proposed.
  Whereabouts<n> proposed() const {
    Whereabouts<n> best;
    int most = count(best);
    const auto propose = [&](const Whereabouts<n>& where) {
      const int agreeing = count(where);
      if (agreeing > most) best = where, most = agreeing;
    };
    const int turns = of_two_tracks_ ? options_.turns : 1;
    for (int turn = 0; turn < turns; ++turn) {
      Whereabouts<n> where;
      where.angle = 2 * kPi * turn / turns;
      draw_ = 1;
      for (int k = 0; k < (of_two_tracks_ ? (options_.proposals + 3) / 4 : options_.proposals); ++k)
        for (const Vector<n>& x : crossings_of_a_few(where)) {
          where.x = x;
          propose(where);
        }
    }
    return best;
  }

  std::vector<Vector<n>> crossings_of_a_few(const Whereabouts<n>& where) const {
    if constexpr (n == 2) {
      const Range &a = any(), &b = any();
      return crossings(a.p - where.turned(a.q), a.r, b.p - where.turned(b.q), b.r);
    } else {
      return crossings({&any(), &any(), &any()});
    }
  }
  /// Range after range of the window, in an order without pattern (Knuth's linear congruential generator).
  const Range& any() const {
    draw_ = draw_ * 6364136223846793005ULL + 1442695040888963407ULL;
    return ranges_[begin_ + static_cast<int>((draw_ >> 33) % static_cast<std::uint64_t>(end_ - begin_))];
  }

  Whereabouts<n> refined(Whereabouts<n> best) const {
    for (int i = 0; i < kMostRefinements; ++i) {
      const Whereabouts<n> next = moved(best);
      if (count(next) < count(best)) break;
      best = next;
    }
    return best;
  }

  /// Gauss–Newton over the ranges that agree.
  Whereabouts<n> moved(Whereabouts<n> where) const {
    std::vector<int> agreeing;
    for (int k = begin_; k < end_; ++k)
      if (agrees(k, where)) agreeing.push_back(k);
    for (int step = 0; step < kGaussNewtonSteps; ++step) {
      Matrix<n + 1, n + 1> H = 1e-9 * Matrix<n + 1, n + 1>::Identity();
      Vector<n + 1> g = Vector<n + 1>::Zero();
      for (const int k : agreeing) {
        const Vector<n> way = where.way(ranges_[k]);
        const double length = std::max(1e-9, way.norm()), r = length - ranges_[k].r, w = 1 / variance_[k - begin_];
        Vector<n + 1> J = Vector<n + 1>::Zero();
        J.template head<n>() = way / length;
        if constexpr (n == 2) {
          const Vector<2> q = where.turned(ranges_[k].q);
          if (of_two_tracks_) J[n] = (way[1] * q[0] - way[0] * q[1]) / length;
        }
        H += w * J * J.transpose();
        g += w * r * J;
      }
      const Vector<n + 1> delta = H.ldlt().solve(-g);
      if (!delta.allFinite()) break;
      where.x += delta.template head<n>();
      where.angle += delta[n];
    }
    return where;
  }

  std::vector<Range> ranges_;
  bool of_two_tracks_;
  const RangeConsistencyOptions& options_;
  double limit_;
  double scale_ = 1;
  int begin_ = 0, end_ = 0;  // the window
  std::vector<double> variance_;
  mutable std::uint64_t draw_ = 1;
};

/// One kind of pose, and the points of its space.
template <class Pose>
class Judge {
 public:
  static constexpr int n = Pose::space_dim;
  using Point = std::conditional_t<n == 2, Point2, Point3>;

  Judge(const Graph& graph, const RangeConsistencyOptions& options) : graph_(graph), options_(options) { make_tracks(); }

  /// Sorts the ranges into groups.
  void take(const std::vector<FactorId>& ranges, const std::vector<detail::MeasuredDistance>& measured) {
    std::map<std::pair<int, Key>, std::vector<RangeOfTrack<n>>> of_points;
    std::map<std::pair<int, int>, std::vector<RangeOfTrack<n>>> of_tracks;
    for (std::size_t i = 0; i < ranges.size(); ++i) {
      const Graph::Place& at = graph_.place(ranges[i]);
      const FactorBatch& batch = *graph_.batches()[at.batch];
      const Key* const keys = batch.keys(at.index);
      const auto place = [&](int k) { return batch.types()[k] == typeid(Pose) ? places_.find(keys[k]) : places_.end(); };
      auto a = place(0), b = place(1);
      const bool swapped = a == places_.end() || (b != places_.end() && b->second.number < a->second.number);
      if (swapped) std::swap(a, b);
      if (a == places_.end()) continue;
      RangeOfTrack<n> range{static_cast<int>(i),  a->second.number,  a->second.p,      Vector<n>::Zero(),
                            measured[i].distance, measured[i].sigma, {a->second.V, 0}, {a->second.H, 0}};
      if (b != places_.end()) {
        if (n != 2 || a->second.track == b->second.track) continue;
        range.q = b->second.p;
        range.V[1] = b->second.V;
        range.H[1] = b->second.H;
        of_tracks[{a->second.track, b->second.track}].push_back(range);
      } else if (batch.types()[swapped ? 0 : 1] == typeid(Point)) {
        of_points[{a->second.track, keys[swapped ? 0 : 1]}].push_back(range);
      }
    }
    for (auto& [pair, group] : of_points) groups_.emplace_back(std::move(group), false, options_);
    for (auto& [pair, group] : of_tracks) groups_.emplace_back(std::move(group), true, options_);
  }

  std::size_t groups() const { return groups_.size(); }
  void collect(double scale, std::vector<Misfit>& misfits) {
    for (Group<n>& group : groups_) group.collect(scale, misfits);
  }
  void judge(double scale, Verdicts& verdicts) {
    for (Group<n>& group : groups_) group.judge(scale, verdicts);
  }

 private:
  struct Edge {
    Key first, second;
    MeasuredPose<Pose> measured;
  };

  std::vector<Edge> odometry() const {
    std::vector<Edge> edges;
    const auto add = [&](const FactorBatch& batch, int i) {
      const auto* const poses = dynamic_cast<const RelativePoses<Pose>*>(&batch);
      if (poses != nullptr && batch.weight(i) > 0) edges.push_back({batch.keys(i)[0], batch.keys(i)[1], poses->measured_pose(i)});
    };
    for (const FactorId id : options_.odometry) add(*graph_.batches()[graph_.place(id).batch], graph_.place(id).index);
    if (!options_.odometry.empty()) return edges;
    for (const auto& batch : graph_.batches())
      for (int i = 0; batch->arity() == 2 && i < batch->size(); ++i) {
        const Key a = batch->keys(i)[0], b = batch->keys(i)[1];
        if (a.agent() == b.agent() && std::max(a.step(), b.step()) - std::min(a.step(), b.step()) == 1) add(*batch, i);
      }
    return edges;
  }

  /// Dead reckoning along each agent's poses, from each pose to the one after it.
  void make_tracks() {
    std::map<Key, Edge> next;  // of each pose, the way to a later one
    std::map<Key, char> poses;
    for (Edge edge : odometry()) {
      if (edge.second < edge.first) {
        std::swap(edge.first, edge.second);
        edge.measured.pose = edge.measured.pose.inverse();
      }
      next.try_emplace(edge.first, edge);
      poses[edge.first];
      poses[edge.second];
    }
    int tracks = 0, number = 0;
    for (const auto& [start, unused] : poses) {
      if (places_.count(start) != 0) continue;
      Pose T;
      double V = 0, H = 0;
      for (Key here = start; places_.try_emplace(here, Place<n>{tracks, number, T.p, V, H}).second;) {
        ++number;
        const auto edge = next.find(here);
        if (edge == next.end()) break;
        const Matrix<Pose::dim, Pose::dim> covariance = covariance_of(edge->second.measured.information);
        T = T * edge->second.measured.pose;
        V += covariance.diagonal().template head<n>().mean();
        H += covariance.diagonal().template tail<Pose::dim - n>().mean();
        here = edge->second.second;
      }
      ++tracks;
    }
  }

  static Matrix<Pose::dim, Pose::dim> covariance_of(Matrix<Pose::dim, Pose::dim> information) {
    information.diagonal().array() += 1e-9 * information.diagonal().maxCoeff();
    return information.llt().solve(Matrix<Pose::dim, Pose::dim>::Identity());
  }

  const Graph& graph_;
  const RangeConsistencyOptions& options_;
  std::map<Key, Place<n>> places_;
  std::vector<Group<n>> groups_;
};

/// From where it is given downwards: each scale shows more plainly which ranges agree, and those tell the next one.
double estimated_scale(Judge<Pose2>& flat, Judge<Pose3>& spatial) {
  constexpr int kRounds = 3;
  constexpr double kSafety = 3;
  double scale = 1;
  for (int round = 0; round < kRounds; ++round) {
    std::vector<Misfit> misfits;
    flat.collect(scale, misfits);
    spatial.collect(scale, misfits);
    scale = std::min(scale, kSafety * fitting_scale(misfits));
  }
  return scale;
}

void require_relative_poses(const Graph& graph, const std::vector<FactorId>& odometry) {
  for (const FactorId id : odometry) {
    const Graph::Place& place = graph.place(id);
    const FactorBatch& batch = *graph.batches()[place.batch];
    if (dynamic_cast<const RelativePoses<Pose2>*>(&batch) == nullptr && dynamic_cast<const RelativePoses<Pose3>*>(&batch) == nullptr)
      fail<BadType>("RangeConsistencyOptions.odometry has ", batch.describe(place.index), ", which is no relative pose; leave it out");
  }
}

}  // namespace

void RangeConsistencyOptions::validate() const {
  const auto require = [](bool holds, const char* field, double value, const char* rule) {
    if (!holds) fail<BadOption>("RangeConsistencyOptions.", field, " = ", value, " must be ", rule);
  };
  require(false_alarm > 0 && false_alarm < 1, "false_alarm", false_alarm, "between 0 and 1; 1e-3 is usual");
  require(window >= 8, "window", window, ">= 8 ranges");
  require(drift > 0 && std::isfinite(drift), "drift", drift, "finite and > 0 [sigmas of a range]");
  require(least_share > 0 && least_share <= 1, "least_share", least_share, "in (0, 1]");
  require(proposals >= 1, "proposals", proposals, ">= 1");
  require(turns >= 4, "turns", turns, ">= 4");
  require(noise_scale >= 0 && std::isfinite(noise_scale), "noise_scale", noise_scale, "finite and >= 0; 0 estimates it");
}

ConsistentRanges consistent_ranges(const Graph& graph, const RangeConsistencyOptions& options) {
  const auto begin = std::chrono::steady_clock::now();
  options.validate();
  require_relative_poses(graph, options.odometry);
  std::vector<FactorId> ranges;
  std::vector<detail::MeasuredDistance> measured;
  for (std::size_t b = 0; b < graph.batches().size(); ++b)
    for (int i = 0; i < graph.batches()[b]->size(); ++i) {
      if (!(graph.batches()[b]->weight(i) > 0)) continue;
      const auto distance = detail::measured_distance(*graph.batches()[b], i);
      if (!distance) continue;
      ranges.push_back(graph.id_of(static_cast<int>(b), i));
      measured.push_back(*distance);
    }
  ConsistentRanges result;
  Judge<Pose2> flat(graph, options);
  Judge<Pose3> spatial(graph, options);
  flat.take(ranges, measured);
  spatial.take(ranges, measured);
  result.groups = flat.groups() + spatial.groups();
  result.noise_scale = options.noise_scale > 0 ? options.noise_scale : estimated_scale(flat, spatial);
  Verdicts verdicts{std::vector<int>(ranges.size(), 0), std::vector<char>(ranges.size(), 0)};
  flat.judge(result.noise_scale, verdicts);
  spatial.judge(result.noise_scale, verdicts);
  result.windows = verdicts.windows;
  result.decided = verdicts.decided;
  for (std::size_t i = 0; i < ranges.size(); ++i) {
    (verdicts.votes[i] < 0 ? result.rejected : result.kept).push_back(ranges[i]);
    if (verdicts.is_judged[i] == 0) ++result.untested;
  }
  result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return result;
}

std::string ConsistentRanges::str() const {
  std::ostringstream text;
  text << kept.size() << " of " << kept.size() + rejected.size() << " ranges agree with each other, " << rejected.size() << " rejected, "
       << untested << (untested == 1 ? " was" : " were") << " not judged; " << groups << (groups == 1 ? " group, " : " groups, ") << decided
       << " of " << windows << " windows judged, noise scale " << noise_scale << ", " << seconds << " s";
  return text.str();
}

}  // namespace holdfast
