// The front door: what most programs need. Everything else is included by its own path, <holdfast/factors/range_ball.hpp>.
//
//   graph/     Key, Agent, Values, the variable types, Graph, losses, check(graph, values), files
//   factors/   the factors of most problems; one header each
//   solvers/   make_backend("irls")->solve(graph, values), Marginals, outlier_report, Window
#pragma once

#include <holdfast/factors/between.hpp>
#include <holdfast/factors/prior.hpp>
#include <holdfast/factors/range.hpp>
#include <holdfast/factors/range_bearing.hpp>
#include <holdfast/factors/relative_point.hpp>
#include <holdfast/factors/white_acceleration.hpp>
#include <holdfast/graph/check.hpp>
#include <holdfast/graph/draw.hpp>
#include <holdfast/graph/files/files.hpp>
#include <holdfast/graph/graph.hpp>
#include <holdfast/graph/print.hpp>
#include <holdfast/graph/variables.hpp>
#include <holdfast/solvers/marginals.hpp>
#include <holdfast/solvers/outlier_report.hpp>
#include <holdfast/solvers/table.hpp>
#include <holdfast/solvers/window/window.hpp>
