#include <holdfast/program/program.hpp>
#include <iostream>

int main(int argc, char** argv) { return holdfast::program::run(argc, argv, std::cout, std::cerr); }
