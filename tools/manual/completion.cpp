// SPDX-License-Identifier: BSD-3-Clause
#include "tools/manual/completion.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace plslam::manual {
namespace {

std::string Joined(const std::vector<std::string>& words, const char* separator) {
  return fmt::format("{}", fmt::join(words, separator));
}

/// Returns the values of an option: words of a list, folders, or files.
std::string BashValues(const HelpEntry& option) {
  if (!option.choices.empty()) return fmt::format("words='{}' files=", Joined(option.choices, " "));
  return option.value.starts_with("DIR") ? "words= files=d" : "words= files=f";
}

/// Returns the branch of one command: its options, and the values of options that take one.
std::string Branch(const HelpPage& page, const std::string& pattern) {
  std::vector<std::string> names;
  std::string values;
  for (const HelpEntry& option : page.options) {
    names.insert(names.end(), option.names.begin(), option.names.end());
    if (!option.TakesValue()) continue;
    values += fmt::format("        {}) {} ;;\n", Joined(option.names, "|"), BashValues(option));
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

namespace {

std::string Quoted(const std::string& text) {
  std::string out = "'";
  for (const char c : text) {
    if (c == '\'' || c == '\\') out += '\\';
    out += c == '\n' ? ' ' : c;
  }
  return out + "'";
}

/// Returns the completion of an option's value: required, and words of a list, folders or files.
std::string FishValues(const HelpEntry& option) {
  if (!option.TakesValue()) return "";
  if (!option.choices.empty())
    return fmt::format(" -x -a {}", Quoted(fmt::format("{}", fmt::join(option.choices, " "))));
  return option.value.starts_with("DIR") ? " -x -a '(__fish_complete_directories)'" : " -r -F";
}

/// Returns a line for each option of a page; `condition` decides when it applies.
std::string OptionLines(const std::string& program, const std::string& condition, const HelpPage& page) {
  std::string text;
  for (const HelpEntry& option : page.options) {
    text += fmt::format("complete -c {}{}", program, condition);
    for (const std::string& name : option.names) {
      text += name.starts_with("--") ? " -l " + name.substr(2) : " -s " + name.substr(1);
    }
    text += fmt::format("{} -d {}\n", FishValues(option), Quoted(option.meaning));
  }
  return text;
}

}  // namespace

std::string FishCompletion(const std::vector<HelpPage>& pages) {
  const HelpPage& own = pages[0];
  std::string text = fmt::format("# Completion of {} for fish, made from its --help.\n", own.command);
  if (pages.size() == 1) return text + OptionLines(own.command, "", own);
  text += OptionLines(own.command, " -n __fish_use_subcommand", own);
  for (size_t i = 1; i < pages.size(); ++i) {
    const std::string name = pages[i].command.substr(own.command.size() + 1);
    text += fmt::format("complete -c {} -n __fish_use_subcommand -a {} -d {}\n", own.command, name,
                        Quoted(pages[i].Summary()));
    text += OptionLines(own.command, fmt::format(" -n '__fish_seen_subcommand_from {}'", name), pages[i]);
  }
  return text;
}

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

/// Returns the completion of an option's value.
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

}  // namespace plslam::manual
