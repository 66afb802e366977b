// Losses in Python, and what they share with factors in Python.
#pragma once

#include "bind.hpp"

namespace holdfast::python {

void bind_own_losses(nb::module_& m);
/// Of an exception in a function, under the GIL: the next raise_interrupt() raises it where it is Ctrl-C.
void note_interrupt(const std::exception& error);

}  // namespace holdfast::python
