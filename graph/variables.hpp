// Every variable type of holdfast.
#pragma once

#include <holdfast/graph/kinematic.hpp>
#include <holdfast/graph/pose2.hpp>
#include <holdfast/graph/pose3.hpp>
