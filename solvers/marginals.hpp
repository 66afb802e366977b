// Covariances of the variables of a graph: blocks of H⁻¹, H = Σ w ρ'(s) JᵀJ at given values (Gauss–Newton with the IRLS weights of
// robust terms), exact, in the tangent of each variable: translation (world frame) [m], then rotation (body frame) [rad].
//
//   const Marginals marginals(graph, answer);
//   const Matrix<3, 3> C = marginals.covariance<Pose2>(A(7));
//   const Matrix<6, 6> joint = marginals.joint<Pose2, Pose2>(A(7), A(8));  // [C_77 C_78; C_87 C_88]
//
// The constructor factors H once and finds all blocks of H⁻¹ that the factor has by Takahashi's recursion (Takahashi, Fagan & Chin 1973;
// Kaess & Dellaert 2009), in memory O(factor). Pairs that share a factor or a front are then read off; any other costs a few
// triangular solves. A variable that the factors leave free at these values has no covariance, and asking for it throws an
// UnobservableError; the other variables of the same graph answer as if it were known in any way. Where weights differ so much that a
// direction's information is 1e-15 of what surrounds it, it counts as free: double precision cannot tell. (The same rule as check()'s:
// graph/observability.hpp. check() counts every term as squared, Marginals weigh it by its loss.)
// A fixed variable is a constant: its covariance, and that with any other, is zero.
#pragma once

#include <holdfast/graph/graph.hpp>
#include <memory>

namespace holdfast {

/// A covariance that does not exist.
class UnobservableError : public Error {
 public:
  UnobservableError(const std::string& text, std::vector<Key> keys) : Error(text), keys_(std::move(keys)) {}
  const std::vector<Key>& keys() const { return keys_; }  ///< of the variables asked for, those that are not observable

 private:
  std::vector<Key> keys_;
};

class Marginals {
 public:
  /// Throws BadProblem (no factor), BadNumber (a residual or Jacobian that is not finite, names the factor), BadKey, BadType.
  Marginals(const Graph& graph, const Values& values);
  Marginals(Marginals&&) noexcept;
  Marginals& operator=(Marginals&&) noexcept;
  ~Marginals();

  /// dim × dim, symmetric. Throws BadKey (no factor touches it), UnobservableError.
  std::vector<double> covariance(Key key) const;
  /// (dim a + dim b)², symmetric, a first. Throws the same.
  std::vector<double> joint(Key a, Key b) const;

  /// The same by type; throws BadType, too.
  template <class V>
  Matrix<V::dim, V::dim> covariance(Key key) const {
    check_type(key, typeid(V), V::name());
    return Eigen::Map<const Matrix<V::dim, V::dim>>(covariance(key).data());
  }
  template <class A, class B>
  Matrix<A::dim + B::dim, A::dim + B::dim> joint(Key a, Key b) const {
    check_type(a, typeid(A), A::name());
    check_type(b, typeid(B), B::name());
    return Eigen::Map<const Matrix<A::dim + B::dim, A::dim + B::dim>>(joint(a, b).data());
  }

  /// Whether covariance(key) has an answer. Throws BadKey.
  bool is_observable(Key key) const;
  /// Every variable without one, sorted.
  std::vector<Key> unobservable() const;

 private:
  struct Impl;
  void check_type(Key key, std::type_index type, const char* type_name) const;

  std::unique_ptr<Impl> impl_;
};

}  // namespace holdfast
