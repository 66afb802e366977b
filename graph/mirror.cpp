#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <holdfast/graph/detail/union_find.hpp>
#include <holdfast/graph/mirror.hpp>
#include <holdfast/graph/resolved.hpp>
#include <map>
#include <set>

namespace holdfast {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kThickness = 1e-3;  // of the anchors, across their plane or line: of their extent in it
constexpr double kSameCost = 1;      // the fit of one side cannot be told from that of the other
constexpr double kSameRelative = 1e-6, kSameFarOff = 1e-2;

bool is_point(const Values& values, const Resolved::Variable& variable) {
  const PoolBase& pool = values.pool(variable.pool);
  return pool.is_vector_space() && pool.space() == pool.dim() && pool.space() > 0;
}

/// Calls fn(batch, i, variable numbers of factor i).
template <class Fn>
void for_each_factor(const Graph& graph, const Resolved& resolved, const Fn& fn) {
  for (std::size_t b = 0; b < graph.batches().size(); ++b) {
    const FactorBatch& batch = *graph.batches()[b];
    for (int i = 0; i < batch.size(); ++i)
      fn(static_cast<int>(b), i, &resolved.batches()[b].variable[static_cast<std::size_t>(i) * batch.arity()], batch.arity());
  }
}

class MirrorSearch {
 public:
  MirrorSearch(const Graph& graph, const Values& values) : graph_(graph), values_(values), resolved_(graph, values) {}

  std::vector<MirrorImage> find() {
    group_points();
    std::vector<MirrorImage> candidates;
    for (const auto& [root, group] : groups_) {
      MirrorImage image;
      if (lies_flat(group, image)) {
        candidate_of_[root] = static_cast<int>(candidates.size());
        candidates.push_back(std::move(image));
      }
    }
    if (candidates.empty()) return candidates;
    const std::vector<double> here = costs(values_, candidates.size());
    const std::vector<double> there = costs(all_mirrored(candidates, values_), candidates.size());
    const Values off = all_moved_off(candidates);
    const std::vector<double> off_here = costs(off, candidates.size());
    const std::vector<double> off_there = costs(all_mirrored(candidates, off), candidates.size());
    std::vector<MirrorImage> found;
    for (std::size_t c = 0; c < candidates.size(); ++c) {
      const double difference = std::abs(there[c] - here[c]), off_difference = std::abs(off_there[c] - off_here[c]);
      if (difference <= std::max(kSameCost, kSameRelative * here[c]) && off_difference <= std::max(kSameCost, kSameFarOff * off_here[c]))
        found.push_back(std::move(candidates[c]));
    }
    return found;
  }

 private:
  struct Group {
    std::vector<int> points;
    std::set<int> anchors;
  };

  /// Free points that no factor holds alone, tied by their common factors.
  void group_points() {
    const int n = static_cast<int>(resolved_.variables().size());
    std::vector<char> may_move(n);
    for (int v = 0; v < n; ++v) may_move[v] = resolved_.variables()[v].offset >= 0 && is_point(values_, resolved_.variables()[v]);
    for_each_factor(graph_, resolved_, [&](int, int, const int* v, int arity) {
      if (arity == 1) may_move[v[0]] = false;
    });
    detail::UnionFind tied(n);
    for_each_factor(graph_, resolved_, [&](int, int, const int* v, int arity) {
      int first = -1;
      for (int k = 0; k < arity; ++k)
        if (may_move[v[k]]) {
          if (first >= 0) tied.unite(first, v[k]);
          first = v[k];
        }
    });
    root_.assign(n, -1);
    for (int v = 0; v < n; ++v)
      if (may_move[v]) groups_[root_[v] = tied.root(v)].points.push_back(v);
    for_each_factor(graph_, resolved_, [&](int, int, const int* v, int arity) {
      const int root = root_of_factor(v, arity);
      if (root < 0) return;
      for (int k = 0; k < arity; ++k)
        if (root_[v[k]] < 0) groups_[root].anchors.insert(v[k]);
    });
  }
  int root_of_factor(const int* v, int arity) const {
    for (int k = 0; k < arity; ++k)
      if (root_[v[k]] >= 0) return root_[v[k]];
    return -1;
  }

  /// True where the anchors span a plane in space, or a line in the plane, and no more.
  bool lies_flat(const Group& group, MirrorImage& image) const {
    const int space = values_.pool(resolved_.variables()[group.points.front()].pool).space();
    MatrixXd p(space, static_cast<Eigen::Index>(group.anchors.size()));
    Eigen::Index column = 0;
    for (const int v : group.anchors) {
      const Resolved::Variable& variable = resolved_.variables()[v];
      if (values_.pool(variable.pool).space() != space) return false;  // an angle, a bias: what it does to the others is not known
      values_.pool(variable.pool).position(variable.index, p.col(column++).data());
      image.anchors.push_back(variable.key);
    }
    if (p.cols() < space || !p.allFinite()) return false;
    image.origin = p.rowwise().mean();
    const MatrixXd centred = p.colwise() - image.origin;
    const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(centred * centred.transpose());
    const VectorXd extent = eigen.eigenvalues().cwiseMax(0).cwiseSqrt();
    if (!(extent[1] > kThickness * extent[space - 1]) || !(extent[0] <= kThickness * extent[1])) return false;
    image.normal = eigen.eigenvectors().col(0);
    for (const int v : group.points) image.points.push_back(resolved_.variables()[v].key);
    std::sort(image.points.begin(), image.points.end());
    std::sort(image.anchors.begin(), image.anchors.end());
    return true;
  }

  /// Σ w ½ρ of the factors on each candidate's points.
  std::vector<double> costs(const Values& at, std::size_t candidates) const {
    std::vector<double> sums(candidates, 0);
    for_each_factor(graph_, resolved_, [&](int b, int i, const int* v, int arity) {
      const int root = root_of_factor(v, arity);
      const auto it = candidate_of_.find(root);
      if (it != candidate_of_.end()) sums[it->second] += graph_.batches()[b]->cost(at, resolved_.batches()[b].index.data(), i, i + 1);
    });
    return sums;
  }

  static Values all_mirrored(const std::vector<MirrorImage>& candidates, Values values) {
    for (const MirrorImage& image : candidates) values = mirrored(values, image);
    return values;
  }
  /// The points by the anchors' extent to one side.
  Values all_moved_off(const std::vector<MirrorImage>& candidates) const {
    Values moved = values_;
    for (const MirrorImage& image : candidates) {
      double extent = 0;
      VectorXd p(image.origin.size());
      for (const Key key : image.anchors) {
        const Values::Slot slot = values_.slot(key);
        values_.pool(slot.pool).position(slot.index, p.data());
        extent = std::max(extent, (p - image.origin).norm());
      }
      for (const Key key : image.points) {
        const Values::Slot slot = moved.slot(key);
        Eigen::Map<VectorXd>(moved.pool(slot.pool).data(slot.index), image.normal.size()) += extent * image.normal;
      }
    }
    return moved;
  }

  const Graph& graph_;
  const Values& values_;
  Resolved resolved_;
  std::vector<int> root_;  // of each variable's group; −1: it is in none
  std::map<int, Group> groups_;
  std::map<int, int> candidate_of_;  // by root
};

}  // namespace

std::vector<MirrorImage> mirror_images(const Graph& graph, const Values& values) { return MirrorSearch(graph, values).find(); }

Values mirrored(const Values& values, const MirrorImage& image) {
  Values other = values;
  for (const Key key : image.points) {
    const Values::Slot slot = other.slot(key);
    Eigen::Map<VectorXd> p(other.pool(slot.pool).data(slot.index), image.normal.size());
    p -= 2 * image.normal.dot(p - image.origin) * image.normal;
  }
  return other;
}

}  // namespace holdfast
