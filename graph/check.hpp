// The problem check: what is wrong with a graph and its values, by name, before a solver stumbles over it.
#pragma once

#include <holdfast/graph/graph.hpp>
#include <string>
#include <vector>

namespace holdfast {

struct Finding {
  enum class Kind {
    empty_graph,
    unknown_key,
    wrong_type,
    bad_value,     ///< a variable that is not finite, or so large that its square overflows
    bad_residual,  ///< a factor whose residual is not finite at these values
    nothing_free,
    unconstrained_variable,  ///< no factor touches it
    unconstrained_direction,
    disconnected,
    free_gauge,
    zero_distance,  ///< factors with a residual and no derivative: ranges between variables that stand on one spot
    mirror_image,   ///< points that fit as well on the other side of a plane or line (mirror.hpp)
    // of a file (adapters/files/report.hpp)
    unknown_fixed,   ///< FIX names no vertex
    bad_time,        ///< two poses of an agent at one time, or in decreasing time
    repaired_noise,  ///< an indefinite matrix was replaced by the nearest semidefinite one
    no_noise,        ///< an edge without an information
    isam_noise       ///< what the numbers of iSAM's text are had to be assumed
  };
  enum class Severity { warning, error };  ///< error: the problem has no answer, or no unique one

  Kind kind;
  Severity severity;
  std::string text;       ///< culprit, value, rule, cure
  std::vector<Key> keys;  ///< the culprits
};

/// Looks at everything; throws nothing for bad input. Empty: all is well.
std::vector<Finding> check(const Graph& graph, const Values& values);

/// The factors that have a residual and yet no derivative at these values, as one finding; no keys where there is none. A range between two
/// variables on one spot is such a one: the cost falls in every direction, and no gradient says in which. Throws BadKey, BadType.
Finding zero_distance(const Graph& graph, const Values& values);

/// The mirror images of these values (mirror.hpp), a finding each. Throws BadKey, BadType.
std::vector<Finding> mirror_findings(const Graph& graph, const Values& values);

/// Findings that say the same of many keys as one: of each kind and severity beyond three, the first with the keys of the others behind it.
std::vector<Finding> merged(const std::vector<Finding>& findings);

/// True if some finding is an error.
bool has_errors(const std::vector<Finding>& findings);

const char* to_string(Finding::Kind kind);

}  // namespace holdfast
