#include <holdfast/adapters/ceres/ceres.hpp>
#include <holdfast/solvers/ceres/internal/cost.hpp>
#include <holdfast/solvers/ceres/internal/loss.hpp>
#include <holdfast/solvers/ceres/internal/manifold.hpp>

namespace holdfast {
namespace {

using RowMajor = Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>;
using ColMajor = Eigen::Map<const Eigen::MatrixXd>;

class TermCost final : public CeresCost {
 public:
  TermCost(const Term& term, const detail::Layouts& layouts, bool folded)
      : CeresCost(term.residual_dim(), term.total_dim(), folded), term_(term), layouts_(layouts) {
    for (const BlockLayout* layout : layouts_) {
      mutable_parameter_block_sizes()->insert(mutable_parameter_block_sizes()->end(), layout->blocks.begin(), layout->blocks.end());
      scratch_size_ += layout->ambient + layout->size * (2 + layout->dim);  // the variable; its memory gathered, twice; a Jacobian
    }
  }

 private:
  int scratch_size() const override { return scratch_size_; }
  void evaluate(const double* const* blocks, double* residuals, double* J, Scratch& scratch) const override {
    std::vector<const double*> variables;
    variables.reserve(layouts_.size());
    for (const BlockLayout* layout : layouts_) {
      double* variable = scratch.take(layout->ambient);
      layout->read(gathered(*layout, blocks, scratch), variable);
      variables.push_back(variable);
      blocks += layout->blocks.size();
    }
    term_.evaluate(variables.data(), residuals, J);
  }
  /// J with respect to the tangents, times d tangent / d memory, block by block.
  void distribute(const double* J, const double* const* blocks, double** jacobians, Scratch& scratch) const override {
    const int m = num_residuals();
    for (const BlockLayout* layout : layouts_) {
      double* M = scratch.take(layout->dim * layout->size);
      layout->minus_jacobian(gathered(*layout, blocks, scratch), M);
      int column = 0;
      for (const int size : layout->blocks) {
        if (*jacobians != nullptr)
          RowMajor(*jacobians, m, size).noalias() =
              ColMajor(J, m, layout->dim) * ColMajor(M, layout->dim, layout->size).middleCols(column, size);
        column += size;
        ++jacobians;
      }
      J += m * layout->dim;
      blocks += layout->blocks.size();
    }
  }
  const Loss& loss() const override { return term_.loss(); }
  double weight() const override { return term_.weight(); }

  static const double* gathered(const BlockLayout& layout, const double* const* blocks, Scratch& scratch) {
    if (layout.blocks.size() == 1) return blocks[0];
    double* x = scratch.take(layout.size);
    double* end = x;
    for (std::size_t b = 0; b < layout.blocks.size(); ++b) end = std::copy_n(blocks[b], layout.blocks[b], end);
    return x;
  }

  Term term_;
  detail::Layouts layouts_;
  int scratch_size_ = 0;
};

class LayoutGeometry {
 public:
  explicit LayoutGeometry(const BlockLayout& layout) : layout_(&layout) {}
  int ambient() const { return layout_->size; }
  int dim() const { return layout_->dim; }
  void plus(const double* x, const double* delta, double* out) const { layout_->plus(x, delta, out); }
  void minus(const double* y, const double* x, double* delta) const { layout_->minus(y, x, delta); }
  void plus_jacobian(const double* x, double* P) const { layout_->plus_jacobian(x, P); }
  void minus_jacobian(const double* x, double* M) const { layout_->minus_jacobian(x, M); }

 private:
  const BlockLayout* layout_;
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
  return new CeresManifold<LayoutGeometry>(LayoutGeometry(layout));
}

}  // namespace holdfast
