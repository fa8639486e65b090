// SPDX-License-Identifier: BSD-3-Clause
#include "tools/manual/help_page.h"

#include <algorithm>
#include <regex>
#include <sstream>
#include <stdexcept>

#include <fmt/format.h>

namespace plslam::manual {
namespace {

/// CLI11 prints descriptions at this column, or on a separate line if the name is longer.
constexpr size_t kColumn = 30;

std::string Trim(const std::string& text) {
  const size_t begin = text.find_first_not_of(" \n"), end = text.find_last_not_of(" \n");
  return begin == std::string::npos ? "" : text.substr(begin, end - begin + 1);
}

/// Returns whether `text` ends within brackets, as the bounds of a long name do ("INT in [0 - 9]").
bool EndsInBrackets(const std::string& text) {
  return std::count(text.begin(), text.end(), '[') > std::count(text.begin(), text.end(), ']');
}

std::vector<std::string> Split(const std::string& text, char separator) {
  std::vector<std::string> parts;
  std::istringstream stream(text);
  for (std::string part; std::getline(stream, part, separator);) parts.push_back(Trim(part));
  return parts;
}

/// "  -o,--out DIR" without its meaning.
HelpEntry EntryOf(const std::string& left) {
  HelpEntry entry;
  const std::string text = Trim(left);
  const size_t blank = text.find(' ');
  entry.names = Split(text.substr(0, blank), ',');
  if (blank != std::string::npos) entry.value = Trim(text.substr(blank));
  static const std::regex kChoices(R"(\{([^}]*)\})");
  std::smatch match;
  if (std::regex_search(entry.value, match, kChoices)) entry.choices = Split(match[1], ',');
  return entry;
}

class HelpParser {
 public:
  explicit HelpParser(HelpPage* page) : page_(page) {}

  void Take(const std::string& line) {
    if (in_footer_) {
      page_->footer += line + "\n";
    } else if (line.starts_with("Usage:")) {
      TakeUsage(line);
    } else if (!has_usage_) {
      page_->purpose += line + "\n";
    } else if (line.starts_with("  ")) {
      TakeEntry(line);
    } else if (!line.empty()) {
      TakeHeading(line);
    }
  }

 private:
  void TakeUsage(const std::string& line) {
    has_usage_ = true;
    const size_t bracket = line.find(" [OPTIONS]");
    page_->usage = bracket == std::string::npos ? "" : Trim(line.substr(bracket));
  }

  void TakeHeading(const std::string& line) {
    entries_ = line == "Positionals:"   ? &page_->arguments
               : line == "Options:"     ? &page_->options
               : line == "Subcommands:" ? &page_->commands
                                        : nullptr;
    if (entries_ != nullptr) return;
    in_footer_ = true;
    page_->footer += line + "\n";
  }

  void TakeEntry(const std::string& line) {
    if (entries_ == nullptr)
      throw std::runtime_error(fmt::format("{}: '{}' is not under a heading", page_->command, line));
    const bool continues = line.find_first_not_of(' ') >= kColumn;
    if (continues && entries_->empty()) {
      throw std::runtime_error(fmt::format("{}: '{}' does not belong to an option", page_->command, line));
    }
    if (continues) {
      std::string& meaning = entries_->back().meaning;
      meaning += fmt::format("{}{}", meaning.empty() ? "" : " ", Trim(line));
      return;
    }
    const std::string left = line.substr(0, kColumn);
    const bool has_meaning = line.size() > kColumn && left.back() == ' ' && !EndsInBrackets(left);
    entries_->push_back(EntryOf(has_meaning ? left : line));
    if (has_meaning) entries_->back().meaning = Trim(line.substr(kColumn));
  }

  HelpPage* page_;
  std::vector<HelpEntry>* entries_ = nullptr;
  bool has_usage_ = false;
  bool in_footer_ = false;
};

}  // namespace

std::vector<std::string> HelpPage::CommandNames() const {
  std::vector<std::string> names;
  for (const HelpEntry& entry : commands) names.push_back(entry.names[0]);
  const std::regex named(fmt::format("`{} ([a-z_-]+)[ `]", command));
  for (std::sregex_iterator it(footer.begin(), footer.end(), named), end; it != end; ++it) {
    if (std::find(names.begin(), names.end(), (*it)[1]) == names.end()) names.push_back((*it)[1]);
  }
  return names;
}

HelpPage ParseHelp(const std::string& command, const std::string& text) {
  HelpPage page;
  page.command = command;
  HelpParser parser(&page);
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) parser.Take(line);
  page.purpose = Trim(page.purpose);
  page.footer = Trim(page.footer);
  if (page.purpose.empty() || page.options.empty()) {
    throw std::runtime_error(command + ": --help states no purpose or no options");
  }
  return page;
}

}  // namespace plslam::manual
