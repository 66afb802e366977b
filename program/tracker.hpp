// A stream of PyFG lines, in time order, through a Window: what `holdfast track` runs.
//
// Every relative pose of an agent from a state in the window to one that is not there yet is its odometry and brings the new state; other
// relative poses, ranges and points are measurements. A state's time is that of its VERTEX line if there was one, else the edge's. The
// VERTEX line of an agent's first pose says where it starts (else: the identity), held as make_problem (adapters/files/problem.hpp) holds
// it; of a point it is the place round which its start is drawn (odometry_start), and the prior says how far: without one, a beacon ranged
// to once is not observable. Where that is far beside the range, or the point has no vertex, its ranges wait until they say which of two
// places it is at (program/sought.hpp). Other vertices are taken for the truth that errors are measured by. The window is solved whenever
// the time moves on. A measurement of a state that is not there yet waits for it as long as the lag, at most 100 s.
// With `trust`, a party (an agent or a landmark) most of whose latest measurements do not fit is not believed
// (solvers/window/trust.hpp): what it measures is withheld, and its doubtful measurements leave the window, until they fit again. Those
// come back under Huber's loss, as does what the loss lets go of although it fits what is known without it: the state has drifted.
#pragma once

#include <deque>
#include <functional>
#include <holdfast/graph/files/binary.hpp>
#include <holdfast/graph/files/dataset.hpp>
#include <holdfast/program/sought.hpp>
#include <holdfast/solvers/window/trust.hpp>
#include <holdfast/solvers/window/window.hpp>
#include <map>

namespace holdfast::program {

struct TrackOptions {
  WindowOptions window;
  Loss loss;                  ///< of every measurement but the odometry and the priors
  unsigned seed = 0;          ///< of the points' start
  double landmark_sigma = 1;  ///< > 0 [m]: how far that start is from the vertex, and its prior
  bool trust = true;
  std::function<void(const std::string&)> say = [](const std::string&) {};  ///< who is not believed, or believed again, in words
};

struct TrackCounts {
  std::uint64_t lines = 0;  ///< read, those of vertices and comments, too
  std::uint64_t steps = 0;
  std::uint64_t measurements = 0;
  std::uint64_t late = 0;     ///< refused: older than the lag
  std::uint64_t refused = 0;  ///< never fitted: a state or landmark that nobody knows, a wrong type
  std::uint64_t malformed = 0;
  std::uint64_t failed = 0;    ///< steps without a usable answer
  std::uint64_t withheld = 0;  ///< measurements of those that were not believed
  std::uint64_t scored = 0, scored_leaving = 0;
  double squared_error = 0, squared_error_leaving = 0;  ///< [m²] of states when they were the newest, and when they left

  double rmse() const { return std::sqrt(squared_error / static_cast<double>(scored)); }
  double rmse_leaving() const { return std::sqrt(squared_error_leaving / static_cast<double>(scored_leaving)); }
};

/// One state as the window has it.
struct Tracked {
  double time;
  Key key;
  VertexValue value;
  bool leaving;  ///< its last estimate; else it is its agent's newest
};

class Tracker {
 public:
  Tracker(const Tracker&) = delete;
  Tracker& operator=(const Tracker&) = delete;
  /// print: of each agent's newest state after each step in which it is new, and of each state before it leaves.
  Tracker(const TrackOptions& options, std::function<void(const Tracked&)> print);

  /// Throws BadFile (malformed; the line then counts as such). A line that does not fit is counted, and said in last_refusal().
  void line(std::uint64_t number, std::string_view text, const std::string& file);
  /// Only what VERTEX lines say: of lines before the one where a stream is resumed.
  void vertices_of(std::uint64_t number, std::string_view text, const std::string& file);
  /// The last step, and every state that is left.
  void finish();

  const TrackCounts& counts() const { return counts_; }
  const Window& window() const { return window_; }
  const std::string& last_refusal() const { return last_refusal_; }
  void save(const std::string& path) const;
  void restore(const std::string& path);

 private:
  struct Waiting {
    std::uint64_t number;  ///< of its line
    double time;
    std::string text;
    Edge edge;  ///< what the line says: asked again at every step
  };
  /// A measurement between two variables that is or may come into the window.
  struct Heard {
    std::uint64_t number;  ///< of its line
    double time;
    std::string text;
    FactorId id;  ///< number −1: withheld
    Key first, second;
    bool is_judged = false;
  };
  void take(const Vertex& vertex);
  bool take(const Edge& edge);  ///< false: it waits for a state
  template <class E>
  bool add(const E& edge, double time);  ///< false: it waits for a state
  /// Whether all that the edge names is in the window; makes what it can: an agent's first state, a landmark.
  template <class V>
  bool prepare(const RelativePoseEdge<V>& edge, double time);
  template <class P>
  bool prepare(const RelativePointEdge<P>& edge, double time);
  template <class V>
  bool prepare(const PriorEdge<V>& edge, double time);
  bool prepare(const RangeEdge& edge, double time);
  /// What no PyFG line is.
  bool prepare(const BearingEdge& edge, double) { return has(edge.pose) && has(edge.landmark); }
  template <class P>
  bool prepare(const PositionEdge<P>& edge, double) {
    return has(edge.key);
  }
  /// An edge whose second end is an agent's next state brings it.
  template <class V>
  bool add_odometry(const RelativePoseEdge<V>& edge, double time);
  template <class E>
  bool add_odometry(const E&, double) {
    return false;
  }
  template <class V>
  void start(Key key, double time, const Matrix<V::dim, V::dim>& information);
  bool has(Key key) const { return window_.values().contains(key); }
  bool make_landmark(Key key);
  VertexValue drawn(Key key) const;  ///< the start of a point that has a vertex
  /// Whether its ranges wait until they say where it is: nothing is known of it, or little beside this distance [m].
  bool is_sought(Key key, double distance) const;
  void seek();
  bool place(Key key, const std::vector<Sight>& sights);
  template <class P>
  void add_landmark(Key key, const P& start, double sigma);
  /// How long what was measured may wait, and is judged again [s].
  double memory() const { return std::min(options_.window.lag, 100.0); }
  double time_of(Key key, double otherwise) const;
  double time_of(const Edge& edge) const;
  std::uint64_t party(Key key) const;
  bool is_believed(const Heard& one) const { return trust_.is_believed(party(one.first)) && trust_.is_believed(party(one.second)); }
  void hear(const Measurement& measurement, double time, FactorId id);
  FactorId put(const Measurement& measurement, const Loss& loss);
  bool fits(const Heard& one, std::optional<Marginals>& marginals) const;
  bool fits_what_is_known(const Heard& one, std::optional<Marginals>& marginals) const;
  void judge();
  bool judge(Heard& one, bool fits);  ///< true: somebody's trust has changed
  void withhold(std::uint64_t party, Key key);
  bool fit_together(std::uint64_t party) const;
  void bring_back(std::uint64_t party, Key key);
  void advance(double time);
  void retry();
  void print_newest();
  void print(Key key, double time, bool leaving);
  void score(Key key, const VertexValue& value, bool leaving);

  TrackOptions options_;
  std::function<void(const Tracked&)> print_;
  Window window_;
  double now_ = -std::numeric_limits<double>::infinity();
  bool finished_ = false;
  std::map<Key, Vertex> poses_;  ///< of VERTEX lines, until the state has left
  std::map<Key, Vertex> points_;
  std::deque<Waiting> waiting_;
  std::map<Key, std::vector<Sight>> sought_;  ///< points that only ranges know, and are in no window yet
  std::map<Agent, double> printed_;           ///< the time of each agent's newest state that was printed
  TrackCounts counts_;
  std::string last_refusal_;
  Trust trust_;
  std::deque<Heard> heard_;  ///< of the last seconds, as long as the lag
  std::uint64_t line_number_ = 0;
  std::string line_text_;  ///< of the line at hand
};

}  // namespace holdfast::program
