// Our factors in a user's gtsam::NonlinearFactorGraph. Header-only; link holdfast::gtsam. GTSAM 4.2 and later. Variables:
// gtsam_variable.hpp; whole graphs, both ways: gtsam_graph.hpp.
//
//   graph.push_back(gtsam_factor(Range<Pose2, Point2>{12.3, 0.5}, {X(3), L(0)}, Cauchy{2}));
//
// error() is w ½ρ, our cost, whatever the loss, per-component and one-sided ones included; linearize() gives rows √(w ρ') (J, −r), so that
// its gradient at 0 is that of the error. (gtsam::noiseModel::Robust takes the norm for the cost even when it re-weights by rows.)
#pragma once

#include <gtsam/linear/JacobianFactor.h>
#include <gtsam/linear/VectorValues.h>
#include <gtsam/nonlinear/NonlinearFactor.h>
#include <gtsam/nonlinear/NonlinearFactorGraph.h>

#include <holdfast/adapters/gtsam/variable.hpp>
#include <iostream>

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
  GtsamFactor(detail::HostTerm<detail::GtsamSlot> term, const gtsam::KeyVector& keys, std::vector<Constant> constants = {})
      : gtsam::NonlinearFactor(keys), term_(std::move(term)), constants_(std::move(constants)) {}

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
  double error(const gtsam::Values& values) const override {
    std::vector<double> x;
    Eigen::VectorXd r(term().residual_dim());
    evaluate(values, x, r.data(), nullptr);
    return term().cost(r.data(), nullptr);
  }
  size_t dim() const override { return static_cast<size_t>(term().residual_dim()); }

  gtsam::GaussianFactor::shared_ptr linearize(const gtsam::Values& values) const override {
    const int m = term().residual_dim();
    std::vector<double> x;
    Eigen::VectorXd r(m), weights(m);
    Eigen::MatrixXd J(m, term().total_dim());
    evaluate(values, x, r.data(), J.data());
    term().cost(r.data(), weights.data());
    weights = weights.cwiseSqrt();
    std::vector<gtsam::Matrix> all(term_.slots.size());
    term_.each_block(x, J, [&](std::size_t k, const auto& block) { all[k] = weights.asDiagonal() * block; });
    std::vector<std::pair<gtsam::Key, gtsam::Matrix>> blocks;
    each_variable([&](std::size_t k, gtsam::Key key) { blocks.emplace_back(key, std::move(all[k])); }, [](std::size_t, const Constant&) {});
    return gtsam::GaussianFactor::shared_ptr(new gtsam::JacobianFactor(blocks, gtsam::Vector(-weights.cwiseProduct(r))));
  }

  gtsam::NonlinearFactor::shared_ptr clone() const override { return gtsam::NonlinearFactor::shared_ptr(new GtsamFactor(*this)); }
  void print(const std::string& text = "", const gtsam::KeyFormatter& formatter = gtsam::DefaultKeyFormatter) const override {
    std::cout << text << term().batch().name() << " under " << term().loss().str();
    for (const gtsam::Key key : keys()) std::cout << ' ' << formatter(key);
    std::cout << '\n';
  }

 private:
  void evaluate(const gtsam::Values& values, std::vector<double>& x, double* r, double* J) const {
    auto key = begin();
    auto constant = constants_.begin();
    const auto read = [&](std::size_t k, double* memory) {
      if (constant != constants_.end() && constant->variable == k)
        std::copy(constant->x.begin(), constant->x.end(), memory), ++constant;
      else
        term_.slots[k]->read(values, *key++, memory);
    };
    term_.evaluate(read, x, r, J);
  }

  detail::HostTerm<detail::GtsamSlot> term_;
  std::vector<Constant> constants_;
};

namespace detail {
/// The term of a graph of ours on these keys; fixed variables are constants, at `values`. Null where it has no other.
inline gtsam::NonlinearFactor::shared_ptr gtsam_factor(const Term& term, const Key* keys, const Graph& graph, const Values& values) {
  HostTerm<GtsamSlot> in_host = host_term<GtsamSlot, GtsamSlotOf>(term);
  gtsam::KeyVector free;
  std::vector<GtsamFactor::Constant> constants;
  for (std::size_t k = 0; k < in_host.slots.size(); ++k) {
    if (!graph.is_fixed(keys[k])) {
      free.push_back(gtsam_key(keys[k]));
      continue;
    }
    const Values::Slot& slot = values.slot(keys[k]);
    const double* x = values.pool(slot.pool).data(slot.index);
    constants.push_back({k, keys[k], {x, x + in_host.slots[k]->ambient}});
  }
  if (free.empty()) return {};
  return gtsam::NonlinearFactor::shared_ptr(new GtsamFactor(std::move(in_host), free, std::move(constants)));
}

template <class F>
gtsam::NonlinearFactor::shared_ptr gtsam_factor(const Term& term, const gtsam::KeyVector& keys) {
  constexpr int arity = F::Variables::size;
  if (keys.size() != arity) fail<BadKey>(factor_name<F>(), " ties ", arity, " variables, not ", keys.size(), "; give one key for each");
  return gtsam::NonlinearFactor::shared_ptr(
      new GtsamFactor(host_term<GtsamSlot, GtsamSlotOf, F>(term, std::make_index_sequence<arity>{}), keys));
}
}  // namespace detail

/// With the factor's own default loss and weight, or with those given.
template <class F>
gtsam::NonlinearFactor::shared_ptr gtsam_factor(const F& factor, const gtsam::KeyVector& keys) {
  return detail::gtsam_factor<F>(Term(factor), keys);
}
template <class F>
gtsam::NonlinearFactor::shared_ptr gtsam_factor(const F& factor, const gtsam::KeyVector& keys, const Loss& loss, double weight = 1) {
  return detail::gtsam_factor<F>(Term(factor, loss, weight), keys);
}

}  // namespace holdfast
