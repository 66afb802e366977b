// Our factors in a user's gtsam::NonlinearFactorGraph. Link holdfast::gtsam. GTSAM 4.2 and later. Variables: variable.hpp; whole graphs,
// both ways: graph.hpp.
//
//   graph.push_back(gtsam_factor(Range<Pose2, Point2>{12.3, 0.5}, {X(3), L(0)}, Cauchy{2}));
//
// error() is w ½ρ, our cost, whatever the loss, per-component and one-sided ones included; linearize() gives rows √(w ρ') (J, −r), so that
// its gradient at 0 is that of the error. (gtsam::noiseModel::Robust takes the norm for the cost even when it re-weights by rows.)
#pragma once

#include <gtsam/nonlinear/NonlinearFactor.h>
#include <gtsam/nonlinear/NonlinearFactorGraph.h>

#include <holdfast/adapters/gtsam/variable.hpp>

namespace holdfast {

/// A term of our cost as a factor of GTSAM.
class GtsamFactor : public gtsam::NonlinearFactor {
 public:
  /// A variable of the term that is no key of GTSAM's: fixed.
  struct Constant {
    std::size_t variable;
    Key key;  ///< whose it is, for the way back
    std::vector<double> x;
  };

  /// One key for each variable that is no constant, in the order of the term; constants in that order, too.
  GtsamFactor(detail::HostTerm<detail::GtsamSlot> term, const gtsam::KeyVector& keys, std::vector<Constant> constants = {});

  const Term& term() const { return term_.term; }
  const std::vector<Constant>& constants() const { return constants_; }
  /// use(k, key) for the free variables, use(k, constant) for the others.
  template <class Free, class Fixed>
  void each_variable(const Free& free, const Fixed& fixed) const {
    auto key = begin();
    auto constant = constants_.begin();
    for (std::size_t k = 0; k < term_.slots.size(); ++k)
      if (constant != constants_.end() && constant->variable == k)
        fixed(k, *constant++);
      else
        free(k, *key++);
  }

  using gtsam::NonlinearFactor::error;
  double error(const gtsam::Values& values) const override;
  size_t dim() const override { return static_cast<size_t>(term().residual_dim()); }
  gtsam::GaussianFactor::shared_ptr linearize(const gtsam::Values& values) const override;

  /// The same keys, measurement, noise, loss, weight and constants: doubles within the tolerance. A factor of a type without fields()
  /// (graph/fields.hpp) is equal to itself and its clones alone.
  bool equals(const gtsam::NonlinearFactor& other, double tolerance = 1e-9) const override;
  gtsam::NonlinearFactor::shared_ptr clone() const override;
  void print(const std::string& text = "", const gtsam::KeyFormatter& formatter = gtsam::DefaultKeyFormatter) const override;

 private:
  void evaluate(const gtsam::Values& values, std::vector<double>& x, double* r, double* J) const;

  detail::HostTerm<detail::GtsamSlot> term_;
  std::vector<Constant> constants_;
};

namespace detail {
/// The term of a graph of ours on these keys; fixed variables are constants, at `values`. Null where it has no other.
gtsam::NonlinearFactor::shared_ptr gtsam_factor(const Term& term, const Key* keys, const Graph& graph, const Values& values);
gtsam::NonlinearFactor::shared_ptr gtsam_factor(Term term, std::vector<const GtsamSlot*> slots, const gtsam::KeyVector& keys);

/// `count` keys of ours. Throws BadKey where there are others than the factor has variables.
void read_keys(std::string (*name)(), const gtsam::KeyVector& keys, std::size_t count, Key* ours);

template <class F, std::size_t... I, class... LossAndWeight>
gtsam::NonlinearFactor::shared_ptr gtsam_factor(const F& factor, const gtsam::KeyVector& keys, std::index_sequence<I...>,
                                                const LossAndWeight&... more) {
  std::array<Key, sizeof...(I)> ours;
  read_keys(factor_name<F>, keys, ours.size(), ours.data());
  return gtsam_factor(Term(factor, ours, more...), {the_slot<GtsamSlotOf<typename F::Variables::template type<I>>>()...}, keys);
}
}  // namespace detail

/// With the factor's own default loss and weight, or with those given. Throws BadKey, BadNumber and BadOption where Graph::add would, and
/// names the factor by these keys.
template <class F>
gtsam::NonlinearFactor::shared_ptr gtsam_factor(const F& factor, const gtsam::KeyVector& keys) {
  return detail::gtsam_factor(factor, keys, std::make_index_sequence<F::Variables::size>{});
}
template <class F>
gtsam::NonlinearFactor::shared_ptr gtsam_factor(const F& factor, const gtsam::KeyVector& keys, const Loss& loss, double weight = 1) {
  return detail::gtsam_factor(factor, keys, std::make_index_sequence<F::Variables::size>{}, loss, weight);
}

}  // namespace holdfast
