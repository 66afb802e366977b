// The back-ends of the component mpi by their names: there they solve what one process has. Without MPI's own headers.
//
//   register_mpi_backends();
//   make_backend("petsc")->solve(graph, values);
#pragma once

namespace holdfast {

void register_mpi_backends();

}  // namespace holdfast
