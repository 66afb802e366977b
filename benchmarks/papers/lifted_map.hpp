// Paper C's convex problem as it is printed, (17)–(39): z = (x, y, w, Ω, Υ) with every auxiliary explicit, by projected Nesterov steps.
//
//   minimise ½ zᵀMz − bᵀz:  ½‖p_j − p_i − y_ij‖²/σ² − κ uᵀy/d of each packet that arrived, ½‖x(t) − x(t − 1)‖²/β² of each node,
//   ½ (Ω − d(t − 1))²/ρ² of each that did not;    so that ‖y‖ ≤ d, and ‖y‖ ≤ Ω where the packet is lost.
// y and Ω stand for w and Υ, too, which are those of edges to anchors. All steps at once; x(t − 1) is free, as in
// MissingMap::Previous::free.
#pragma once

#include <functional>
#include <holdfast/benchmarks/papers/network_graph.hpp>

namespace holdfast::bench {

/// How the steps are chosen and what they are projected on.
///   printed   (35)(37)(38): m a sum over all priors, L the sum of the largest eigenvalues of M1 … M5, the momentum that follows from both;
///             (34): each y on the ball of its own Ω, Ω left alone
///   restarted L the largest eigenvalue of M, Nesterov's t with adaptive restart; (y, Ω) together on the second-order cone
enum class LiftedSteps { printed, restarted };

template <int S>
class LiftedMap {
 public:
  /// Missing::coupled: y of a lost packet enters a measured term as that of any other, in which (6) leaves it out.
  LiftedMap(const Network<S>& network, Missing missing);

  /// From all nodes at the middle of the first anchors, y = 0, Ω = d(t − 1), until done(x) or after so many iterations; returns their
  /// number. x: node by node of each step in turn.
  int minimize(LiftedSteps steps, int most_iterations, const std::function<bool(const Eigen::VectorXd& x)>& done);
  Tracks<S> tracks() const;  ///< of the last minimize()

  double printed_m() const;                                             ///< (35)
  double printed_L() const;                                             ///< (37)
  double largest_eigenvalue() const { return largest(kAll); }           ///< of M
  static void project_on_cone(Eigen::Ref<Vector<S>> y, double& omega);  ///< the nearest with ‖y‖ ≤ Ω

 private:
  // The parts of M that (19)–(23) name.
  enum Parts : unsigned { kNodes = 1, kAnchors = 2, kWalk = 4, kOmega = 8, kUpsilon = 16, kAll = 31 };
  struct Edge {
    int from, to;  ///< where in z the two positions begin; to −1: an anchor
    int y, omega;  ///< where in z; omega −1: the packet arrived
    double distance;
  };
  int at(int step, int node) const { return (step * nodes_ + node) * S; }
  Eigen::VectorXd multiply(const Eigen::VectorXd& z, unsigned parts) const;
  double largest(unsigned parts) const;
  void project(LiftedSteps steps, Eigen::VectorXd& z) const;

  int steps_, nodes_;
  double beta_, sigma_;
  bool coupled_;
  std::vector<Edge> edges_;
  Eigen::VectorXd b_, start_, z_;
};

}  // namespace holdfast::bench
