// SPDX-License-Identifier: BSD-3-Clause
#include "tools/manual/completion.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace plslam {
namespace {

std::string Joined(const std::vector<std::string>& words, const char* separator) {
  return fmt::format("{}", fmt::join(words, separator));
}

/// What stands behind an option: words of a list, folders, or files.
std::string ValuesOf(const HelpEntry& option) {
  if (!option.choices.empty()) return fmt::format("words='{}' files=", Joined(option.choices, " "));
  return option.value.starts_with("DIR") ? "words= files=d" : "words= files=f";
}

/// The branch of one command: its options, and the values behind those that take one.
std::string Branch(const HelpPage& page, const std::string& pattern) {
  std::vector<std::string> names;
  std::string values;
  for (const HelpEntry& option : page.options) {
    names.insert(names.end(), option.names.begin(), option.names.end());
    if (!option.TakesValue()) continue;
    values += fmt::format("        {}) {} ;;\n", Joined(option.names, "|"), ValuesOf(option));
  }
  std::string text = fmt::format("    {})\n      options='{}'\n", pattern, Joined(names, " "));
  if (!page.arguments.empty()) text += "      files=f\n";
  if (!values.empty()) text += fmt::format("      case $prev in\n{}      esac\n", values);
  return text + "      ;;\n";
}

}  // namespace

std::string BashCompletion(const std::vector<HelpPage>& pages) {
  const HelpPage& own = pages[0];
  const std::string commands = Joined(own.CommandNames(), " ");
  std::string branches;
  for (size_t i = 1; i < pages.size(); ++i) {
    branches += Branch(pages[i], pages[i].command.substr(own.command.size() + 1));
  }
  branches += Branch(own, "*");
  return fmt::format(R"sh(# Completion of {0} for bash, made from its --help.
_{0}_completion() {{
  local cur=${{COMP_WORDS[COMP_CWORD]}} prev=${{COMP_WORDS[COMP_CWORD - 1]}}
  local command= options= words='{1}' files= i
  for ((i = 1; i < COMP_CWORD; ++i)); do
    case " {1} " in *" ${{COMP_WORDS[i]}} "*) command=${{COMP_WORDS[i]}} words= && break ;; esac
  done
  case $command in
{2}  esac
  if [[ $cur == -* ]]; then
    mapfile -t COMPREPLY < <(compgen -W "$options" -- "$cur")
  else
    mapfile -t COMPREPLY < <(compgen -W "$words" -- "$cur"; [[ -z $files ]] || compgen "-$files" -- "$cur")
    [[ -z $files ]] || compopt -o filenames 2>/dev/null
  fi
}}
complete -F _{0}_completion {0}
)sh",
                     own.command, commands, branches);
}

}  // namespace plslam
