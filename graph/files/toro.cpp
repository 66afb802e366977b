// TORO: VERTEX2, EDGE2 in the plane; VERTEX3, EDGE3 with roll, pitch, yaw in space.
#include <holdfast/graph/files/internal/formats.hpp>

namespace holdfast::io {
namespace {

template <class V>
constexpr auto vertex = vertex_line<Format::Toro, V>;
template <class E>
constexpr auto edge = edge_line<Format::Toro, E>;

constexpr RecordType kLines[] = {
    vertex<Pose2>("VERTEX2", 5, "VERTEX2 id x y angle"),
    vertex<Pose3>("VERTEX3", 8, "VERTEX3 id x y z roll pitch yaw"),
    edge<RelativePoseEdge<Pose2>>("EDGE2", 12, "EDGE2 id id x y angle i11 i12 i22 i33 i13 i23"),
    edge<RelativePoseEdge<Pose3>>("EDGE3", 30, "EDGE3 id id x y z roll pitch yaw, 21 informations"),
};

const char* why_not(Holds holds, std::size_t) {
  switch (holds) {
    case Holds::vertex:
      return "it has poses alone";
    case Holds::edge:
      return "it has relative poses alone";
    case Holds::fixed:
      return "it has no FIX line; clear `fixed`";
    default:
      return "it has no PARAMS lines; clear `offsets`";
  }
}

}  // namespace

const Dialect& toro() {
  static constexpr Dialect dialect{Format::Toro, std::begin(kLines), std::end(kLines), why_not};
  return dialect;
}

}  // namespace holdfast::io
