// What solve tells of an answer beyond its cost: is it a minimum, does its mirror image fit as well, do two back-ends that ended at
// different costs stand in one valley.
#pragma once

#include <holdfast/common/run.hpp>
#include <holdfast/graph/check.hpp>
#include <string>
#include <vector>

namespace holdfast::program {

/// "minimum", "saddles_left", … into the line of JSON. Returns a sentence where there is something to tell, else "".
std::string note_second_order(const Summary& summary, common::Json& run);

/// The answer's mirror images (graph/mirror.hpp), each solved from where it lies: a sentence each with both costs, and the answers.
struct MirrorAnswer {
  std::string text;
  Values answer;
};
std::vector<MirrorAnswer> mirror_answers(const common::Task& task, const Graph& graph, const Values& answer, double cost);

/// Of answers of one problem whose costs differ: goes on from each of the higher ones with irls, tighter, and tells slow convergence from
/// another minimum. "ends" into the lines of JSON: "at the lowest cost", "not there yet", "another minimum".
void tell_ends_apart(const Graph& graph, const std::vector<Values>& answers, std::vector<common::Json>& runs);

}  // namespace holdfast::program
