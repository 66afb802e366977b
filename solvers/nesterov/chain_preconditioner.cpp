#include <algorithm>
#include <cmath>
#include <holdfast/solvers/nesterov/internal/chain_preconditioner.hpp>
#include <numeric>

namespace holdfast {
namespace {

// Consecutive free variables of one agent, where some factor ties them.
BlockGraph chains_of(const BlockGraph& all, const Resolved& resolved, const std::vector<int>& variable) {
  std::vector<int> by_key(all.size());
  std::iota(by_key.begin(), by_key.end(), 0);
  std::sort(by_key.begin(), by_key.end(),
            [&](int a, int b) { return resolved.variables()[variable[a]].key < resolved.variables()[variable[b]].key; });
  std::vector<int> rank(all.size());
  for (int i = 0; i < all.size(); ++i) rank[by_key[i]] = i;
  const auto agent = [&](int node) { return resolved.variables()[variable[node]].key.agent(); };
  BlockGraph chains;
  chains.dims = all.dims;
  for (int node = 0; node < all.size(); ++node) {
    for (int e = all.begin[node]; e < all.begin[node + 1]; ++e) {
      const int other = all.neighbours[e];
      if (std::abs(rank[node] - rank[other]) == 1 && agent(node) == agent(other)) chains.neighbours.push_back(other);
    }
    chains.begin.push_back(static_cast<int>(chains.neighbours.size()));
  }
  return chains;
}

}  // namespace

struct ChainPreconditioner::Ordered {
  std::vector<int> variable;  // of each node
  BlockGraph chains;
  Symbolic symbolic;
  std::vector<int> order;  // variables
};

ChainPreconditioner::Ordered ChainPreconditioner::order_of(const Graph& graph, const Resolved& resolved, Kept kept) {
  Ordered ordered;
  const BlockGraph all = block_graph(graph, resolved, ordered.variable);
  ordered.chains = kept == Kept::all ? all : chains_of(all, resolved, ordered.variable);
  ordered.symbolic = kept == Kept::all ? analyze(ordered.chains) : analyze(ordered.chains, minimum_degree_order(ordered.chains));
  for (int node : ordered.symbolic.order) ordered.order.push_back(ordered.variable[node]);
  return ordered;
}

ChainPreconditioner::ChainPreconditioner(const Graph& graph, const Resolved& resolved, Kept kept)
    : ChainPreconditioner(graph, resolved, order_of(graph, resolved, kept)) {}

ChainPreconditioner::ChainPreconditioner(const Graph& graph, const Resolved& resolved, Ordered ordered)
    : normal_(graph, resolved, ordered.order) {
  const BlockPattern& H = normal_.pattern();
  chains_.dims = H.dims;
  chains_.offsets = H.offsets;
  chains_.column_begin.push_back(0);
  chains_.block_begin.push_back(0);
  for (int column = 0; column < H.size(); ++column) {
    const int node = ordered.symbolic.order[column];
    for (int b = H.column_begin[column]; b < H.column_begin[column + 1]; ++b) {
      const int other = ordered.symbolic.order[H.rows[b]];
      const auto first = ordered.chains.neighbours.begin() + ordered.chains.begin[node],
                 last = ordered.chains.neighbours.begin() + ordered.chains.begin[node + 1];
      if (other != node && !std::binary_search(first, last, other)) continue;
      chains_.rows.push_back(H.rows[b]);
      for (int k = H.block_begin[b]; k < H.block_begin[b + 1]; ++k) kept_.push_back(k);
      chains_.block_begin.push_back(static_cast<int>(kept_.size()));
    }
    chains_.column_begin.push_back(static_cast<int>(chains_.rows.size()));
  }
  values_.resize(kept_.size());
  traces_.resize(H.size());
  stiffest_.resize(H.size());
  for (std::vector<double>* v : {&added_, &ordered_, &solved_}) v->resize(H.scalar_size());
  cholesky_ = std::make_unique<BlockCholesky>(std::move(ordered.symbolic), chains_);
}

void ChainPreconditioner::update(const Graph& graph, const Resolved& resolved, const Values& values, ThreadPool* pool) {
  normal_.linearize(graph, resolved, values, Curvature::bound, pool);
  for (std::size_t k = 0; k < kept_.size(); ++k) values_[k] = normal_.H()[kept_[k]];
  for (int i = 0; i < chains_.size(); ++i) {
    const double* block = &values_[chains_.block_begin[chains_.column_begin[i]]];
    traces_[i] = 0;
    for (int c = 0; c < chains_.dims[i]; ++c) traces_[i] += block[c * (chains_.dims[i] + 1)];
    stiffest_[i] = std::max(stiffest_[i], traces_[i]);
  }
  factor();
}

bool ChainPreconditioner::round_off() {
  constexpr double kStep = 10, kRoundest = 1;
  if (roundness_ >= kRoundest) return false;
  roundness_ = std::min(kRoundest, std::max(1e-4, roundness_ * kStep));
  factor();
  return true;
}

void ChainPreconditioner::factor() {
  double largest = 0;  // mean diagonal entry
  for (int i = 0; i < chains_.size(); ++i) largest = std::max(largest, stiffest_[i] / chains_.dims[i]);
  if (largest == 0) largest = 1;
  for (int i = 0; i < chains_.size(); ++i) {
    // A block of a variable that only inactive one-sided factors touch is zero: it borrows the largest curvature there is.
    const double added = stiffest_[i] > 0 ? (stiffest_[i] - traces_[i]) / chains_.dims[i] + roundness_ * stiffest_[i] : largest;
    std::fill_n(&added_[chains_.offsets[i]], chains_.dims[i], added);
  }
  while (!cholesky_->factor(values_, added_)) {
    for (double& added : added_) added = 10 * added + 1e-12 * largest;
    if (!std::isfinite(*std::max_element(added_.begin(), added_.end()))) {  // the curvature is no number: the identity, and the solve ends
      std::fill(values_.begin(), values_.end(), 0.0);                       // by the gradient, which is none either
      std::fill(added_.begin(), added_.end(), 1.0);
    }
  }
}

double ChainPreconditioner::apply(const Resolved& resolved, const std::vector<double>& g, std::vector<double>& out) {
  normal_.from_tangent(resolved, g.data(), ordered_.data());
  cholesky_->solve(ordered_, solved_);
  out.resize(g.size());
  normal_.to_tangent(resolved, solved_.data(), out.data());
  return std::inner_product(g.begin(), g.end(), out.begin(), 0.0);
}

}  // namespace holdfast
