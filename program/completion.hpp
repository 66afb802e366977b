// Completion scripts for shells, made from the commands and options that the program has.
#pragma once

#include <CLI/App.hpp>
#include <string>

namespace holdfast::program {

struct CompletionArguments {
  std::string shell;
};
CLI::App* add_completion(CLI::App& app, CompletionArguments& arguments);

/// The script for "bash", "zsh" or "fish": commands, their options, the values of options that have a list of them, files elsewhere.
std::string completion(const CLI::App& app, const std::string& shell);

}  // namespace holdfast::program
