#include <chrono>
#include <cmath>
#include <holdfast/graph/detail/union_find.hpp>
#include <holdfast/graph/resolved.hpp>
#include <holdfast/solvers/certificate.hpp>
#include <holdfast/solvers/convex_start.hpp>
#include <holdfast/solvers/internal/pose_minorant.hpp>
#include <holdfast/solvers/internal/tied_blocks.hpp>
#include <sstream>

namespace holdfast {
namespace {

using detail::PoseMinorant;

constexpr double kSmallCost = 1e-10;  // a gap as small as that is rounding, whatever the cost
constexpr double kSameBasin = 0.5;    // [rad] the farthest turn from the answer to the chordal minimum of the same verdict
constexpr double kLargestChord = 8;   // ‖R − R'‖²_F of two rotations, in the plane and in space
constexpr int kMostPolishSteps = 30;

/// The poses of one type that relative poses tie, and which of them are held.
template <class Pose>
struct TiedPoses {
  struct Edge {
    int first, second;
    MeasuredPose<Pose> measured;
    double weight;
  };
  std::vector<Pose> poses;
  std::vector<Edge> edges;
  std::vector<int> number;  ///< among those that are free; −1: held
  int free = 0;

  void hold(std::vector<char> held) {
    detail::UnionFind parts(static_cast<int>(poses.size()));
    for (const Edge& edge : edges) parts.unite(edge.first, edge.second);
    std::vector<char> part_is_held(poses.size(), 0);
    for (std::size_t i = 0; i < poses.size(); ++i)
      if (held[i] != 0) part_is_held[parts.root(static_cast<int>(i))] = 1;
    for (std::size_t i = 0; i < poses.size(); ++i) {
      char& part = part_is_held[parts.root(static_cast<int>(i))];
      if (part == 0) part = held[i] = 1;
      number.push_back(held[i] != 0 ? -1 : free++);
    }
  }
};

template <class Pose>
TiedPoses<Pose> tied_poses(const Graph& graph, const Values& values) {
  TiedPoses<Pose> tied;
  std::unordered_map<Key, int> node;
  std::vector<char> held;
  const auto node_of = [&](Key key) {
    const auto [it, is_new] = node.try_emplace(key, static_cast<int>(tied.poses.size()));
    if (is_new) {
      tied.poses.push_back(values.at<Pose>(key));
      held.push_back(graph.is_fixed(key) ? 1 : 0);
    }
    return it->second;
  };
  for (const auto& batch : graph.batches()) {
    const auto* const poses = dynamic_cast<const RelativePoses<Pose>*>(batch.get());
    if (poses == nullptr) continue;
    for (int i = 0; i < batch->size(); ++i)
      if (batch->loss(i) == Loss{} && batch->weight(i) > 0)
        tied.edges.push_back({node_of(batch->keys(i)[0]), node_of(batch->keys(i)[1]), poses->measured_pose(i), batch->weight(i)});
  }
  tied.hold(held);
  return tied;
}

/// c + ½⟨Z, Q Z⟩ at the rows Z of given poses, its multipliers and S.
template <class Pose>
class Quadratic {
 public:
  static constexpr int n = Pose::space_dim, rows = n + 1, dof = Pose::dim, turns = dof - n;
  using Minorants = std::vector<PoseMinorant<Pose>>;
  using Matrices = Eigen::MatrixXd;

  Quadratic(const TiedPoses<Pose>& tied) : tied_(tied), structure_(structure_of(tied)), S_(structure_) {}

  void set(const Minorants& minorants, const std::vector<Pose>& poses) {
    S_.set_zero();
    E_ = Matrices::Zero(rows * tied_.free, n);
    value_ = 0;
    for (std::size_t e = 0; e < minorants.size(); ++e) add(tied_.edges[e], minorants[e], poses);
    for (std::size_t i = 0; i < poses.size(); ++i)
      if (tied_.number[i] >= 0) subtract_multiplier(tied_.number[i], poses[i].rotation());
  }

  double value() const { return value_; }
  int factorizations() const { return factorizations_; }

  /// S + eta on the rotations is positive definite.
  bool factor(double eta) {
    Vector<rows> shift = Vector<rows>::Constant(eta);
    shift[n] = 0;
    ++factorizations_;
    return S_.factor(shift);
  }
  /// ½⟨E, S⁻¹E⟩ with what has been factored.
  double decrease() { return 0.5 * E_.cwiseProduct(S_.solve(E_)).sum(); }

  /// The least eta, to a part in 100, for which factor(eta): it stays factored. NaN where there is none of a size that makes sense.
  double least_shift() {
    double largest = 0;
    S_.for_each([&](int i, int j, const auto& block) {
      if (i == j) largest = std::max(largest, block.diagonal().cwiseAbs().maxCoeff());
    });
    double low = 0, high = 1e-8 * largest;
    while (!factor(high)) {
      low = high;
      high *= 30;
      if (!(high < 1e6 * largest)) return NAN;
    }
    const double guess = 1.01 * (high - inverse_iteration());  // from above: the Rayleigh quotient is too large
    for (int tries = 0; tries < 8 && high - low > 0.01 * high; ++tries) {
      double middle = low > 0 ? std::sqrt(low * high) : 0.1 * high;
      if (tries == 0 && guess > low && guess < high) middle = guess;
      (factor(middle) ? high : low) = middle;
    }
    return factor(high) ? high : NAN;
  }

  /// A Newton step of the quadratic over the rotations, from where it was set. Empty: its Hessian is indefinite whatever the damping.
  std::vector<Pose> newton_step(const std::vector<Pose>& poses, double damping);

 private:
  static BlockGraph structure_of(const TiedPoses<Pose>& tied) {
    std::vector<std::pair<int, int>> pairs;
    for (const auto& edge : tied.edges) {
      const int i = tied.number[edge.first], j = tied.number[edge.second];
      if (i >= 0 && j >= 0 && i != j) pairs.emplace_back(i, j);
    }
    return detail::block_graph_of(tied.free, rows, std::move(pairs));
  }

  void add(const typename TiedPoses<Pose>::Edge& edge, const PoseMinorant<Pose>& m, const std::vector<Pose>& poses) {
    const auto Z = PoseMinorant<Pose>::rows_of(poses[edge.first], poses[edge.second]);
    const Matrix<2 * rows, n> KZ = m.K * Z;
    value_ += m.constant + 0.5 * Z.cwiseProduct(KZ).sum();
    const int i = tied_.number[edge.first], j = tied_.number[edge.second];
    if (i >= 0) {
      S_.add(i, i, m.K.template topLeftCorner<rows, rows>());
      E_.middleRows<rows>(rows * i) += KZ.template topRows<rows>();
    }
    if (j >= 0) {
      S_.add(j, j, m.K.template bottomRightCorner<rows, rows>());
      E_.middleRows<rows>(rows * j) += KZ.template bottomRows<rows>();
    }
    if (i < 0 || j < 0) return;
    const Matrix<rows, rows> across = m.K.template topRightCorner<rows, rows>();
    if (i != j)
      S_.add(i, j, across);
    else
      S_.add(i, i, across + across.transpose());
  }

  void subtract_multiplier(int i, const Matrix<n, n>& R) {
    const Matrix<n, n> QXR = E_.middleRows<n>(rows * i) * R;
    Matrix<rows, rows> multiplier = Matrix<rows, rows>::Zero();
    multiplier.template topLeftCorner<n, n>() = 0.5 * (QXR + QXR.transpose());
    S_.add(i, i, -multiplier);
    E_.middleRows<n>(rows * i) -= multiplier.template topLeftCorner<n, n>() * R.transpose();
  }

  /// The least eigenvalue of S + eta in the metric of the rotations, as factored, from above.
  double inverse_iteration() {
    constexpr int kSteps = 20;
    Matrices v(rows * tied_.free, 1);
    for (Eigen::Index k = 0; k < v.rows(); ++k) v(k, 0) = k % rows == n ? 0.0 : std::sin(1.0 + static_cast<double>(k));
    double growth = 0;
    for (int step = 0; step < kSteps; ++step) {
      v /= v.norm();
      Matrices next = S_.solve(v);
      for (Eigen::Index k = n; k < v.rows(); k += rows) next(k, 0) = 0;
      growth = v.cwiseProduct(next).sum();
      v = next;
    }
    return 1 / growth;
  }

  const TiedPoses<Pose>& tied_;
  BlockGraph structure_;
  detail::TiedBlocks<rows> S_;
  Matrices E_;
  double value_ = 0;
  int factorizations_ = 0;
};

/// Of a pose's tangent: δZ = Σ B_k δ_k.
template <class Pose>
std::array<Matrix<Pose::space_dim + 1, Pose::space_dim>, Pose::dim> tangent_rows(const Pose& pose) {
  constexpr int n = Pose::space_dim;
  std::array<Matrix<n + 1, n>, Pose::dim> basis;
  for (auto& rows : basis) rows.setZero();
  for (int k = 0; k < n; ++k) basis[k](n, k) = 1;
  const Matrix<n, n> transposed = pose.rotation().transpose();
  for (int k = n; k < Pose::dim; ++k) {
    Matrix<n, n> turn;  // d Rᵀ = −[ω] Rᵀ
    if constexpr (n == 2)
      turn << 0, 1, -1, 0;
    else
      turn = -so3::hat(Vector<3>::Unit(k - n));
    basis[k].template topRows<n>() = turn * transposed;
  }
  return basis;
}

template <class Pose>
std::vector<Pose> Quadratic<Pose>::newton_step(const std::vector<Pose>& poses, double damping) {
  std::vector<std::array<Matrix<rows, n>, dof>> basis(tied_.free);
  for (std::size_t i = 0; i < poses.size(); ++i)
    if (tied_.number[i] >= 0) basis[tied_.number[i]] = tangent_rows(poses[i]);
  BlockGraph structure = structure_;
  structure.dims.assign(structure.size(), dof);
  detail::TiedBlocks<dof> H(structure);
  S_.for_each([&](int i, int j, const Matrix<rows, rows>& block) {
    Matrix<dof, dof> h;
    for (int b = 0; b < dof; ++b) {
      const Matrix<rows, n> column = block * basis[j][b];
      for (int a = 0; a < dof; ++a) h(a, b) = basis[i][a].cwiseProduct(column).sum();
    }
    H.add(i, j, h);
  });
  ++factorizations_;
  if (!H.factor(Vector<dof>::Constant(damping))) return {};
  Matrices rhs(dof * tied_.free, 1);
  for (int i = 0; i < tied_.free; ++i)
    for (int a = 0; a < dof; ++a) rhs(dof * i + a, 0) = -basis[i][a].cwiseProduct(E_.middleRows<rows>(rows * i)).sum();
  const Matrices step = H.solve(rhs);
  std::vector<Pose> moved = poses;
  for (std::size_t i = 0; i < poses.size(); ++i)
    if (tied_.number[i] >= 0) moved[i] = poses[i].retract(Vector<dof>(step.middleRows<dof>(dof * tied_.number[i])));
  return moved;
}

/// What the poses of one type add to the certificate.
template <class Pose>
class PosePart {
 public:
  PosePart(const Graph& graph, const Values& values) : tied_(tied_poses<Pose>(graph, values)) {}

  bool is_empty() const { return tied_.free == 0; }

  /// Adds its bound. Positive definite: S as it is.
  void bound(Certificate& certificate) {
    typename Quadratic<Pose>::Minorants minorants;
    for (const auto& edge : tied_.edges) {
      if (!detail::is_isotropic<Pose>(edge.measured.information)) certificate.is_isotropic = false;
      minorants.push_back(detail::minorant_at<Pose>(edge.measured, edge.weight, tied_.poses[edge.first], tied_.poses[edge.second]));
    }
    quadratic_.emplace(tied_);
    quadratic_->set(minorants, tied_.poses);
    if (quadratic_->factor(0)) {
      certificate.bound += std::max(0.0, quadratic_->value() - quadratic_->decrease());
    } else {
      certificate.positive_definite = false;
      const double eta = quadratic_->least_shift();
      const double slack = 0.5 * kLargestChord * eta * tied_.free;
      const double bound = quadratic_->value() - quadratic_->decrease() - slack;
      certificate.bound += bound > 0 ? bound : 0;
      certificate.eta = std::max(certificate.eta, eta);
    }
    certificate.factorizations += quadratic_->factorizations();
  }

  /// Adds the chordal cost, its bound and the way there; false where the bound is not tight.
  bool ask_chordal(Certificate& certificate) {
    const Chordal chordal = chordal_minimum(detail::chordal_form<Pose>, certificate);
    certificate.chordal_cost += chordal.cost;
    certificate.chordal_bound += chordal.bound;
    for (std::size_t i = 0; i < tied_.poses.size(); ++i) {
      const Vector<Pose::dim> way = tied_.poses[i].local(chordal.poses[i]);
      certificate.chordal_move = std::max(certificate.chordal_move, way.template head<Pose::space_dim>().norm());
      certificate.chordal_turn = std::max(certificate.chordal_turn, way.template tail<Pose::dim - Pose::space_dim>().norm());
    }
    return chordal.is_definite;
  }
  /// A bound of the graph's own cost by the chordal cost below it.
  double bound_by_chordal(Certificate& certificate) { return chordal_minimum(detail::chordal_form_below<Pose>, certificate).bound; }

 private:
  struct Chordal {
    double cost, bound;
    bool is_definite;
    std::vector<Pose> poses;
  };
  using Form = PoseMinorant<Pose> (*)(const MeasuredPose<Pose>&, double);

  /// Of a chordal cost, the minimum that Newton's method finds from the answer, and whether it is the lowest.
  Chordal chordal_minimum(Form form, Certificate& certificate) {
    typename Quadratic<Pose>::Minorants forms;
    for (const auto& edge : tied_.edges) forms.push_back(form(edge.measured, edge.weight));
    Quadratic<Pose> chordal(tied_);
    std::vector<Pose> poses = tied_.poses;
    chordal.set(forms, poses);
    polish(chordal, forms, poses);
    const bool definite = chordal.factor(0);
    const double bound = definite ? std::max(0.0, chordal.value() - chordal.decrease()) : 0.0;
    certificate.factorizations += chordal.factorizations();
    return {chordal.value(), bound, definite, std::move(poses)};
  }

  static void polish(Quadratic<Pose>& chordal, const typename Quadratic<Pose>::Minorants& forms, std::vector<Pose>& poses) {
    constexpr double kFlat = 1e-15;  // of the cost
    double damping = 0;
    for (int step = 0; step < kMostPolishSteps; ++step) {
      const double before = chordal.value();
      const std::vector<Pose> moved = chordal.newton_step(poses, damping);
      if (!moved.empty()) chordal.set(forms, moved);
      if (moved.empty() || !(chordal.value() <= before * (1 + kFlat))) {
        chordal.set(forms, poses);
        damping = std::max(10 * damping, 1e-3);
        continue;
      }
      poses = moved;
      damping *= 0.1;
      if (before - chordal.value() <= kFlat * before) return;
    }
  }

  TiedPoses<Pose> tied_;
  std::optional<Quadratic<Pose>> quadratic_;
};

template <class... Parts>
bool ask_chordal(Certificate& certificate, Parts&... parts) {
  certificate.chordal_cost = certificate.chordal_bound = certificate.chordal_move = certificate.chordal_turn = 0;
  return ((parts.is_empty() || parts.ask_chordal(certificate)) & ...);
}

template <class... Parts>
double bound_by_chordal(Certificate& certificate, Parts&... parts) {
  return (0.0 + ... + (parts.is_empty() ? 0.0 : parts.bound_by_chordal(certificate)));
}

bool is_tight(double cost, double bound, double tolerance) { return cost - bound <= std::max(tolerance * cost, kSmallCost); }

/// What counts as 0 in the bound.
void leave_out(const Graph& graph, const Resolved& resolved, const Values& values, Certificate& certificate) {
  std::vector<double> r;
  for (std::size_t b = 0; b < graph.batches().size(); ++b) {
    const FactorBatch& batch = *graph.batches()[b];
    const bool are_poses =
        dynamic_cast<const RelativePoses<Pose2>*>(&batch) != nullptr || dynamic_cast<const RelativePoses<Pose3>*>(&batch) != nullptr;
    r.resize(static_cast<std::size_t>(batch.residual_dim()));
    for (int i = 0; i < batch.size(); ++i) {
      if (batch.weight(i) == 0) continue;
      if (are_poses && batch.loss(i) == Loss{}) {
        ++certificate.terms;
        continue;
      }
      if (certificate.left_out++ == 0) certificate.left_out_first = batch.describe(i);
      certificate.left_out_cost += batch.cost(values, resolved.batches()[b].index.data(), i, i + 1);
    }
  }
}

/// Every factor convex by itself or by its counterpart, every loss convex: then the relaxation lies below the graph.
bool relaxes(const Graph& graph, const Graph& relaxed) {
  for (const auto& batch : graph.batches())
    for (int i = 0; i < batch->size(); ++i)
      if (!batch->loss(i).is_convex()) return false;
  return std::all_of(relaxed.batches().begin(), relaxed.batches().end(), [](const auto& batch) { return batch->is_convex(); });
}

void ask_relaxation(const Graph& graph, const Values& values, Certificate& certificate) {
  if (!relaxes(graph, graph.relaxed())) return;
  Values x = values;
  Options options;
  options.cost_tolerance = 1e-12;
  const RelaxedStart start = relaxed_start(graph, x, options);
  if (start.relaxed.termination != Termination::converged) return;
  certificate.relaxation = start.relaxed.cost;
  certificate.bound = std::max(certificate.bound, start.relaxed.cost);
}

}  // namespace

void CertificateOptions::validate() const {
  if (!(tolerance > 0 && std::isfinite(tolerance)))
    fail<BadOption>("CertificateOptions.tolerance = ", tolerance, " must be finite and > 0; 1e-7 is usual");
}

Certificate certify(const Graph& graph, const Values& values, const CertificateOptions& options) {
  const auto begin = std::chrono::steady_clock::now();
  options.validate();
  if (graph.size() == 0) fail<BadProblem>("the graph has no factors, so there is nothing to certify; add measurements first");
  const Resolved resolved(graph, values);
  Certificate certificate;
  certificate.tolerance = options.tolerance;
  certificate.cost = resolved.cost(graph, values);
  if (!std::isfinite(certificate.cost))
    fail<BadNumber>("the cost is not finite at these values: ", resolved.first_non_finite(graph, values).text,
                    "; repair the value or the factor before asking for a certificate");
  leave_out(graph, resolved, values, certificate);

  PosePart<Pose2> flat(graph, values);
  PosePart<Pose3> spatial(graph, values);
  certificate.positive_definite = certificate.terms > 0;
  if (!flat.is_empty()) flat.bound(certificate);
  if (!spatial.is_empty()) spatial.bound(certificate);
  if (certificate.left_out > 0 && options.ask_relaxation) ask_relaxation(graph, values, certificate);
  certificate.bound = std::min(certificate.bound, certificate.cost);  // rounding
  if (is_tight(certificate.cost, certificate.bound, options.tolerance)) {
    certificate.verdict = Certificate::Verdict::global_minimum;
  } else if (options.ask_chordal && certificate.left_out == 0 && !certificate.positive_definite) {
    certificate.bound = std::max(certificate.bound, bound_by_chordal(certificate, flat, spatial));
    const bool definite = ask_chordal(certificate, flat, spatial);
    if (definite && certificate.chordal_turn <= kSameBasin &&
        is_tight(certificate.chordal_cost, certificate.chordal_bound, options.tolerance))
      certificate.verdict = Certificate::Verdict::chordal_minimum;
  }
  certificate.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return certificate;
}

std::string Certificate::str() const {
  std::ostringstream text;
  text.precision(10);
  text << to_string(verdict) << ": cost " << cost << ", bound " << bound;
  text.precision(2);
  text << ", gap " << gap() << " (" << relative_gap() << " of the cost), " << seconds << " s, " << factorizations
       << (factorizations == 1 ? " factorisation" : " factorisations");
  if (left_out > 0)
    text << "; " << left_out << (left_out == 1 ? " term counts" : " terms count") << " as 0 in the bound (" << left_out_first
         << (left_out > 1 ? ", …" : "") << "), cost " << left_out_cost << " here";
  if (std::isfinite(relaxation)) text << "; convex relaxation " << relaxation;
  if (terms > 0 && !positive_definite) text << "; the dual matrix is not positive definite (shift " << eta << ")";
  if (terms > 0 && positive_definite && verdict == Verdict::not_certified && left_out == 0)
    text << "; the dual matrix is positive definite: the answer lies above the minimum by at most the gap; solve to a smaller tolerance";
  if (std::isfinite(chordal_cost)) {
    text.precision(10);
    text << "; chordal cost with isotropic weights " << chordal_cost << ", bound " << chordal_bound;
    text.precision(2);
    text << ", its minimum " << chordal_move << " m and " << chordal_turn << " rad away";
    if (!is_isotropic) text << " (information is not isotropic: it weighs otherwise)";
  }
  return text.str();
}

const char* to_string(Certificate::Verdict verdict) {
  static const char* const names[] = {"global minimum", "global minimum of the chordal cost", "not certified"};
  return names[static_cast<int>(verdict)];
}

}  // namespace holdfast
