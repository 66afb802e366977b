// A g2o file in, a better g2o file out: 08_g2o_file in.g2o out.g2o. Without arguments it makes itself a file with a false loop closure.
#include <fstream>
#include <holdfast/adapters/files/problem.hpp>
#include <holdfast/graph/files/files.hpp>
#include <holdfast/solvers/table.hpp>
#include <iostream>

using namespace holdfast;

namespace {
void write_square(const std::string& path) {
  std::ofstream file(path);
  file << "VERTEX_SE2 0 0 0 0\nVERTEX_SE2 1 1.1 0 1.5\nVERTEX_SE2 2 1.2 1.1 3.1\nVERTEX_SE2 3 0.1 1.2 -1.5\nFIX 0\n";
  for (const char* pair : {"0 1", "1 2", "2 3", "3 0"}) file << "EDGE_SE2 " << pair << " 1 0 1.5707963 100 0 0 100 0 400\n";
  file << "EDGE_SE2 0 2 5 5 0 100 0 0 100 0 400\n";
}
}  // namespace

int main(int argc, char** argv) {
  const std::string in = argc > 2 ? argv[1] : "square.g2o", out = argc > 2 ? argv[2] : "square_better.g2o";
  if (argc <= 2) write_square(in);
  const Dataset dataset = read_g2o(in);
  Problem problem = make_problem(dataset, {GemanMcClure{2}});  // the loss of all edges but the odometry
  const Summary summary = make_backend("irls")->solve(problem.graph, problem.start);
  write_g2o(out, with_values(dataset, problem.start));
  std::cout << summary.str() << '\n';
  return summary.usable() ? 0 : 1;
}
