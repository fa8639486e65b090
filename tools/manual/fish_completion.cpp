// SPDX-License-Identifier: BSD-3-Clause
#include "tools/manual/completion.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace plslam {
namespace {

std::string Quoted(const std::string& text) {
  std::string out = "'";
  for (const char c : text) {
    if (c == '\'' || c == '\\') out += '\\';
    out += c == '\n' ? ' ' : c;
  }
  return out + "'";
}

/// What completes the value of an option: required, and words of a list, folders or files.
std::string ValuesOf(const HelpEntry& option) {
  if (!option.TakesValue()) return "";
  if (!option.choices.empty())
    return fmt::format(" -x -a {}", Quoted(fmt::format("{}", fmt::join(option.choices, " "))));
  return option.value.starts_with("DIR") ? " -x -a '(__fish_complete_directories)'" : " -r -F";
}

/// A line for each option of a page; `condition` says when it is one.
std::string OptionLines(const std::string& program, const std::string& condition, const HelpPage& page) {
  std::string text;
  for (const HelpEntry& option : page.options) {
    text += fmt::format("complete -c {}{}", program, condition);
    for (const std::string& name : option.names) {
      text += name.starts_with("--") ? " -l " + name.substr(2) : " -s " + name.substr(1);
    }
    text += fmt::format("{} -d {}\n", ValuesOf(option), Quoted(option.meaning));
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

}  // namespace plslam
