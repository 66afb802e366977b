// What a picture of an answer shows, seen from above: ways and landmarks, true and estimated, and the measurements between them.
#pragma once

#include <array>
#include <holdfast/common/run.hpp>

namespace holdfast::common {

struct Drawing {
  using Place = std::array<double, 2>;  ///< x, y [m]
  struct Track {
    std::string name;  ///< of an agent
    bool is_way;       ///< states in the order of their steps; else landmarks
    std::vector<Place> estimate;
    std::vector<Place> truth;  ///< empty: unknown
  };
  /// How sure the answer is of a state or a landmark.
  struct Ellipse {
    Place centre;
    double xx, xy, yy;  ///< covariance [m²]
  };
  struct Line {
    Place from, to;
    std::string factor;
  };
  std::vector<Track> tracks;
  std::vector<Line> kept, rejected;  ///< between two places, but odometry; rejected: outlier_report
  std::vector<Ellipse> ellipses;     ///< of every landmark and of states along each way, as far as they are observable
};

/// The answer is laid onto the truth by a rigid motion, as the ATE has it (metrics.hpp), where the truth is known. Ways of more than `most`
/// states and more than `most` kept lines are thinned out evenly; rejected lines are all there. Throws what outlier_report and Marginals
/// throw.
Drawing drawing_of(const Graph& graph, const Values& truth, const Values& answer, std::size_t most);

/// {"tracks": [{"name", "is_way", "estimate": [[x, y], …], "truth": […]}], "rejected": [[x, y, x, y], …], "ellipses": [[x, y, xx, xy, yy],
/// …]}; places to the millimetre.
Json to_json(const Drawing& drawing);

}  // namespace holdfast::common
