#include <Eigen/Cholesky>
#include <algorithm>
#include <holdfast/graph/resolved.hpp>
#include <holdfast/solvers/backend.hpp>
#include <holdfast/solvers/window/trust.hpp>

namespace holdfast {

void TrustOptions::validate() const {
  if (recent < 2) fail<BadOption>("TrustOptions.recent = ", recent, " must be >= 2 measurements");
  if (!(gate > 0)) fail<BadOption>("TrustOptions.gate = ", gate, " must be > 0 [sigmas]");
  if (!(lost > 0 && lost < 1)) fail<BadOption>("TrustOptions.lost = ", lost, " must be between 0 and 1");
  if (!(regained >= lost && regained <= 1)) fail<BadOption>("TrustOptions.regained = ", regained, " must be at least lost, and at most 1");
}

Trust::Trust(TrustOptions options) : options_(options) { options_.validate(); }

Trust::Change Trust::judge(std::uint64_t party, std::uint64_t ticket, bool fits) {
  Party& one = parties_[party];
  one.latest.push_back({ticket, fits});
  if (one.latest.size() > static_cast<std::size_t>(options_.recent)) one.latest.pop_front();
  const auto count = static_cast<double>(std::count_if(one.latest.begin(), one.latest.end(), [](const Judged& j) { return j.fits; }));
  const auto misfits = static_cast<double>(one.latest.size()) - count;
  // Before there are `recent` of them the missing ones count as fitting, of a party that is believed, and as not, of one that is not.
  if (one.is_believed && misfits > (1 - options_.lost) * options_.recent) {
    one.is_believed = false;
    return Change::lost;
  }
  if (!one.is_believed && count >= options_.regained * options_.recent) {
    one.is_believed = true;
    return Change::regained;
  }
  return Change::none;
}

bool Trust::is_believed(std::uint64_t party) const {
  const auto it = parties_.find(party);
  return it == parties_.end() || it->second.is_believed;
}

std::vector<Trust::Judged> Trust::latest(std::uint64_t party) const {
  const auto it = parties_.find(party);
  if (it == parties_.end()) return {};
  return {it->second.latest.begin(), it->second.latest.end()};
}

std::vector<Trust::Judged> Trust::doubtful(std::uint64_t party) const {
  std::vector<Judged> all = latest(party);
  all.erase(all.begin(), std::find_if(all.begin(), all.end(), [](const Judged& one) { return !one.fits; }));
  return all;
}

std::vector<std::uint64_t> Trust::disbelieved() const {
  std::vector<std::uint64_t> result;
  for (const auto& [party, state] : parties_)
    if (!state.is_believed) result.push_back(party);
  return result;
}

double innovation(const Graph& one, const Values& values, const Marginals& marginals) {
  const FactorBatch* batch = nullptr;
  std::size_t number = 0;
  for (std::size_t b = 0; b < one.batches().size(); ++b)
    if (one.batches()[b]->size() == 1) {
      batch = one.batches()[b].get();
      number = b;
    }
  if (batch == nullptr || one.size() != 1 || batch->arity() > 2)
    fail<BadProblem>("innovation() is asked of a graph of ", one.size(), " factors; give it one factor on one or two variables");
  const Resolved resolved(one, values);
  const int m = batch->residual_dim(), n = batch->total_dim();
  Eigen::VectorXd r(m);
  Eigen::MatrixXd J(m, n);
  batch->evaluate(values, resolved.batches()[number].index.data(), 0, 1, r.data(), J.data());
  const Key* const keys = batch->keys(0);
  std::vector<double> P;
  try {
    P = batch->arity() == 1 ? marginals.covariance(keys[0]) : marginals.joint(keys[0], keys[1]);
  } catch (const UnobservableError&) {
    return 0;
  }
  const Eigen::MatrixXd S = Eigen::MatrixXd::Identity(m, m) + J * Eigen::Map<const Eigen::MatrixXd>(P.data(), n, n) * J.transpose();
  return r.dot(S.ldlt().solve(r));
}

}  // namespace holdfast
