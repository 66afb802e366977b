#include <algorithm>
#include <holdfast/adapters/files/to_dataset.hpp>
#include <holdfast/adapters/files/vertex_value.hpp>
#include <holdfast/factors/between.hpp>
#include <holdfast/factors/prior.hpp>
#include <holdfast/factors/range.hpp>
#include <holdfast/factors/relative_point.hpp>

namespace holdfast {
namespace {

template <int N>
Matrix<N, N> information_of(const Matrix<N, N>& sqrt_information) {
  const Matrix<N, N> I = sqrt_information.transpose() * sqrt_information;
  return 0.5 * (I + I.transpose());
}

/// Noise of a deviation measured⁻¹ · predicted in the convention of a format.
template <class V>
MatrixNoise<V::dim> noise_of(const Matrix<V::dim, V::dim>& information, const V& measured, Format format) {
  return MatrixNoise<V::dim>::of_information(information, format, measured);
}

/// Takes the factors of known types out of a graph, one list after the other.
class Writer {
 public:
  Writer(const Graph& graph, const Values& values, Format format) : graph_(graph), format_(format) {
    dataset_.format = format, add_vertices(values);
  }

  Dataset write() {
    for (const auto& batch : graph_.batches()) {
      if (batch->size() == 0) continue;
      const bool known = take<Between<Pose2>>(*batch) || take<Between<Pose3>>(*batch) || take<Prior<Pose2>>(*batch) ||
                         take<Prior<Pose3>>(*batch) || take<Prior<Point2>>(*batch) || take<Prior<Point3>>(*batch) ||
                         take<RelativePoint<Pose2, Point2>>(*batch) || take<RelativePoint<Pose3, Point3>>(*batch) ||
                         take_ranges<Pose2, Point2>(*batch) || take_ranges<Pose3, Point3>(*batch);
      if (!known) fail<BadOption>("no file holds ", batch->describe(0), "; remove it from the graph, or write it by hand");
    }
    std::vector<Key> fixed(graph_.fixed().begin(), graph_.fixed().end());
    std::sort(fixed.begin(), fixed.end());
    for (Key key : fixed) dataset_.fixed.push_back({key});
    return std::move(dataset_);
  }

 private:
  void add_vertices(const Values& values) {
    for (Key key : values.keys()) {
      const std::optional<VertexValue> value = vertex_value(values, key);
      if (!value) fail<BadOption>("no file holds ", key, ", a ", type_name(values, key), "; files have poses and points");
      dataset_.vertices.push_back({key, *value, {}, {}, 0});
    }
  }

  template <class A, class B>
  bool take_ranges(const FactorBatch& batch) {
    return take<Range<A, A>>(batch) || take<Range<A, B>>(batch) || take<Range<B, A>>(batch) || take<Range<B, B>>(batch);
  }
  template <class F>
  bool take(const FactorBatch& batch) {
    if (batch.factor_type() != typeid(F)) return false;
    for (int i = 0; i < batch.size(); ++i) {
      if (batch.loss(i).kind != Loss::Kind::Squared || batch.weight(i) != 1)
        fail<BadOption>("no file holds the loss ", batch.loss(i).str(), " and weight ", batch.weight(i), " of ", batch.describe(i),
                        "; set the loss when the file is read");
      dataset_.edges.push_back({edge_of(static_cast<const Batch<F>&>(batch).factors()[i], batch.keys(i)), {}, 0});
    }
    return true;
  }

  template <class V>
  Measurement edge_of(const Between<V>& f, const Key* keys) const {
    return RelativePoseEdge<V>{keys[0], keys[1], f.measured, {}, noise_of(information_of(f.sqrt_information), f.measured, format_)};
  }
  template <class V>
  Measurement edge_of(const Prior<V>& f, const Key* keys) const {
    Matrix<V::dim, V::dim> J = Matrix<V::dim, V::dim>::Identity();  // the tangent moves in the world, the deviation in the body
    if constexpr (V::dim > V::space_dim) J.template topLeftCorner<V::space_dim, V::space_dim>() = f.mean.rotation();
    return PriorEdge<V>{
        keys[0], f.mean, {}, noise_of(detail::congruence<V::dim>(J, information_of(f.sqrt_information)), f.mean, format_), {}};
  }
  template <class P, class L>
  Measurement edge_of(const RelativePoint<P, L>& f, const Key* keys) const {
    const L measured(f.measured);
    return RelativePointEdge<L>{keys[0], keys[1], measured, {}, noise_of(information_of(f.sqrt_information), measured, format_), {}};
  }
  template <class A, class B>
  Measurement edge_of(const Range<A, B>& f, const Key* keys) const {
    return RangeEdge{keys[0], keys[1], f.distance, f.sigma * f.sigma};
  }

  const Graph& graph_;
  Format format_;
  Dataset dataset_;
};

}  // namespace

Dataset to_dataset(const Graph& graph, const Values& values, Format format) { return Writer(graph, values, format).write(); }

}  // namespace holdfast
