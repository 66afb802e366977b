#include <holdfast/benchmarks/cli.hpp>
#include <iostream>

int main(int argc, char** argv) { return holdfast::bench::run(argc, argv, std::cout, std::cerr); }
