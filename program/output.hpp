// What every command has in common: its lines of JSON, and the examples under its --help.
#pragma once

#include <CLI/App.hpp>
#include <holdfast/common/run.hpp>
#include <holdfast/common/terminal.hpp>
#include <string>
#include <vector>

namespace holdfast::program {

/// The option --json of a command; `what` says what a line is.
void add_json(CLI::App& command, std::string& path, const std::string& what);
/// BadOption where `path` can be no file; "" and "-" are well.
void check_json(const std::string& path);
/// To the file, whole or not at all; "-" is terminal.data; "" is nowhere. No lines: no file, and none that was there stays.
void write_json(const std::string& path, const std::vector<common::Json>& lines, common::Terminal& terminal);

/// "Examples:" under the --help of a command, a line each.
void add_examples(CLI::App& command, const std::vector<std::string>& lines);
/// What the program's own --help ends with: the exit codes and where to go on.
std::string help_end();

}  // namespace holdfast::program
