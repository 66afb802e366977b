#include <holdfast/adapters/ceres/ceres.hpp>
#include <holdfast/solvers/ceres/internal/loss.hpp>
#include <holdfast/solvers/detail/fold.hpp>

namespace holdfast {
namespace {

using RowMajor = Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>;
using ColMajor = Eigen::Map<const Eigen::MatrixXd>;

/// Doubles on the stack where they fit.
class Scratch {
 public:
  explicit Scratch(int size) : large_(size > kStack ? static_cast<std::size_t>(size) : 0), next_(large_.empty() ? local_ : large_.data()) {}
  double* take(int n) { return std::exchange(next_, next_ + n); }

 private:
  static constexpr int kStack = 512;
  double local_[kStack];
  std::vector<double> large_;
  double* next_;
};

class TermCost final : public ceres::CostFunction {
 public:
  TermCost(const Term& term, const detail::Layouts& layouts, bool folded) : term_(term), layouts_(layouts), folded_(folded) {
    set_num_residuals(term.residual_dim());
    scratch_ = term.residual_dim() * term.total_dim();
    for (const BlockLayout* layout : layouts_) {
      mutable_parameter_block_sizes()->insert(mutable_parameter_block_sizes()->end(), layout->blocks.begin(), layout->blocks.end());
      scratch_ += layout->ambient + layout->size * (1 + layout->dim);
    }
  }

  bool Evaluate(const double* const* blocks, double* residuals, double** jacobians) const override {
    const int m = term_.residual_dim();
    Scratch scratch(scratch_);
    std::vector<const double*> memory, variables;
    memory.reserve(layouts_.size());
    variables.reserve(layouts_.size());
    for (const BlockLayout* layout : layouts_) {
      memory.push_back(gathered(*layout, blocks, scratch));
      double* variable = scratch.take(layout->ambient);
      layout->read(memory.back(), variable);
      variables.push_back(variable);
      blocks += layout->blocks.size();
    }
    double* J = jacobians == nullptr ? nullptr : scratch.take(m * term_.total_dim());
    term_.evaluate(variables.data(), residuals, J);
    for (int c = 0; c < m; ++c)
      if (!std::isfinite(residuals[c])) return false;
    if (folded_) fold(term_.loss(), term_.weight(), m, term_.total_dim(), residuals, J);
    if (J != nullptr) distribute(J, memory, jacobians, scratch);
    return true;
  }

 private:
  static const double* gathered(const BlockLayout& layout, const double* const* blocks, Scratch& scratch) {
    if (layout.blocks.size() == 1) return blocks[0];
    double* x = scratch.take(layout.size);
    double* end = x;
    for (std::size_t b = 0; b < layout.blocks.size(); ++b) end = std::copy_n(blocks[b], layout.blocks[b], end);
    return x;
  }

  /// J with respect to the tangents, times d tangent / d memory, block by block.
  void distribute(const double* J, const std::vector<const double*>& memory, double** jacobians, Scratch& scratch) const {
    const int m = term_.residual_dim();
    for (std::size_t k = 0; k < layouts_.size(); ++k) {
      const BlockLayout& layout = *layouts_[k];
      double* M = scratch.take(layout.dim * layout.size);
      layout.minus_jacobian(memory[k], M);
      int column = 0;
      for (const int size : layout.blocks) {
        if (*jacobians != nullptr)
          RowMajor(*jacobians, m, size).noalias() =
              ColMajor(J, m, layout.dim) * ColMajor(M, layout.dim, layout.size).middleCols(column, size);
        column += size;
        ++jacobians;
      }
      J += m * layout.dim;
    }
  }

  Term term_;
  detail::Layouts layouts_;
  bool folded_;
  int scratch_;
};

class LayoutManifold final : public ceres::Manifold {
 public:
  explicit LayoutManifold(const BlockLayout& layout) : layout_(layout) {}
  int AmbientSize() const override { return layout_.size; }
  int TangentSize() const override { return layout_.dim; }
  bool Plus(const double* x, const double* delta, double* out) const override {
    layout_.plus(x, delta, out);
    return true;
  }
  bool PlusJacobian(const double* x, double* jacobian) const override {
    Eigen::MatrixXd P(layout_.size, layout_.dim);
    layout_.plus_jacobian(x, P.data());
    RowMajor(jacobian, P.rows(), P.cols()) = P;
    return true;
  }
  bool Minus(const double* y, const double* x, double* delta) const override {
    layout_.minus(y, x, delta);
    return true;
  }
  bool MinusJacobian(const double* x, double* jacobian) const override {
    Eigen::MatrixXd M(layout_.dim, layout_.size);
    layout_.minus_jacobian(x, M.data());
    RowMajor(jacobian, M.rows(), M.cols()) = M;
    return true;
  }

 private:
  const BlockLayout& layout_;
};

bool needs_no_loss(const Loss& loss, double weight) { return loss.kind == Loss::Kind::Squared && weight == 1; }

}  // namespace

ceres::LossFunction* ceres_loss(const Loss& loss, int residual_dim, double weight) {
  const bool needs_dim = loss.per_component || loss.kind == Loss::Kind::StudentT || loss.kind == Loss::Kind::Own;
  if (residual_dim == 0 && needs_dim && !loss.one_sided)
    fail<BadOption>("ceres_loss: '", loss.str(),
                    "' depends on how many components the residual has; give their number as the second argument");
  if (must_fold(loss, residual_dim))
    fail<BadOption>("Ceres knows losses of a whole residual block alone, and '", loss.str(),
                    "' is none; give it to ceres_cost(factor, loss), which has it in the residual, or use ceres_add");
  const int d = std::max(1, residual_dim);
  loss.validate(d);
  return needs_no_loss(loss, weight) ? nullptr : new CeresLoss(loss, weight, d);
}

ceres::CostFunction* detail::ceres_cost(const Term& term, const Layouts& layouts) { return new TermCost(term, layouts, false); }

ceres::CostFunction* detail::ceres_folded_cost(const Term& term, const Layouts& layouts) {
  if (!must_fold(term.loss(), term.residual_dim()) && !needs_no_loss(term.loss(), term.weight()))
    fail<BadOption>(
        term.batch().name(), ": '", term.loss().str(),
        "' is a loss of the whole block, which Ceres has; leave it out of ceres_cost and give ceres_loss beside it, or use ceres_add");
  return new TermCost(term, layouts, must_fold(term.loss(), term.residual_dim()));
}

ceres::ResidualBlockId detail::ceres_add(ceres::Problem& problem, const Term& term, const Layouts& layouts,
                                         const std::vector<double*>& blocks) {
  std::size_t wanted = 0;
  for (const BlockLayout* layout : layouts) wanted += layout->blocks.size();
  if (blocks.size() != wanted)
    fail<BadOption>(term.batch().name(), " has ", wanted, " blocks in this memory layout, not ", blocks.size(),
                    "; give one pointer for each");
  const bool folded = must_fold(term.loss(), term.residual_dim());
  return problem.AddResidualBlock(new TermCost(term, layouts, folded),
                                  folded ? nullptr : ceres_loss(term.loss(), term.residual_dim(), term.weight()), blocks);
}

ceres::Manifold* detail::ceres_manifold(const BlockLayout& layout) {
  if (layout.blocks.size() != 1)
    fail<BadOption>("a variable in ", layout.blocks.size(),
                    " blocks has no manifold as a whole; put one on each block that is no vector space, "
                    "such as ceres::EigenQuaternionManifold on the quaternion");
  return new LayoutManifold(layout);
}

}  // namespace holdfast
