// The state of a solve in files, one a process: what a killed job goes on from, in as many processes as there then are.
//
//   load_state(graph, "state");                                  // collective; 0: nothing is there yet
//   options.progress = [&](const Iteration& i) { save_state(graph, "state", i.number); return true; };
//
// Each process writes its own variables to DIRECTORY/part-<rank>.state, whole or not at all (graph/files/atomic.hpp). A job that is killed
// between two processes' writes leaves values of two iterations side by side, from which a solver goes on as well. Whoever loads reads all
// the files and takes what it owns; where two files have a variable, the later one counts: of the later job, then of the later iteration.
#pragma once

#include <holdfast/solvers/distributed/distributed_graph.hpp>
#include <string>

namespace holdfast {

/// Not collective. Throws BadFile.
void save_state(const DistributedGraph& graph, const std::string& directory, int iteration);

/// Collective: own values and ghosts become the saved ones. Makes the directory where it is not there. Returns how many of all variables
/// were found. Throws BadFile naming the file, in every process.
std::int64_t load_state(DistributedGraph& graph, const std::string& directory);

}  // namespace holdfast
