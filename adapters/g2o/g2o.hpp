// Our factors in a user's g2o::SparseOptimizer. Header-only; link holdfast::g2o. Vertices: g2o_variable.hpp.
//
//   auto* edge = g2o_edge(Range<Pose2, Point2>{12.3, 0.5}, {pose_vertex, beacon_vertex}, Cauchy{2});
//   optimizer.addEdge(edge);
//
// g2o's total is Σ ρ(χ²) without the ½: chi2 is twice our cost. A loss of the whole block becomes a robust kernel with our ρ; per-component
// and one-sided losses, which g2o has not, are folded into the error (solvers/detail/fold.hpp), exactly.
#pragma once

#include <g2o/core/base_fixed_sized_edge.h>
#include <g2o/core/base_variable_sized_edge.h>
#include <g2o/core/robust_kernel.h>

#include <holdfast/adapters/g2o/variable.hpp>
#include <holdfast/solvers/detail/fold.hpp>

namespace holdfast {
namespace detail {

/// w ρ(χ²) with our ρ.
class G2oLoss final : public g2o::RobustKernel {
 public:
  G2oLoss(const Loss& loss, double weight, int d) : loss_(loss), weight_(weight), d_(d) {}
  void robustify(double squared_error, g2o::Vector3& out) const override {
    const Rho rho = loss_.rho(squared_error, d_);
    out = weight_ * g2o::Vector3(rho.value, rho.first, rho.second);
  }

 private:
  Loss loss_;
  double weight_;
  int d_;
};

/// The part of an edge that does not depend on sizes known at compile time.
class G2oTerm {
 public:
  G2oTerm(HostTerm<G2oSlot> term) : term_(std::move(term)), folded_(must_fold(term_.term.loss(), term_.term.residual_dim())) {}
  int residual_dim() const { return term_.term.residual_dim(); }
  int arity() const { return term_.term.arity(); }

  void residual(const g2o::HyperGraph::VertexContainer& vertices, double* r) const {
    std::vector<double> x;
    evaluate(vertices, x, r, nullptr);
  }
  /// use(k, J_k): each variable's Jacobian with respect to its oplus.
  template <class Use>
  void linearize(const g2o::HyperGraph::VertexContainer& vertices, const Use& use) const {
    Eigen::VectorXd r(residual_dim());
    Eigen::MatrixXd J(residual_dim(), term_.term.total_dim());
    std::vector<double> x;
    evaluate(vertices, x, r.data(), J.data());
    term_.each_block(x, J, use);
  }
  template <class Edge>
  void prepare(Edge& edge) const {
    const Term& term = term_.term;
    edge.information().setIdentity();
    const bool plain = folded_ || (term.loss().kind == Loss::Kind::Squared && term.weight() == 1);
    if (!plain) edge.setRobustKernel(new G2oLoss(term.loss(), term.weight(), residual_dim()));
  }

 private:
  void evaluate(const g2o::HyperGraph::VertexContainer& vertices, std::vector<double>& x, double* r, double* J) const {
    const Term& term = term_.term;
    term_.evaluate([&](std::size_t k, double* memory) { term_.slots[k]->read(*vertices[k], memory); }, x, r, J);
    if (folded_) fold(term.loss(), term.weight(), residual_dim(), term.total_dim(), r, J);
  }

  HostTerm<G2oSlot> term_;
  bool folded_;
};
}  // namespace detail

/// A term of our cost as an edge whose sizes g2o knows at compile time, which is what it is fast on. M: residual_dim.
template <int M, class... Vertex>
class G2oEdge final : public g2o::BaseFixedSizedEdge<M, int, Vertex...> {
 public:
  explicit G2oEdge(detail::G2oTerm term) : term_(std::move(term)) { term_.prepare(*this); }
  void computeError() override { term_.residual(this->_vertices, this->_error.data()); }
  void linearizeOplus() override { fill(std::index_sequence_for<Vertex...>{}); }
  bool read(std::istream&) override { return false; }
  bool write(std::ostream&) const override { return false; }

 private:
  template <std::size_t... I>
  void fill(std::index_sequence<I...>) {
    term_.linearize(this->_vertices,
                    [&](std::size_t k, const auto& J) { ((k == I && (std::get<I>(this->_jacobianOplus) = J, true)) || ...); });
  }
  detail::G2oTerm term_;
};

/// The same for any sizes.
class G2oAnyEdge final : public g2o::BaseVariableSizedEdge<-1, int> {
 public:
  explicit G2oAnyEdge(detail::G2oTerm term) : term_(std::move(term)) {
    setDimension(term_.residual_dim());
    resize(term_.arity());
    term_.prepare(*this);
  }
  void computeError() override { term_.residual(_vertices, _error.data()); }
  void linearizeOplus() override {
    term_.linearize(_vertices, [&](std::size_t k, const auto& J) { _jacobianOplus[k] = J; });
  }
  using g2o::BaseVariableSizedEdge<-1, int>::linearizeOplus;
  bool read(std::istream&) override { return false; }
  bool write(std::ostream&) const override { return false; }

 private:
  detail::G2oTerm term_;
};

namespace detail {
template <class F, std::size_t... I>
g2o::OptimizableGraph::Edge* g2o_edge(const Term& term, const std::vector<g2o::OptimizableGraph::Vertex*>& vertices,
                                      std::index_sequence<I...>) {
  using Vars = typename F::Variables;
  const bool fits = vertices.size() == sizeof...(I) &&
                    ((dynamic_cast<typename G2oVariable<typename Vars::template type<I>>::Vertex*>(vertices[I]) != nullptr) && ...);
  if (!fits)
    fail<BadType>(factor_name<F>(), " ties", ((std::string(" ") + Vars::template type<I>::name()) + ...),
                  ", and the vertices given are others (null, too few, or of another class); see adapters/g2o/variable.hpp");
  auto* edge = new G2oEdge<F::residual_dim, typename G2oVariable<typename Vars::template type<I>>::Vertex...>(
      G2oTerm(host_term<G2oSlot, G2oSlotOf, F>(term, std::index_sequence<I...>{})));
  (edge->setVertex(I, vertices[I]), ...);
  return edge;
}
}  // namespace detail

/// With the factor's own default loss and weight, or with those given. The optimizer it is added to owns the edge.
template <class F>
g2o::OptimizableGraph::Edge* g2o_edge(const F& factor, const std::vector<g2o::OptimizableGraph::Vertex*>& vertices) {
  return detail::g2o_edge<F>(Term(factor), vertices, std::make_index_sequence<F::Variables::size>{});
}
template <class F>
g2o::OptimizableGraph::Edge* g2o_edge(const F& factor, const std::vector<g2o::OptimizableGraph::Vertex*>& vertices, const Loss& loss,
                                      double weight = 1) {
  return detail::g2o_edge<F>(Term(factor, loss, weight), vertices, std::make_index_sequence<F::Variables::size>{});
}

}  // namespace holdfast
