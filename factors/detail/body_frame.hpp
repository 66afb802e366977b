// The derivative of a world vector seen from a turning body: q = Rᵀ v, R ⊕ δ = R Exp(δ), hence dq/dδ = −δ × q.
#pragma once

#include <holdfast/graph/variables/pose2.hpp>
#include <holdfast/graph/variables/pose3.hpp>

namespace holdfast {

inline Matrix<2, 1> turning_jacobian(const Vector<2>& q) { return {q[1], -q[0]}; }
inline Matrix<3, 3> turning_jacobian(const Vector<3>& q) { return so3::hat(q); }

/// A pose: a position and a rotation, in this order in the tangent.
template <class P>
inline constexpr bool is_pose = false;
template <class T>
inline constexpr bool is_pose<Pose2T<T>> = true;
template <class T>
inline constexpr bool is_pose<Pose3T<T>> = true;

}  // namespace holdfast
