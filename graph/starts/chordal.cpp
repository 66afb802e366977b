#include <Eigen/SVD>
#include <Eigen/SparseCholesky>
#include <holdfast/graph/detail/union_find.hpp>
#include <holdfast/graph/starts/chordal.hpp>
#include <map>
#include <set>

namespace holdfast {
namespace {

/// Normal equations of Σ ‖Y − B X − C‖²_M over pairs of nodes, each of n rows; nodes whose number is −1 are known.
template <int n>
class BlockSystem {
 public:
  using Square = Matrix<n, n>;
  using Block = Eigen::Matrix<double, n, Eigen::Dynamic>;

  BlockSystem(const std::vector<int>& unknown, int unknowns, int columns)
      : unknown_(unknown), rhs_(Eigen::MatrixXd::Zero(n * unknowns, columns)) {}

  /// x, y: the nodes; X, Y: their values where they are known.
  void add(int x, int y, const Square& B, const Square& M, const Block& C, const Block& X, const Block& Y) {
    const int i = unknown_[x], j = unknown_[y];
    if (j >= 0) {
      put(j, j, M);
      rhs_.middleRows<n>(n * j) += M * (i < 0 ? Block(C + B * X) : C);
    }
    if (i >= 0) {
      put(i, i, B.transpose() * M * B);
      rhs_.middleRows<n>(n * i) += B.transpose() * M * (j < 0 ? Block(Y - C) : Block(-C));
    }
    if (i >= 0 && j >= 0) {
      if (j > i)
        put(j, i, -M * B);
      else
        put(i, j, -B.transpose() * M);
    }
  }

  /// Empty where the system is singular.
  Eigen::MatrixXd solve() const {
    Eigen::SparseMatrix<double> H(rhs_.rows(), rhs_.rows());
    H.setFromTriplets(lower_.begin(), lower_.end());
    const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>, Eigen::Lower> cholesky(H);
    if (cholesky.info() != Eigen::Success || !(cholesky.vectorD().minCoeff() > 0)) return {};
    const Eigen::MatrixXd solution = cholesky.solve(rhs_);
    return solution.allFinite() ? solution : Eigen::MatrixXd();
  }

 private:
  void put(int row, int column, const Square& block) {
    for (int r = 0; r < n; ++r)
      for (int c = 0; c < n; ++c)
        if (row != column || r >= c) lower_.emplace_back(n * row + r, n * column + c, block(r, c));
  }

  const std::vector<int>& unknown_;
  std::vector<Eigen::Triplet<double>> lower_;
  Eigen::MatrixXd rhs_;
};

template <class Pose>
struct RelativePose {
  Key first, second;
  Pose measured;
  Matrix<Pose::dim, Pose::dim> information;
};

/// What there is to know of the poses of one type.
template <class Pose>
struct PoseGraph {
  std::vector<RelativePose<Pose>> edges;  // none of a pose to itself
  std::vector<Key> fixed;
  std::vector<std::pair<Key, Pose>> priors;
};

template <class Pose>
PoseGraph<Pose> pose_graph_of(const Dataset& dataset) {
  PoseGraph<Pose> result;
  for (const Edge& edge : dataset.edges) {
    if (const auto* pose = std::get_if<RelativePoseEdge<Pose>>(&edge.measurement); pose != nullptr && pose->first != pose->second)
      result.edges.push_back({pose->first, pose->second, pose->measured, pose->information()});
    if (const auto* prior = std::get_if<PriorEdge<Pose>>(&edge.measurement)) result.priors.emplace_back(prior->key, prior->measured);
  }
  for (const Fixed& fixed : dataset.fixed) result.fixed.push_back(fixed.key);
  return result;
}

template <class Pose>
PoseGraph<Pose> pose_graph_of(const Graph& graph) {
  PoseGraph<Pose> result;
  for (const auto& batch : graph.batches()) {
    const auto* const poses = dynamic_cast<const RelativePoses<Pose>*>(batch.get());
    if (poses == nullptr) continue;
    for (int i = 0; i < batch->size(); ++i) {
      const MeasuredPose<Pose> measured = poses->measured_pose(i);
      result.edges.push_back({batch->keys(i)[0], batch->keys(i)[1], measured.pose, measured.information});
    }
  }
  result.fixed.assign(graph.fixed().begin(), graph.fixed().end());
  return result;
}

/// Node numbers follow the keys.
template <class Pose>
class ChordalStart {
 public:
  ChordalStart(const PoseGraph<Pose>& graph, const Values& fallback) : graph_(graph) {
    for (const auto& edge : graph_.edges) number_.try_emplace(edge.first), number_.try_emplace(edge.second);
    for (auto& [key, number] : number_) {
      number = static_cast<int>(poses_.size());
      poses_.push_back(fallback.at<Pose>(key));
    }
    find_parts();
    hold();
  }

  /// Puts the poses of every part that could be solved into `values`; false where one could not.
  bool solve(Values& values) {
    bool all = true;
    std::vector<std::vector<const RelativePose<Pose>*>> edges(poses_.size());
    for (const auto& edge : graph_.edges) edges[part_[number_.at(edge.first)]].push_back(&edge);
    for (std::size_t part = 0; part < edges.size(); ++part) {
      if (edges[part].empty() || !number_unknowns(static_cast<int>(part))) continue;
      if (!solve_rotations(edges[part]) || !solve_translations(edges[part])) {
        all = false;
        continue;
      }
      for (const auto& [key, number] : number_)
        if (part_[number] == static_cast<int>(part)) values.update(key, poses_[number]);
    }
    return all;
  }

 private:
  static constexpr int n = Pose::space_dim;
  using System = BlockSystem<n>;
  using Square = Matrix<n, n>;

  /// part_ of a node: the lowest node it hangs together with.
  void find_parts() {
    detail::UnionFind parts(static_cast<int>(poses_.size()));
    for (const auto& edge : graph_.edges) parts.unite(number_.at(edge.first), number_.at(edge.second));
    for (int node = 0; node < static_cast<int>(poses_.size()); ++node) part_.push_back(parts.root(node));
  }

  void hold() {
    held_.assign(poses_.size(), false);
    std::set<int> parts_held;
    for (const Key key : graph_.fixed)
      if (const auto it = number_.find(key); it != number_.end()) {
        held_[it->second] = true;
        parts_held.insert(part_[it->second]);
      }
    std::map<int, Pose> priors;
    for (const auto& [key, measured] : graph_.priors)
      if (const auto it = number_.find(key); it != number_.end()) priors.try_emplace(it->second, measured);
    for (const auto& [node, pose] : priors)
      if (parts_held.insert(part_[node]).second) {
        held_[node] = true;
        poses_[node] = pose;
      }
    for (const int part : part_)
      if (parts_held.insert(part).second) held_[part] = true;
  }

  /// False where nothing is left to be found.
  bool number_unknowns(int part) {
    unknown_.assign(poses_.size(), -1);
    unknowns_ = 0;
    for (std::size_t node = 0; node < poses_.size(); ++node)
      if (part_[node] == part && !held_[node]) unknown_[node] = unknowns_++;
    return unknowns_ > 0;
  }

  /// In transposes, which stand in columns: R_jᵀ = R_ijᵀ R_iᵀ.
  bool solve_rotations(const std::vector<const RelativePose<Pose>*>& edges) {
    System system(unknown_, unknowns_, n);
    for (const auto* edge : edges) {
      const double kappa = edge->information.diagonal().template tail<Pose::dim - n>().mean();
      const int i = number_.at(edge->first), j = number_.at(edge->second);
      system.add(i, j, edge->measured.rotation().transpose(), kappa * Square::Identity(), Square::Zero(), poses_[i].rotation().transpose(),
                 poses_[j].rotation().transpose());
    }
    const Eigen::MatrixXd transposed = system.solve();
    if (transposed.size() == 0) return false;
    for (std::size_t node = 0; node < poses_.size(); ++node)
      if (unknown_[node] >= 0) set_rotation(poses_[node], transposed.middleRows<n>(n * unknown_[node]).transpose());
    return true;
  }

  /// The rotation nearest to M; where that is any of many, it stays as it was.
  static void set_rotation(Pose& pose, const Square& M) {
    const Eigen::JacobiSVD<Eigen::Matrix<double, n, n>> svd(M, Eigen::ComputeFullU | Eigen::ComputeFullV);
    if (!(svd.singularValues()[n - 2] > std::numeric_limits<double>::min())) return;
    Eigen::Matrix<double, n, n> U = svd.matrixU();
    if (U.determinant() * svd.matrixV().determinant() < 0) U.col(n - 1) *= -1;
    const Square R = U * svd.matrixV().transpose();
    if constexpr (n == 2)
      pose.heading = R.col(0);
    else
      pose.q = typename Pose::Rotation(R).normalized();
  }

  bool solve_translations(const std::vector<const RelativePose<Pose>*>& edges) {
    System system(unknown_, unknowns_, 1);
    for (const auto* edge : edges) {
      const int i = number_.at(edge->first), j = number_.at(edge->second);
      const Square R_world_measured = poses_[i].rotation() * edge->measured.rotation();
      const Square in_measured = whole(edge->information.template topLeftCorner<n, n>());
      system.add(i, j, Square::Identity(), R_world_measured * in_measured * R_world_measured.transpose(),
                 poses_[i].to_world(edge->measured.p), poses_[i].p, poses_[j].p);
    }
    const Eigen::MatrixXd positions = system.solve();
    if (positions.size() == 0) return false;
    for (std::size_t node = 0; node < poses_.size(); ++node)
      if (unknown_[node] >= 0) poses_[node].p = positions.middleRows<n>(n * unknown_[node]);
    return true;
  }

  /// A start may not stay open where the measurements say nothing (the height of a robot in the plane): as measured, by the least weight.
  static Square whole(const Square& information) {
    if (information.llt().info() == Eigen::Success) return information;
    constexpr double kLeast = 1e-9;  // of the largest entry
    return information + kLeast * std::max(information.cwiseAbs().maxCoeff(), std::numeric_limits<double>::min()) * Square::Identity();
  }

  const PoseGraph<Pose>& graph_;
  std::map<Key, int> number_;
  std::vector<Pose> poses_;
  std::vector<int> part_;
  std::vector<bool> held_;
  std::vector<int> unknown_;  ///< number among the unknowns of the part at hand; −1: held, or of another part
  int unknowns_ = 0;
};

/// The dataset with its poses at these values: landmarks without a vertex follow the poses they were seen from.
Dataset with_poses(const Dataset& dataset, const Values& values) {
  Dataset placed = dataset;
  std::set<Key> known;
  for (Vertex& vertex : placed.vertices) {
    known.insert(vertex.key);
    if (std::holds_alternative<Pose2>(vertex.value)) vertex.value = values.at<Pose2>(vertex.key);
    if (std::holds_alternative<Pose3>(vertex.value)) vertex.value = values.at<Pose3>(vertex.key);
  }
  for (const Key key : values.keys()) {
    if (known.count(key) != 0) continue;
    if (values.contains<Pose2>(key)) placed.vertices.push_back({key, values.at<Pose2>(key), {}, {}, 0});
    if (values.contains<Pose3>(key)) placed.vertices.push_back({key, values.at<Pose3>(key), {}, {}, 0});
  }
  return placed;
}

}  // namespace

Values chordal_start(const Dataset& dataset) {
  Values values = vertex_start(dataset);
  ChordalStart<Pose2>(pose_graph_of<Pose2>(dataset), values).solve(values);
  ChordalStart<Pose3>(pose_graph_of<Pose3>(dataset), values).solve(values);
  return vertex_start(with_poses(dataset, values));
}

bool chordal_start(const Graph& graph, Values& values) {
  for (const auto& batch : graph.batches())
    for (int k = 0; k < batch->arity(); ++k)
      if (batch->types()[k] != typeid(Pose2) && batch->types()[k] != typeid(Pose3))
        for (int i = 0; i < batch->size(); ++i)
          if (!graph.is_fixed(batch->keys(i)[k])) return false;
  const auto flat = pose_graph_of<Pose2>(graph);
  const auto spatial = pose_graph_of<Pose3>(graph);
  std::unordered_set<Key> reached;
  for (const auto& edge : flat.edges) reached.insert({edge.first, edge.second});
  for (const auto& edge : spatial.edges) reached.insert({edge.first, edge.second});
  for (const auto& batch : graph.batches())
    for (int i = 0; i < batch->size(); ++i)
      for (int k = 0; k < batch->arity(); ++k)
        if (const Key key = batch->keys(i)[k]; reached.count(key) == 0 && !graph.is_fixed(key)) return false;
  Values start = values;
  if (!ChordalStart<Pose2>(flat, start).solve(start) || !ChordalStart<Pose3>(spatial, start).solve(start)) return false;
  values.assign(start);
  return true;
}

}  // namespace holdfast
