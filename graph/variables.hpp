// Every variable type of holdfast.
#pragma once

#include <holdfast/graph/variables/kinematic.hpp>
#include <holdfast/graph/variables/pose2.hpp>
#include <holdfast/graph/variables/pose3.hpp>
#include <holdfast/graph/variables/print.hpp>
#include <holdfast/graph/variables/turning2.hpp>
