#include <gtsam/linear/JacobianFactor.h>
#include <gtsam/linear/VectorValues.h>

#include <cmath>
#include <holdfast/adapters/gtsam/gtsam.hpp>
#include <iostream>

namespace holdfast {

GtsamFactor::GtsamFactor(detail::HostTerm<detail::GtsamSlot> term, const gtsam::KeyVector& keys, std::vector<Constant> constants)
    : gtsam::NonlinearFactor(keys), term_(std::move(term)), constants_(std::move(constants)) {}

double GtsamFactor::error(const gtsam::Values& values) const {
  std::vector<double> x;
  Eigen::VectorXd r(term().residual_dim());
  evaluate(values, x, r.data(), nullptr);
  return term().cost(r.data(), nullptr);
}

gtsam::GaussianFactor::shared_ptr GtsamFactor::linearize(const gtsam::Values& values) const {
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

bool GtsamFactor::equals(const gtsam::NonlinearFactor& other, double tolerance) const {
  const auto* ours = dynamic_cast<const GtsamFactor*>(&other);
  if (ours == nullptr || !gtsam::NonlinearFactor::equals(other, tolerance) || !term().equals(ours->term(), tolerance)) return false;
  const auto is_near = [tolerance](double a, double b) { return std::abs(a - b) <= tolerance; };
  return std::equal(
      constants_.begin(), constants_.end(), ours->constants_.begin(), ours->constants_.end(), [&](const Constant& a, const Constant& b) {
        return a.variable == b.variable && a.key == b.key && std::equal(a.x.begin(), a.x.end(), b.x.begin(), b.x.end(), is_near);
      });
}

gtsam::NonlinearFactor::shared_ptr GtsamFactor::clone() const { return gtsam::NonlinearFactor::shared_ptr(new GtsamFactor(*this)); }

void GtsamFactor::print(const std::string& text, const gtsam::KeyFormatter& formatter) const {
  std::cout << text << term().batch().name() << " under " << term().loss().str();
  for (const gtsam::Key key : keys()) std::cout << ' ' << formatter(key);
  std::cout << '\n';
}

void GtsamFactor::evaluate(const gtsam::Values& values, std::vector<double>& x, double* r, double* J) const {
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

namespace detail {

gtsam::NonlinearFactor::shared_ptr gtsam_factor(const Term& term, const Key* keys, const Graph& graph, const Values& values) {
  HostTerm<GtsamSlot> in_host = gtsam_term(term);
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

gtsam::NonlinearFactor::shared_ptr gtsam_factor(Term term, std::vector<const GtsamSlot*> slots, const gtsam::KeyVector& keys) {
  return gtsam::NonlinearFactor::shared_ptr(new GtsamFactor({std::move(term), std::move(slots)}, keys));
}

void read_keys(std::string (*name)(), const gtsam::KeyVector& keys, std::size_t count, Key* ours) {
  if (keys.size() != count) fail<BadKey>(name(), " ties ", count, " variables, not ", keys.size(), "; give one key for each");
  std::transform(keys.begin(), keys.end(), ours, holdfast_key);
}

}  // namespace detail
}  // namespace holdfast
