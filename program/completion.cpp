#include <CLI/CLI.hpp>
#include <holdfast/program/completion.hpp>
#include <holdfast/program/output.hpp>
#include <sstream>
#include <vector>

namespace holdfast::program {
namespace {

using Words = std::vector<std::string>;

std::string joined(const Words& words, const std::string& between) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : between) + word;
  return text;
}

struct OptionWords {
  Words names;  ///< with their dashes; none: it is known by its place
  std::string what;
  Words values;  ///< of which it takes one; none: anything
  bool takes_value = false;
};
struct CommandWords {
  std::string name, what;
  std::vector<OptionWords> options;
};

/// The words that a check for membership lists in the type's name: "TEXT:{half,full}".
Words values_of(const CLI::Option& option) {
  const std::string type = option.get_type_name();
  const std::size_t open = type.find('{'), close = type.find('}');
  Words values;
  if (open == std::string::npos || close == std::string::npos) return values;
  std::istringstream list(type.substr(open + 1, close - open - 1));
  for (std::string value; std::getline(list, value, ',');) values.push_back(value);
  return values;
}

/// The first line, up to the first sentence's end.
std::string short_text(const std::string& text) {
  constexpr std::size_t kLongest = 70;
  std::string line = text.substr(0, text.find_first_of("\n;"));
  if (line.size() > kLongest) line = line.substr(0, line.find_last_of(' ', kLongest)) + " …";
  return line;
}

CommandWords words_of(const CLI::App& command) {
  CommandWords words{command.get_name(), short_text(command.get_description()), {}};
  for (const CLI::Option* option : command.get_options()) {
    OptionWords one{{}, short_text(option->get_description()), values_of(*option), option->get_items_expected_min() > 0};
    for (const std::string& name : option->get_lnames()) one.names.push_back("--" + name);
    for (const std::string& name : option->get_snames()) one.names.push_back("-" + name);
    words.options.push_back(one);
  }
  return words;
}

std::vector<CommandWords> commands_of(const CLI::App& app) {
  std::vector<CommandWords> commands;
  for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; })) commands.push_back(words_of(*command));
  return commands;
}

Words names_of(const CommandWords& command) {
  Words names;
  for (const OptionWords& option : command.options) names.insert(names.end(), option.names.begin(), option.names.end());
  return names;
}
/// Values of what is known by its place.
Words place_values(const CommandWords& command) {
  Words values;
  for (const OptionWords& option : command.options)
    if (option.names.empty()) values.insert(values.end(), option.values.begin(), option.values.end());
  return values;
}

std::string bash(const CommandWords& root, const std::vector<CommandWords>& commands) {
  Words names;
  for (const CommandWords& command : commands) names.push_back(command.name);
  std::ostringstream out;
  out << "# source <(holdfast completion bash)\n"
         "_holdfast() {\n"
         "  local current=${COMP_WORDS[COMP_CWORD]} previous=${COMP_WORDS[COMP_CWORD-1]} command= word options= values=\n"
         "  for word in \"${COMP_WORDS[@]:1:COMP_CWORD-1}\"; do\n"
         "    case $word in "
      << joined(names, "|")
      << ") command=$word; break ;; esac\n"
         "  done\n"
         "  case $command in\n"
         "    '') options='"
      << joined(names_of(root), " ") << "' values='" << joined(names, " ") << "' ;;\n";
  for (const CommandWords& command : commands)
    out << "    " << command.name << ") options='" << joined(names_of(command), " ") << "' values='" << joined(place_values(command), " ")
        << "' ;;\n";
  out << "  esac\n"
         "  case $command:$previous in\n";
  for (const CommandWords& command : commands)
    for (const OptionWords& option : command.options) {
      if (option.names.empty() || !option.takes_value) continue;
      Words places;
      for (const std::string& name : option.names) places.push_back(command.name + ":" + name);
      out << "    " << joined(places, "|") << ") options= values='" << joined(option.values, " ") << "' ;;\n";
    }
  out << "  esac\n"
         "  if [[ $current == -* && -n $options ]]; then\n"
         "    COMPREPLY=($(compgen -W \"$options\" -- \"$current\"))\n"
         "  else\n"
         "    COMPREPLY=()\n"
         "    [[ -z $values ]] || COMPREPLY=($(compgen -W \"$values\" -- \"$current\"))\n"
         "    ((${#COMPREPLY[@]})) || [[ -z $command ]] || COMPREPLY=($(compgen -f -- \"$current\"))\n"
         "  fi\n"
         "}\n"
         "complete -o filenames -F _holdfast holdfast\n";
  return out.str();
}

/// Inside single quotes, the characters that zsh's _arguments gives a meaning escaped.
std::string zsh_text(const std::string& text) {
  std::string escaped;
  for (const char c : text) {
    if (c == '\'')
      escaped += "'\\''";
    else if (c == '[' || c == ']' || c == ':' || c == '\\')
      escaped += std::string("\\") + c;
    else
      escaped += c;
  }
  return escaped;
}

std::string zsh(const CommandWords& root, const std::vector<CommandWords>& commands) {
  std::ostringstream out;
  const auto action = [](const Words& values) { return values.empty() ? std::string("_files") : "(" + joined(values, " ") + ")"; };
  const auto arguments = [&](const CommandWords& command, const std::string& indent) {
    for (const OptionWords& option : command.options)
      for (const std::string& name : option.names)
        out << " \\\n"
            << indent << "'" << name << "[" << zsh_text(option.what) << "]" << (option.takes_value ? ":value:" + action(option.values) : "")
            << "'";
  };
  out << "#compdef holdfast\n"
         "# source <(holdfast completion zsh), or as _holdfast in a directory of $fpath\n"
         "_holdfast() {\n"
         "  local context state line\n"
         "  typeset -A opt_args\n"
         "  _arguments -C";
  arguments(root, "    ");
  out << " \\\n    '1:command:->command' '*::argument:->argument'\n"
         "  case $state in\n"
         "    command)\n"
         "      local -a commands=(";
  for (const CommandWords& command : commands) out << "\n        '" << command.name << ":" << zsh_text(command.what) << "'";
  out << ")\n"
         "      _describe command commands ;;\n"
         "    argument)\n"
         "      case $words[1] in\n";
  for (const CommandWords& command : commands) {
    out << "        " << command.name << ")\n          _arguments";
    arguments(command, "            ");
    const Words values = place_values(command);
    if (!values.empty()) out << " \\\n            '1:value:(" << joined(values, " ") << ")'";
    out << " \\\n            '*:file:_files' ;;\n";
  }
  out << "      esac ;;\n"
         "  esac\n"
         "}\n"
         "if [[ $zsh_eval_context[-1] == loadautofunc ]]; then _holdfast \"$@\"; else compdef _holdfast holdfast; fi\n";
  return out.str();
}

std::string fish_text(const std::string& text) {
  std::string escaped;
  for (const char c : text) escaped += c == '\'' || c == '\\' ? std::string("\\") + c : std::string(1, c);
  return escaped;
}

std::string fish(const CommandWords& root, const std::vector<CommandWords>& commands) {
  std::ostringstream out;
  out << "# holdfast completion fish | source\n";
  const auto options_of = [&](const CommandWords& command, const std::string& condition) {
    for (const OptionWords& option : command.options) {
      if (option.names.empty()) continue;
      out << "complete -c holdfast -n " << condition;
      for (const std::string& name : option.names) out << (name[1] == '-' ? " -l " + name.substr(2) : " -s " + name.substr(1));
      if (option.takes_value) out << (option.values.empty() ? " -r -F" : " -x -a '" + joined(option.values, " ") + "'");
      out << " -d '" << fish_text(option.what) << "'\n";
    }
  };
  options_of(root, "__fish_use_subcommand");
  for (const CommandWords& command : commands) {
    out << "complete -c holdfast -f -n __fish_use_subcommand -a " << command.name << " -d '" << fish_text(command.what) << "'\n";
    const std::string condition = "'__fish_seen_subcommand_from " + command.name + "'";
    const Words values = place_values(command);
    if (!values.empty()) out << "complete -c holdfast -n " << condition << " -a '" << joined(values, " ") << "'\n";
    options_of(command, condition);
  }
  return out.str();
}

}  // namespace

CLI::App* add_completion(CLI::App& app, CompletionArguments& arguments) {
  CLI::App* command = app.add_subcommand("completion", "print a script that completes commands and options in a shell");
  command->add_option("SHELL", arguments.shell, "bash, zsh or fish")->required()->check(CLI::IsMember({"bash", "zsh", "fish"}));
  add_examples(*command, {"source <(holdfast completion bash)", "source <(holdfast completion zsh)", "holdfast completion fish | source"});
  return command;
}

std::string completion(const CLI::App& app, const std::string& shell) {
  const CommandWords root = words_of(app);
  const std::vector<CommandWords> commands = commands_of(app);
  if (shell == "bash") return bash(root, commands);
  return shell == "zsh" ? zsh(root, commands) : fish(root, commands);
}

}  // namespace holdfast::program
