#include <Eigen/Cholesky>
#include <holdfast/graph/variables.hpp>
#include <holdfast/solvers/internal/agreeing_loops.hpp>
#include <unordered_map>

namespace holdfast::detail {
namespace {

constexpr int kReach = 5;                         // trusted edges of a stretch
constexpr std::size_t kMostReached = 64;          // poses, where many edges meet
constexpr double kGate2 = 16.27, kGate3 = 22.46;  // 99.9 % of χ² with 3 and with 6 degrees of freedom

double angle_of(const Pose2& pose) { return std::abs(pose.angle()); }
double angle_of(const Pose3& pose) { return Pose3{}.local(pose).tail<3>().norm(); }

/// A relative pose and the variances of its position and its rotation, the largest of any direction [m², rad²].
template <class Pose>
struct Uncertain {
  Pose pose;
  double position = 0, rotation = 0;

  Uncertain inverse() const { return {pose.inverse(), position + rotation * pose.p.squaredNorm(), rotation}; }
  /// This one, then `next`: an error of rotation here moves the end of `next`.
  Uncertain operator*(const Uncertain& next) const {
    return {pose * next.pose, position + next.position + rotation * next.pose.p.squaredNorm(), rotation + next.rotation};
  }
};

/// The loops of one type of pose, and the trusted edges around their ends.
template <class Pose>
class LoopPairs {
  static constexpr int dim = Pose::dim, space = Pose::space_dim;
  using Edge = Uncertain<Pose>;

 public:
  void add_trusted(const RelativePoses<Pose>& poses, const FactorBatch& batch, int i) {
    Edge edge;
    if (!measured(poses, i, edge)) return;
    const int a = number(batch.keys(i)[0]), b = number(batch.keys(i)[1]);
    trusted_[a].push_back({b, edge});
    trusted_[b].push_back({a, edge.inverse()});
  }
  void add_loop(const RelativePoses<Pose>& poses, const FactorBatch& batch, int i, std::size_t candidate) {
    Edge edge;
    if (!measured(poses, i, edge)) return;
    const int a = number(batch.keys(i)[0]), b = number(batch.keys(i)[1]);
    loops_at_[a].push_back({static_cast<int>(loops_.size()), b, false});
    loops_at_[b].push_back({static_cast<int>(loops_.size()), a, true});
    loops_.push_back({a, b, edge, candidate});
  }
  void count(std::vector<int>& agreeing) {
    near_.resize(trusted_.size());
    for (std::size_t l = 0; l < loops_.size(); ++l) {
      const Loop& loop = loops_[l];
      for (const Reached& from : near(loop.first))
        for (const End& end : loops_at_[from.node]) {
          if (end.loop <= static_cast<int>(l)) continue;  // once a pair
          const Loop& other = loops_[end.loop];
          const Reached* const to = reached(loop.second, end.other);
          const bool same_pair = from.node == loop.first && end.other == loop.second;
          if (to == nullptr || same_pair || !agree(loop.edge, from.way, end.reversed ? other.edge.inverse() : other.edge, to->way))
            continue;
          ++agreeing[loop.candidate];
          ++agreeing[other.candidate];
        }
    }
  }

 private:
  struct Step {
    int to;
    Edge edge;
  };
  struct Loop {
    int first, second;
    Edge edge;
    std::size_t candidate;
  };
  /// A loop as one of its ends sees it.
  struct End {
    int loop, other;
    bool reversed;
  };
  struct Reached {
    int node;
    Edge way;  ///< from where the walk began
  };

  /// False where a direction has no information.
  static bool measured(const RelativePoses<Pose>& poses, int i, Edge& edge) {
    const MeasuredPose<Pose> z = poses.measured_pose(i);
    const Eigen::LLT<Matrix<dim, dim>> cholesky(z.information);
    if (cholesky.info() != Eigen::Success) return false;
    const Matrix<dim, dim> covariance = cholesky.solve(Matrix<dim, dim>::Identity());
    if (!covariance.allFinite()) return false;
    edge = {z.pose, covariance.diagonal().template head<space>().maxCoeff(), covariance.diagonal().template tail<dim - space>().maxCoeff()};
    return true;
  }
  int number(Key key) {
    const auto [place, is_new] = numbers_.try_emplace(key, static_cast<int>(trusted_.size()));
    if (is_new) {
      trusted_.emplace_back();
      loops_at_.emplace_back();
    }
    return place->second;
  }
  /// The poses within kReach trusted edges, by breadth-first search, the pose itself first.
  const std::vector<Reached>& near(int node) {
    std::vector<Reached>& all = near_[node];
    if (!all.empty()) return all;
    all.push_back({node, Edge{}});
    std::size_t next = 0;
    for (int hop = 0; hop < kReach; ++hop)
      for (const std::size_t end = all.size(); next < end && all.size() < kMostReached; ++next)
        for (const Step& step : trusted_[all[next].node]) {
          if (all.size() >= kMostReached || find(all, step.to) != nullptr) continue;
          all.push_back({step.to, all[next].way * step.edge});
        }
    return all;
  }
  static const Reached* find(const std::vector<Reached>& all, int node) {
    for (const Reached& one : all)
      if (one.node == node) return &one;
    return nullptr;
  }
  const Reached* reached(int from, int node) { return find(near(from), node); }

  static bool agree(const Edge& loop, const Edge& i_to_k, const Edge& other, const Edge& j_to_l) {
    const Edge ring = loop.inverse() * (i_to_k * (other * j_to_l.inverse()));
    const double angle = angle_of(ring.pose);
    return ring.pose.p.squaredNorm() / ring.position + angle * angle / ring.rotation <= (space == 2 ? kGate2 : kGate3);
  }

  std::unordered_map<Key, int> numbers_;
  std::vector<std::vector<Step>> trusted_;
  std::vector<std::vector<End>> loops_at_;
  std::vector<Loop> loops_;
  std::vector<std::vector<Reached>> near_;
};

template <class Pose>
void count_agreements(const Graph& graph, const std::vector<std::vector<int>>& candidate, std::vector<int>& agreeing) {
  LoopPairs<Pose> pairs;
  for (std::size_t b = 0; b < graph.batches().size(); ++b) {
    const FactorBatch& batch = *graph.batches()[b];
    const auto* const poses = dynamic_cast<const RelativePoses<Pose>*>(&batch);
    if (poses == nullptr) continue;
    for (int i = 0; i < batch.size(); ++i) {
      if (!(batch.weight(i) > 0)) continue;
      if (candidate[b][i] < 0)
        pairs.add_trusted(*poses, batch, i);
      else
        pairs.add_loop(*poses, batch, i, static_cast<std::size_t>(candidate[b][i]));
    }
  }
  pairs.count(agreeing);
}

}  // namespace

std::vector<int> agreements(const Graph& graph, const std::vector<FactorId>& candidates) {
  std::vector<std::vector<int>> candidate;
  for (const auto& batch : graph.batches()) candidate.emplace_back(batch->size(), -1);
  for (std::size_t c = 0; c < candidates.size(); ++c) {
    const Graph::Place& place = graph.place(candidates[c]);
    candidate[place.batch][place.index] = static_cast<int>(c);
  }
  std::vector<int> agreeing(candidates.size(), 0);
  count_agreements<Pose2>(graph, candidate, agreeing);
  count_agreements<Pose3>(graph, candidate, agreeing);
  return agreeing;
}

}  // namespace holdfast::detail
