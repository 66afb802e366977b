// Outliers added to public graphs, as the field does it: false loop closures (Sünderhauf & Protzel's Vertigo; McGann et al.'s riSAM), and
// ranges that are too long.
#pragma once

#include <holdfast/benchmarks/suites/suites.hpp>
#include <optional>

namespace holdfast::bench {

struct FalseLoops {
  enum class Kind {
    random,        ///< between any two poses, any relative pose of the map's size
    at_one_place,  ///< between any two poses, which are said to be one place: N(0, 0.3 m) and N(0, 10°) (Vertigo's generator)
    local,         ///< between poses at most 20 apart, said to be one place
    grouped,       ///< as at_one_place, in groups of 10 that follow each other and agree with the odometry
    local_groups,  ///< grouped, each group between poses at most 20 apart
    near_truth,    ///< the true relative pose and an error whose χ² is at its 95 % quantile and more (riSAM)
  };
  Kind kind;
  double share;  ///< false loops for each true one
};
const char* to_string(FalseLoops::Kind kind);

/// A pose graph of the data directory with its odometry and loops, started from the odometry, and which of its loops are true.
struct AttackedGraph {
  Graph graph;          ///< every loop under the loss Squared
  Values start, clean;  ///< clean: the optimum without false loops
  Values truth;         ///< of ranges; else empty
  std::vector<FactorId> odometry, true_loops, false_loops;
};
/// nullopt where the file is absent. Loops: relative poses between poses that do not follow each other. Their information is that of the
/// first true loop.
std::optional<AttackedGraph> attacked(const std::string& file, const FalseLoops& attack, unsigned seed);

/// Ranges that are too long. "Loops" of the AttackedGraph are ranges.
struct FalseRanges {
  enum class Kind {
    echoes,            ///< by 1 to 20 m, uniformly
    no_line_of_sight,  ///< by 2 m on average, exponentially distributed
    as_it_is,          ///< nothing is added: which of the file's own ranges are false, nobody knows
  };
  Kind kind;
  double share;  ///< probability that a range becomes a false one
};
const char* to_string(FalseRanges::Kind kind);

/// A range graph of the data directory, started from its odometry, its landmarks at truth + N(0, 1 m) by `seed`; nullopt where the file is
/// absent.
std::optional<AttackedGraph> attacked(const std::string& file, const FalseRanges& attack, unsigned seed);

}  // namespace holdfast::bench
