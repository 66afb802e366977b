// Which variables are vector spaces: is_vector_space<V> (graph/manifold.hpp), for every variable type of holdfast.
#pragma once

#include <holdfast/graph/variables.hpp>
