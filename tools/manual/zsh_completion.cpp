// SPDX-License-Identifier: BSD-3-Clause
#include "tools/manual/completion.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace plslam {
namespace {

/// Within single quotes, as part of a specification of `_arguments`, where brackets and colons mean something.
std::string Escaped(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '\'') {
      out += "'\\''";
    } else if (c == '\n') {
      out += ' ';
    } else {
      if (c == '[' || c == ']' || c == ':' || c == '\\') out += '\\';
      out += c;
    }
  }
  return out;
}

/// What completes the value of an option.
std::string ActionOf(const HelpEntry& option) {
  if (!option.choices.empty()) return fmt::format("({})", fmt::join(option.choices, " "));
  return option.value.starts_with("DIR") ? "_files -/" : "_files";
}

std::string SpecificationsOf(const HelpPage& page) {
  std::string text;
  for (const HelpEntry& option : page.options) {
    for (const std::string& name : option.names) {
      // Options may be given again: some are lists.
      text += fmt::format(" \\\n    '*{}[{}]{}'", name, Escaped(option.meaning),
                          option.TakesValue() ? ":value:" + ActionOf(option) : "");
    }
  }
  return text;
}

/// "rectify-check" as part of the name of a function.
std::string FunctionOf(const std::string& command) {
  std::string name;
  for (const char c : command) name += c == ' ' || c == '-' ? '_' : c;
  return name;
}

}  // namespace

std::string ZshCompletion(const std::vector<HelpPage>& pages) {
  const HelpPage& own = pages[0];
  std::string functions, commands, branches;
  for (size_t i = 1; i < pages.size(); ++i) {
    const HelpPage& page = pages[i];
    const std::string name = page.command.substr(own.command.size() + 1);
    functions += fmt::format("_{}() {{\n  _arguments -s{} \\\n    '*:file:_files'\n}}\n\n", FunctionOf(page.command),
                             SpecificationsOf(page));
    commands += fmt::format("    '{}:{}'\n", name, Escaped(page.Summary()));
    branches += fmt::format("        {}) _{} ;;\n", name, FunctionOf(page.command));
  }
  if (pages.size() == 1) {
    return fmt::format("#compdef {}\n# Made from its --help.\n_arguments -s{} \\\n  '*:file:_files'\n", own.command,
                       SpecificationsOf(own));
  }
  return fmt::format(R"sh(#compdef {0}
# Made from its --help.
{1}_{2}() {{
  local curcontext=$curcontext state line
  local -a commands=(
{3}  )
  _arguments -C -s{4} \
    '1: :->command' '*:: :->arguments'
  case $state in
    command)
      _describe -t commands command commands
      _files
      ;;
    arguments)
      case $words[1] in
{5}        *) _files ;;
      esac
      ;;
  esac
}}

_{2} "$@"
)sh",
                     own.command, functions, FunctionOf(own.command), commands, SpecificationsOf(own), branches);
}

}  // namespace plslam
