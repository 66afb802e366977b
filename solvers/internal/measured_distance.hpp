// What a factor measures as the distance between two positions, found by asking it. Internal.
#pragma once

#include <holdfast/graph/batch.hpp>
#include <optional>

namespace holdfast::detail {

/// r = (‖p_b − p_a‖ − distance) / sigma.
struct MeasuredDistance {
  double distance, sigma;
};

/// Of factor i; nullopt where it is none: where it has other variables than two of Point2 and Pose2, or of Point3 and Pose3, or where its
/// residual is not that of the formula at each of several pairs of states.
std::optional<MeasuredDistance> measured_distance(const FactorBatch& batch, int i);

}  // namespace holdfast::detail
