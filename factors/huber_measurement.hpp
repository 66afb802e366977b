// Paper A's linear measurement between two nodes, eq. (2), (3), (9):   z = A n_s − B n_e + ε,   ε ~ (0, Q) with outliers
//
//   HuberMeasurement<V>          r = Q^{-1/2} (z − known + B x)       one node known (an agent's own estimate), the other a variable
//   HuberMeasurementEdge<S, E>   r = Q^{-1/2} (z − A n_s + B n_e)     both are variables
//
// Loss: Huber with a = 2, element by element after the symmetric whitening Q^{-1/2}. The term weighs `weight`, the paper's 1/σ_i of agent
// i in (8). It is not whitening and does not move the outlier knee; where Q is not already the covariance of agent i, give Q_i
// and weight 1 (or, with Q = I, 1/σ_i²; notes D.A.4). z [m] and Q [m²] in the world frame.
#pragma once

#include <holdfast/factors/detail/rules.hpp>
#include <holdfast/factors/detail/vector_space.hpp>
#include <holdfast/factors/whitening.hpp>
#include <holdfast/graph/batch.hpp>
#include <holdfast/graph/loss.hpp>
#include <holdfast/graph/variables.hpp>

namespace holdfast {

namespace detail {
inline constexpr const char* kWeightCure = "give 1/sigma of the agent, or 1";
}

template <class V, int Rows = space_dim<V>>
struct HuberMeasurement {
  static_assert(is_vector_space<V> && space_dim<V> > 0, "a linear measurement needs a vector space: a point or a motion state");
  using Measurement = Vector<Rows>;
  Measurement z;
  Measurement known;       ///< A n_s of the known start (or −B n_e of a known end)
  Matrix<Rows, V::dim> B;  ///< of the variable (−A when the start is the variable)
  Matrix<Rows, Rows> sqrt_information;
  double weight;

  using Variables = variables<V>;
  static constexpr int residual_dim = Rows;
  static constexpr bool is_linear = true;
  static const char* name() { return "HuberMeasurement"; }
  static constexpr auto fields() {
    return std::tuple(field("z", &HuberMeasurement::z), field("known", &HuberMeasurement::known), field("B", &HuberMeasurement::B),
                      field("sqrt_information", &HuberMeasurement::sqrt_information), field("weight", &HuberMeasurement::weight));
  }
  static Loss default_loss() { return per_component(Huber{2}); }
  double default_weight() const { return weight; }

  static HuberMeasurement known_start(const Measurement& z, const Measurement& A_start, const Matrix<Rows, V::dim>& B,
                                      const Matrix<Rows, Rows>& Q, double weight = 1) {
    return {z, A_start, B, symmetric_sqrt_information_from_covariance<Rows>(Q, "HuberMeasurement.Q"), weight};
  }
  static HuberMeasurement known_end(const Measurement& z, const Matrix<Rows, V::dim>& A, const Measurement& B_end,
                                    const Matrix<Rows, Rows>& Q, double weight = 1) {
    return {z, -B_end, -A, symmetric_sqrt_information_from_covariance<Rows>(Q, "HuberMeasurement.Q"), weight};
  }
  /// An agent at p_agent [m] measures the position of x relative to itself: z = p_agent − p_x (eq. 2 with C_i = C).
  static HuberMeasurement of_position(const Measurement& z, const Measurement& p_agent, const Matrix<Rows, Rows>& Q, double weight = 1) {
    static_assert(Rows == space_dim<V>, "a position has as many rows as the space");
    return known_start(z, p_agent, V::position_jacobian(), Q, weight);
  }

  Measurement operator()(const V& x, Jacobians<HuberMeasurement>* J = nullptr) const {
    if (J != nullptr) J->all.noalias() = sqrt_information * B;
    return sqrt_information * (z - known + B * x.value);
  }

  void validate() const {
    require_finite("HuberMeasurement.z", z);
    require_finite("HuberMeasurement.known", known);
    require_finite("HuberMeasurement.B", B);
    require_finite("HuberMeasurement.sqrt_information", sqrt_information);
    require_positive_number("HuberMeasurement.weight", weight, detail::kWeightCure);
  }
};

template <class S, class E, int Rows = space_dim<S>>
struct HuberMeasurementEdge {
  static_assert(is_vector_space<S> && is_vector_space<E> && space_dim<S> > 0 && space_dim<S> == space_dim<E>,
                "a linear measurement needs vector spaces: points or motion states");
  using Measurement = Vector<Rows>;
  Measurement z;
  Matrix<Rows, S::dim> A;
  Matrix<Rows, E::dim> B;
  Matrix<Rows, Rows> sqrt_information;
  double weight;

  using Variables = variables<S, E>;
  static constexpr int residual_dim = Rows;
  static constexpr bool is_linear = true;
  static const char* name() { return "HuberMeasurementEdge"; }
  static constexpr auto fields() {
    return std::tuple(field("z", &HuberMeasurementEdge::z), field("A", &HuberMeasurementEdge::A), field("B", &HuberMeasurementEdge::B),
                      field("sqrt_information", &HuberMeasurementEdge::sqrt_information), field("weight", &HuberMeasurementEdge::weight));
  }
  static Loss default_loss() { return per_component(Huber{2}); }
  double default_weight() const { return weight; }

  /// z = p_s − p_e, both positions unknown.
  static HuberMeasurementEdge of_position(const Measurement& z, const Matrix<Rows, Rows>& Q, double weight = 1) {
    static_assert(Rows == space_dim<S>, "a position has as many rows as the space");
    return {z, S::position_jacobian(), E::position_jacobian(),
            symmetric_sqrt_information_from_covariance<Rows>(Q, "HuberMeasurementEdge.Q"), weight};
  }

  Measurement operator()(const S& s, const E& e, Jacobians<HuberMeasurementEdge>* J = nullptr) const {
    if (J != nullptr) {
      J->template wrt<0>().noalias() = -sqrt_information * A;
      J->template wrt<1>().noalias() = sqrt_information * B;
    }
    return sqrt_information * (z - A * s.value + B * e.value);
  }

  void validate() const {
    require_finite("HuberMeasurementEdge.z", z);
    require_finite("HuberMeasurementEdge.A", A);
    require_finite("HuberMeasurementEdge.B", B);
    require_finite("HuberMeasurementEdge.sqrt_information", sqrt_information);
    require_positive_number("HuberMeasurementEdge.weight", weight, detail::kWeightCure);
  }
};

// Compiled into the library (factors/compiled.cpp), not anew by whoever adds them to a graph.
extern template class Batch<HuberMeasurement<Motion2>>;

}  // namespace holdfast
