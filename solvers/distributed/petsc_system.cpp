#include <algorithm>
#include <cmath>
#include <holdfast/solvers/distributed/internal/petsc_system.hpp>
#include <holdfast/solvers/internal/minimizer.hpp>
#include <holdfast/solvers/linear/internal/damping.hpp>

namespace holdfast::detail {
namespace {

/// Below this an iterative solver would look for ever for what hardly matters: a node that only inactive balls hold moves freely.
constexpr double kLeastIterativeDamping = 1e-8;

/// PETSc's error codes as exceptions.
void check(PetscErrorCode code, const char* what) {
  if (code == 0) return;
  const char* text = nullptr;
  PetscErrorMessage(code, &text, nullptr);
  fail<Error>("PETSc failed in ", what, " (error ", static_cast<int>(code), ": ", text == nullptr ? "unknown" : text, ")");
}

/// Free variables: this process's own first, then ghosts.
std::vector<int> own_first(const DistributedProblem& problem, int& own) {
  std::vector<int> order, ghosts;
  const auto& variables = problem.resolved().variables();
  for (std::size_t v = 0; v < variables.size(); ++v)
    if (variables[v].offset >= 0) (problem.owns(variables[v]) ? order : ghosts).push_back(static_cast<int>(v));
  own = static_cast<int>(order.size());
  order.insert(order.end(), ghosts.begin(), ghosts.end());
  return order;
}

}  // namespace

PetscSystem::PetscSystem(DistributedProblem& problem, const OfPetsc& options, int threads, PetscReport& report)
    : problem_(problem),
      pool_(threads),
      order_(own_first(problem, own_blocks_)),
      normal_(problem.graph(), problem.resolved(), order_),
      options_(options),
      report_(report) {
  const auto own_scalars = static_cast<std::size_t>(normal_.pattern().offsets[own_blocks_]);
  for (std::vector<double>* v : {&gradient_, &diagonal_, &damping_}) v->resize(own_scalars);
  tangent_.resize(problem.resolved().tangent_dim());
  report_ = PetscReport();
  report_.scalars = problem.total_tangent_dim();
  make_matrix(number_globally());
  make_database();
  make_solver();
}

PetscSystem::~PetscSystem() {
  KSPDestroy(&ksp_);
  if (database_ != nullptr) {
    PetscOptionsPop();
    PetscOptionsDestroy(&database_);
  }
  VecDestroy(&x_);
  VecDestroy(&b_);
  MatDestroy(&A_);
}

// A lower block (row, column) of H is in rows of ours where its row is, and once more, mirrored, where its column is.
template <class Fn>
void PetscSystem::for_each_entry(const Fn& fn) const {
  const BlockPattern& p = normal_.pattern();
  for (int column = 0; column < own_blocks_; ++column)
    for (int b = p.column_begin[column]; b < p.column_begin[column + 1]; ++b) {
      const int row = p.rows[b];
      int k = p.block_begin[b];
      for (int c = 0; c < p.dims[column]; ++c)
        for (int r = 0; r < p.dims[row]; ++r, ++k) {
          const int i = p.offsets[row] + r, j = p.offsets[column] + c;
          if (row < own_blocks_) fn(i, j, k);
          if (row != column) fn(j, i, k);
        }
    }
}

// The number in the whole problem of the first scalar of each block.
std::vector<PetscInt> PetscSystem::number_globally() {
  const BlockPattern& p = normal_.pattern();
  const std::int64_t before = problem_.communicator().sum_before(p.offsets[own_blocks_]);
  if (report_.scalars > std::numeric_limits<PetscInt>::max())
    fail<BadOption>("the problem has ", report_.scalars, " unknowns, and this PETSc counts in ", 8 * sizeof(PetscInt),
                    " bits; use a PETSc configured with --with-64-bit-indices");
  const auto& variables = problem_.resolved().variables();
  std::vector<std::vector<double>> numbers(problem_.values().pools().size());
  for (std::size_t n = 0; n < numbers.size(); ++n) numbers[n].resize(problem_.values().pools()[n]->size());
  for (int i = 0; i < own_blocks_; ++i)
    numbers[variables[order_[i]].pool][variables[order_[i]].index] = static_cast<double>(before + p.offsets[i]);
  problem_.exchange().spread(problem_.communicator(), problem_.values(), numbers);
  std::vector<PetscInt> first;
  for (int v : order_) first.push_back(static_cast<PetscInt>(numbers[variables[v].pool][variables[v].index]));
  return first;
}

void PetscSystem::make_matrix(const std::vector<PetscInt>& numbers) {
  const BlockPattern& p = normal_.pattern();
  std::vector<PetscInt> global(p.scalar_size());
  double narrowest = 1e9, widest = 0;
  for (int i = 0; i < p.size(); ++i)
    for (int c = 0; c < p.dims[i]; ++c) global[p.offsets[i] + c] = numbers[i] + c;
  for (int i = 0; i < own_blocks_; ++i) {
    narrowest = std::min<double>(narrowest, p.dims[i]);
    widest = std::max<double>(widest, p.dims[i]);
  }
  narrowest = -problem_.communicator().max(-narrowest);
  widest = problem_.communicator().max(widest);
  report_.block_size = narrowest == widest ? static_cast<int>(widest) : 1;

  std::vector<PetscInt> rows, columns;
  for_each_entry([&](int i, int j, int) {
    rows.push_back(global[i]);
    columns.push_back(global[j]);
  });
  entries_.resize(rows.size());
  const auto own = static_cast<PetscInt>(size());
  check(MatCreate(problem_.communicator().mpi(), &A_), "MatCreate");
  check(MatSetSizes(A_, own, own, PETSC_DETERMINE, PETSC_DETERMINE), "MatSetSizes");
  check(MatSetBlockSize(A_, report_.block_size), "MatSetBlockSize");
  check(MatSetType(A_, MATAIJ), "MatSetType");
  check(MatSetPreallocationCOO(A_, static_cast<PetscCount>(rows.size()), rows.data(), columns.data()), "MatSetPreallocationCOO");
  check(MatSetOption(A_, MAT_SPD, PETSC_TRUE), "MatSetOption");
  check(MatCreateVecs(A_, &x_, &b_), "MatCreateVecs");
}

// PETSc's options while this system lives: those of the program and the environment, and ours.
void PetscSystem::make_database() {
  char* of_program = nullptr;
  check(PetscOptionsGetAll(nullptr, &of_program), "PetscOptionsGetAll");
  check(PetscOptionsCreate(&database_), "PetscOptionsCreate");
  check(PetscOptionsInsertString(database_, "-sub_pc_type cholesky -pc_asm_overlap 1 -pc_asm_type basic"), "PetscOptionsInsertString");
  check(PetscOptionsInsertString(database_, of_program), "PetscOptionsInsertString");
  check(PetscFree(of_program), "PetscFree");
  check(PetscOptionsInsertString(database_, options_.text.c_str()), "PetscOptionsInsertString");
  check(PetscOptionsPush(database_), "PetscOptionsPush");
}

void PetscSystem::make_solver() {
  check(KSPCreate(problem_.communicator().mpi(), &ksp_), "KSPCreate");
  check(KSPSetOperators(ksp_, A_, A_), "KSPSetOperators");
  check(KSPSetTolerances(ksp_, options_.tolerance, PETSC_DEFAULT, PETSC_DEFAULT, 10000), "KSPSetTolerances");
  PC pc = nullptr;
  check(KSPGetPC(ksp_, &pc), "KSPGetPC");
  PetscBool has_mumps = PETSC_FALSE;
  check(PetscHasExternalPackage("mumps", &has_mumps), "PetscHasExternalPackage");
  if (has_mumps == PETSC_TRUE && report_.scalars <= options_.direct_limit) {
    check(KSPSetType(ksp_, KSPPREONLY), "KSPSetType");
    check(PCSetType(pc, PCCHOLESKY), "PCSetType");
    check(PCFactorSetMatSolverType(pc, MATSOLVERMUMPS), "PCFactorSetMatSolverType");
  } else {
    check(KSPSetType(ksp_, KSPCG), "KSPSetType");
    check(PCSetType(pc, PCASM), "PCSetType");
  }
  check(KSPSetFromOptions(ksp_), "KSPSetFromOptions");
  KSPType ksp_type = nullptr;
  PCType pc_type = nullptr;
  check(KSPGetType(ksp_, &ksp_type), "KSPGetType");
  check(PCGetType(pc, &pc_type), "PCGetType");
  report_.solver = std::string(ksp_type) + " + " + pc_type;
  is_direct_ = std::string(ksp_type) == KSPPREONLY;
  wants_nullspace_ = std::string(pc_type) == PCGAMG;
  MatSolverType factored_by = nullptr;
  if (PCFactorGetMatSolverType(pc, &factored_by) == 0 && factored_by != nullptr) report_.solver += std::string(" (") + factored_by + ")";
}

double PetscSystem::linearize(const Graph& graph, const Values& values, Curvature curvature) {
  normal_.linearize(graph, problem_.resolved(), values, curvature, &pool_);
  std::copy_n(normal_.gradient().begin(), gradient_.size(), gradient_.begin());
  const BlockPattern& p = normal_.pattern();
  for (int i = 0; i < own_blocks_; ++i) {
    const double* block = &normal_.H()[p.block_begin[p.column_begin[i]]];
    for (int c = 0; c < p.dims[i]; ++c) diagonal_[p.offsets[i] + c] = block[c * (p.dims[i] + 1)];
  }
  if (wants_nullspace_) find_modes(values);
  return problem_.cost(values, &pool_);
}

void PetscSystem::set_damping(double lambda, const std::vector<double>& scales) {
  for (std::size_t i = 0; i < damping_.size(); ++i) damping_[i] = lambda == 0 ? 0 : lambda * std::max(scales[i], kLeastDiagonal);
  set_balance();
  std::size_t e = 0;
  const std::vector<double>& H = normal_.H();
  for_each_entry([&](int i, int j, int k) { entries_[e++] = balance_[i] * balance_[j] * (H[k] + (i == j ? damping_[i] : 0.0)); });
  check(MatSetValuesCOO(A_, entries_.data(), INSERT_VALUES), "MatSetValuesCOO");
  if (wants_nullspace_) set_near_nullspace();
}

void PetscSystem::set_balance() {
  const BlockPattern& p = normal_.pattern();
  const auto& variables = problem_.resolved().variables();
  std::vector<std::vector<double>> numbers(problem_.values().pools().size());
  for (std::size_t n = 0; n < numbers.size(); ++n) numbers[n].resize(problem_.values().pools()[n]->size());
  for (int i = 0; i < own_blocks_; ++i) {
    double largest = 0;
    for (int k = p.offsets[i]; k < p.offsets[i + 1]; ++k) largest = std::max(largest, diagonal_[k] + damping_[k]);
    numbers[variables[order_[i]].pool][variables[order_[i]].index] = largest > 0 ? 1 / std::sqrt(largest) : 1;
  }
  problem_.exchange().spread(problem_.communicator(), problem_.values(), numbers);
  balance_.resize(p.scalar_size());
  for (int i = 0; i < p.size(); ++i)
    std::fill(balance_.begin() + p.offsets[i], balance_.begin() + p.offsets[i + 1],
              numbers[variables[order_[i]].pool][variables[order_[i]].index]);
}

double PetscSystem::solve_damped(double lambda, const std::vector<double>& scales, std::vector<double>& step) {
  set_damping(is_direct_ ? lambda : std::max(lambda, kLeastIterativeDamping), scales);
  step.resize(size());
  PetscScalar* b = nullptr;
  check(VecGetArray(b_, &b), "VecGetArray");
  for (std::size_t i = 0; i < size(); ++i) b[i] = -balance_[i] * gradient_[i];
  check(VecRestoreArray(b_, &b), "VecRestoreArray");
  const PetscErrorCode solved = KSPSolve(ksp_, b_, x_);
  KSPConvergedReason reason{};
  PetscInt iterations = 0;
  check(KSPGetConvergedReason(ksp_, &reason), "KSPGetConvergedReason");
  check(KSPGetIterationNumber(ksp_, &iterations), "KSPGetIterationNumber");
  report_.iterations.push_back(iterations);
  if (solved != 0 || (reason < 0 && reason != KSP_DIVERGED_ITS)) {
    check(KSPDestroy(&ksp_), "KSPDestroy");  // a preconditioner that failed once goes on failing
    make_solver();
    return NAN;
  }
  const PetscScalar* x = nullptr;
  check(VecGetArrayRead(x_, &x), "VecGetArrayRead");
  for (std::size_t i = 0; i < size(); ++i) step[i] = balance_[i] * x[i];
  check(VecRestoreArrayRead(x_, &x), "VecRestoreArrayRead");
  double predicted = 0;
  for (std::size_t i = 0; i < size(); ++i) predicted += 0.5 * step[i] * (damping_[i] * step[i] - gradient_[i]);
  predicted = problem_.communicator().sum(predicted);
  return predicted >= 0 ? predicted : NAN;
}

void PetscSystem::multiply(const std::vector<double>& x, std::vector<double>& y) const {
  PetscScalar* to = nullptr;
  check(VecGetArray(b_, &to), "VecGetArray");
  for (std::size_t i = 0; i < x.size(); ++i) to[i] = x[i] / balance_[i];
  check(VecRestoreArray(b_, &to), "VecRestoreArray");
  check(MatMult(A_, b_, x_), "MatMult");
  const PetscScalar* from = nullptr;
  check(VecGetArrayRead(x_, &from), "VecGetArrayRead");
  y.resize(x.size());
  for (std::size_t i = 0; i < x.size(); ++i) y[i] = from[i] / balance_[i] - damping_[i] * x[i];
  check(VecRestoreArrayRead(x_, &from), "VecRestoreArrayRead");
}

void PetscSystem::retract(const Values& from, double t, const std::vector<double>& step, Values& to) {
  std::fill(tangent_.begin(), tangent_.end(), 0.0);
  const BlockPattern& p = normal_.pattern();
  for (int i = 0; i < own_blocks_; ++i)
    for (int c = 0; c < p.dims[i]; ++c) tangent_[problem_.resolved().variables()[order_[i]].offset + c] = t * step[p.offsets[i] + c];
  problem_.resolved().retract(from, tangent_.data(), to);
  problem_.update(to);
}

double PetscSystem::dot(const std::vector<double>& a, const std::vector<double>& b) const {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += a[i] * b[i];
  return problem_.communicator().sum(sum);
}

double PetscSystem::dot(const std::vector<double>& metric, const std::vector<double>& a, const std::vector<double>& b) const {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += metric[i] * a[i] * b[i];
  return problem_.communicator().sum(sum);
}

double PetscSystem::gradient_norm() const { return problem_.communicator().max(max_norm(gradient_)); }

// Translations and rotations of all positions.
void PetscSystem::find_modes(const Values& values) {
  const auto& variables = problem_.resolved().variables();
  const BlockPattern& p = normal_.pattern();
  double space = 0;
  for (int i = 0; i < own_blocks_; ++i) space = std::max<double>(space, values.pool(variables[order_[i]].pool).space());
  const int n = static_cast<int>(problem_.communicator().max(space));
  modes_.clear();
  if (n != 2 && n != 3) return;
  const int turns = n == 2 ? 1 : 3;
  for (int m = 0; m < n + turns; ++m) {
    double v[3] = {}, w[3] = {};
    (m < n ? v[m] : w[m - n]) = 1;
    std::vector<double>& mode = modes_.emplace_back(size(), 0.0);
    for (int i = 0; i < own_blocks_; ++i) {
      const Resolved::Variable& variable = variables[order_[i]];
      if (values.pool(variable.pool).space() == n) values.pool(variable.pool).rigid_motion(variable.index, v, w, &mode[p.offsets[i]]);
    }
  }
}

// What the balanced matrix has in place of the modes, orthonormal. What moves nothing is left out.
void PetscSystem::set_near_nullspace() {
  std::vector<std::vector<double>> basis;
  for (std::vector<double> mode : modes_) {
    for (std::size_t i = 0; i < mode.size(); ++i) mode[i] /= balance_[i];
    const double before = std::sqrt(dot(mode, mode));
    for (const std::vector<double>& other : basis) {
      const double along = dot(mode, other);
      for (std::size_t i = 0; i < mode.size(); ++i) mode[i] -= along * other[i];
    }
    const double length = std::sqrt(dot(mode, mode));
    if (!(length > 1e-8 * before)) continue;
    for (double& x : mode) x /= length;
    basis.push_back(std::move(mode));
  }
  std::vector<Vec> vectors;
  for (const std::vector<double>& mode : basis) {
    check(VecDuplicate(x_, &vectors.emplace_back()), "VecDuplicate");
    PetscScalar* to = nullptr;
    check(VecGetArray(vectors.back(), &to), "VecGetArray");
    std::copy(mode.begin(), mode.end(), to);
    check(VecRestoreArray(vectors.back(), &to), "VecRestoreArray");
  }
  MatNullSpace space = nullptr;
  const auto count = static_cast<PetscInt>(vectors.size());
  check(MatNullSpaceCreate(problem_.communicator().mpi(), PETSC_FALSE, count, vectors.data(), &space), "MatNullSpaceCreate");
  check(MatSetNearNullSpace(A_, space), "MatSetNearNullSpace");
  check(MatNullSpaceDestroy(&space), "MatNullSpaceDestroy");
  for (Vec& vector : vectors) check(VecDestroy(&vector), "VecDestroy");
}

}  // namespace holdfast::detail
