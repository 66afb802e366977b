#include <gtsam/nonlinear/PriorFactor.h>
#include <gtsam/slam/BetweenFactor.h>

#include <holdfast/adapters/gtsam/graph.hpp>
#include <holdfast/factors/between.hpp>
#include <holdfast/factors/prior.hpp>
#include <holdfast/factors/range.hpp>
#include <holdfast/factors/relative_point.hpp>

namespace holdfast {
namespace {

/// What files hold goes with its type, so that it can come back; anything else by its batch.
using FileFactors =
    std::tuple<Between<Pose2>, Between<Pose3>, Prior<Pose2>, Prior<Pose3>, Prior<Point2>, Prior<Point3>, RelativePoint<Pose2, Point2>,
               RelativePoint<Pose3, Point3>, Range<Pose2, Pose2>, Range<Pose2, Point2>, Range<Point2, Pose2>, Range<Point2, Point2>,
               Range<Pose3, Pose3>, Range<Pose3, Point3>, Range<Point3, Pose3>, Range<Point3, Point3>>;

template <class F>
Term with_type(const FactorBatch& batch, int i) {
  std::array<Key, F::Variables::size> keys;
  std::copy_n(batch.keys(i), keys.size(), keys.begin());
  return Term(static_cast<const Batch<F>&>(batch).factors()[i], keys, batch.loss(i), batch.weight(i));
}
template <class... F>
Term term_of(const FactorBatch& batch, int i, std::tuple<F...>*) {
  Term term(batch, i);
  (void)((batch.factor_type() == typeid(F) && (term = with_type<F>(batch, i), true)) || ...);
  return term;
}

/// GTSAM's own BetweenFactor or PriorFactor of a pose; the information reordered to ours. False where it is neither.
template <class V>
bool add_native(const gtsam::NonlinearFactor& factor, Graph& graph) {
  using Theirs = typename GtsamVariable<V>::type;
  const auto* with_noise = dynamic_cast<const gtsam::NoiseModelFactor*>(&factor);
  if (with_noise == nullptr) return false;
  const auto* between = dynamic_cast<const gtsam::BetweenFactor<Theirs>*>(&factor);
  const auto* prior = dynamic_cast<const gtsam::PriorFactor<Theirs>*>(&factor);
  if (between == nullptr && prior == nullptr) return false;
  const auto* gaussian = dynamic_cast<const gtsam::noiseModel::Gaussian*>(with_noise->noiseModel().get());
  if (gaussian == nullptr)
    fail<BadOption>("a factor on ", holdfast_key(factor.keys()[0]),
                    " has a noise model that is not Gaussian; give it a Gaussian one, and our loss to ours");
  const Matrix<V::dim, V::dim> D = GtsamVariable<V>::tangent(V()).inverse();  // theirs by ours, both in the frame of the measured pose
  const Matrix<V::dim, V::dim> I = D.transpose() * gaussian->information() * D;
  if (between != nullptr) {
    const V measured = GtsamVariable<V>::ours(between->measured());
    graph.add(Between<V>::from_information(measured, I), {holdfast_key(factor.keys()[0]), holdfast_key(factor.keys()[1])});
  } else {
    const V mean = GtsamVariable<V>::ours(prior->prior());
    const Matrix<V::dim, V::dim> K = GtsamVariable<V>::tangent(mean).inverse();  // our translation moves in the world
    graph.add(Prior<V>::from_information(mean, K.transpose() * gaussian->information() * K), {holdfast_key(factor.keys()[0])});
  }
  return true;
}

}  // namespace

gtsam::NonlinearFactorGraph to_gtsam(const Graph& graph, const Values& values) {
  gtsam::NonlinearFactorGraph theirs;
  for (const auto& batch : graph.batches())
    for (int i = 0; i < batch->size(); ++i) {
      theirs.push_back(detail::gtsam_factor(term_of(*batch, i, static_cast<FileFactors*>(nullptr)), batch->keys(i), graph, values));
      if (!theirs.back())
        fail<BadOption>("GTSAM cannot hold ", batch->describe(i), ": all its variables are fixed, and a factor needs a key; remove it");
    }
  return theirs;
}

Graph from_gtsam(const gtsam::NonlinearFactorGraph& theirs) {
  Graph graph;
  for (const auto& factor : theirs) {
    if (!factor) continue;
    if (const auto* ours = dynamic_cast<const GtsamFactor*>(factor.get())) {
      std::vector<Key> keys;
      ours->each_variable([&](std::size_t, gtsam::Key key) { keys.push_back(holdfast_key(key)); },
                          [&](std::size_t, const GtsamFactor::Constant& constant) {
                            keys.push_back(constant.key);
                            graph.fix(constant.key);
                          });
      ours->term().add_to(graph, keys);
    } else if (!add_native<Pose2>(*factor, graph) && !add_native<Pose3>(*factor, graph)) {
      fail<BadOption>("GTSAM's factor ", detail::demangled(typeid(*factor)), " on ", holdfast_key(factor->keys()[0]),
                      " has no counterpart here; write it as a struct of yours");
    }
  }
  return graph;
}

}  // namespace holdfast
