// The normal equations in PETSc's matrices: each process its own rows. Internal.
#pragma once

#include <petscksp.h>

#include <holdfast/solvers/distributed/internal/distributed_problem.hpp>
#include <holdfast/solvers/distributed/petsc.hpp>
#include <holdfast/solvers/irls/internal/quadratic_model.hpp>
#include <holdfast/solvers/linear/internal/normal_equations.hpp>

namespace holdfast::detail {

class PetscSystem final : public QuadraticModel {
 public:
  PetscSystem(DistributedProblem& problem, const OfPetsc& options, int threads, PetscReport& report);
  ~PetscSystem() override;
  PetscSystem(const PetscSystem&) = delete;
  PetscSystem& operator=(const PetscSystem&) = delete;

  std::size_t size() const override { return diagonal_.size(); }
  double linearize(const Graph& graph, const Values& values, Curvature curvature) override;
  const std::vector<double>& gradient() const override { return gradient_; }
  const std::vector<double>& diagonal() const override { return diagonal_; }
  void multiply(const std::vector<double>& x, std::vector<double>& y) const override;
  double solve_damped(double lambda, std::vector<double>& step) override { return solve_damped(lambda, diagonal_, step); }
  double solve_damped(double lambda, const std::vector<double>& scales, std::vector<double>& step) override;
  double cost(const Graph&, const Values& values) override { return problem_.cost(values, &pool_); }
  void retract(const Values& from, double t, const std::vector<double>& step, Values& to) override;
  double dot(const std::vector<double>& a, const std::vector<double>& b) const override;
  double dot(const std::vector<double>& metric, const std::vector<double>& a, const std::vector<double>& b) const override;
  std::string first_non_finite(const Graph&, const Values& values) const override { return problem_.first_non_finite(values); }
  double gradient_norm() const override;

 private:
  /// fn(row, column, k): every entry of our rows, in a fixed order; row and column are scalars of the local order, k: where it is in H.
  template <class Fn>
  void for_each_entry(const Fn& fn) const;
  std::vector<PetscInt> number_globally();
  void make_matrix(const std::vector<PetscInt>& numbers);
  void make_database();
  void make_solver();
  void find_modes(const Values& values);
  void set_near_nullspace();
  void set_balance();
  void set_damping(double lambda, const std::vector<double>& scales);

  DistributedProblem& problem_;
  ThreadPool pool_;
  int own_blocks_ = 0;      // before order_, which sets it
  std::vector<int> order_;  // variables: our own, then ghosts
  NormalEquations normal_;
  const OfPetsc& options_;
  PetscReport& report_;
  std::vector<double> gradient_, diagonal_, damping_, tangent_;
  /// The matrix is S (H + λ D) S, S diagonal, the same for all scalars of a variable: whatever a variable weighs, and a node of a network
  /// may be all but free, its largest diagonal entry is 1. By scalar of the local order, ghosts too.
  std::vector<double> balance_;
  std::vector<std::vector<double>> modes_;  // rigid motions, in own scalars
  std::vector<PetscScalar> entries_;
  Mat A_ = nullptr;
  Vec x_ = nullptr, b_ = nullptr;
  KSP ksp_ = nullptr;
  PetscOptions database_ = nullptr;
  bool wants_nullspace_ = false, is_direct_ = false;
};

}  // namespace holdfast::detail
