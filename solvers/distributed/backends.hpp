// The back-ends of the component mpi by their names, "petsc" and "nesterov-mpi", where they solve what one process has; without MPI's own
// headers.
//
//   register_mpi_backends();
//   make_backend("petsc")->solve(graph, values);
#pragma once

namespace holdfast {

void register_mpi_backends();

}  // namespace holdfast
