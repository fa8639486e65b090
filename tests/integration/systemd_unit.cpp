// SPDX-License-Identifier: BSD-3-Clause
#include "tests/integration/systemd_unit.h"

#include <fmt/format.h>

#include <fstream>
#include <map>
#include <sstream>
#include <stdexcept>
#include <utility>

namespace plslam::test {
namespace {

/// The words of a line; double quotes join several.
std::vector<std::string> Split(const std::string& line) {
  std::vector<std::string> words;
  bool quoted = false, in_word = false;
  for (const char c : line) {
    if (c == '"') {
      quoted = !quoted;
    } else if (c == ' ' && !quoted) {
      in_word = false;
      continue;
    }
    if (!std::exchange(in_word, true)) words.emplace_back();
    if (c != '"') words.back() += c;
  }
  return words;
}

/// Replaces the specifiers of one unit.
class Specifiers {
 public:
  Specifiers(const std::filesystem::path& file, const std::string& instance, const SystemdFolders& folders)
      : etc_(folders.etc) {
    std::string unit = file.filename().string();
    if (const size_t at = unit.find('@'); at != std::string::npos) unit.insert(at + 1, instance);
    values_ = {
        {'i', instance}, {'n', unit}, {'S', folders.state.string()}, {'t', folders.runtime.string()}, {'%', "%"}};
  }

  std::string Replaced(const std::string& word) const {
    std::string text;
    for (size_t i = 0; i < word.size(); ++i) {
      if (word[i] != '%') {
        text += word[i];
        continue;
      }
      const auto value = ++i < word.size() ? values_.find(word[i]) : values_.end();
      if (value == values_.end()) throw std::runtime_error(fmt::format("unknown specifier in \"{}\"", word));
      text += value->second;
    }
    const std::string etc = "/etc/";
    return text.starts_with(etc) ? (etc_ / text.substr(etc.size())).string() : text;
  }

  std::vector<std::string> Replaced(std::vector<std::string> words) const {
    for (std::string& word : words) word = Replaced(word);
    return words;
  }

  /// In commands "$$" is a dollar sign. Variables in them are not supported here.
  SystemdUnit::Command CommandOf(const std::string& line) const {
    SystemdUnit::Command command;
    command.may_fail = line.starts_with('-');
    command.words = Replaced(Split(line.substr(command.may_fail ? 1 : 0)));
    if (command.words.empty() || !command.words[0].starts_with('/'))
      throw std::runtime_error(fmt::format("\"{}\" does not begin with a path", line));
    for (std::string& word : command.words) {
      for (size_t at = word.find('$'); at != std::string::npos; at = word.find('$', at + 1)) {
        if (word.compare(at, 2, "$$") != 0) throw std::runtime_error(fmt::format("variable in \"{}\"", word));
        word.erase(at, 1);
      }
    }
    return command;
  }

 private:
  std::filesystem::path etc_;
  std::map<char, std::string> values_;
};

void Set(const std::string& key, const std::string& value, const Specifiers& specifiers, SystemdUnit* unit) {
  if (key == "ExecStartPre") unit->start_pre.push_back(specifiers.CommandOf(value));
  if (key == "ExecStart") unit->start = specifiers.CommandOf(value);
  if (key == "StateDirectory") unit->state_directory = specifiers.Replaced(value);
  if (key == "RuntimeDirectory") unit->runtime_directory = specifiers.Replaced(value);
  if (key == "WorkingDirectory") unit->working_directory = specifiers.Replaced(value);
  if (key == "Nice") unit->nice = std::stoi(value);
  if (key == "Environment") {
    const std::vector<std::string> more = specifiers.Replaced(Split(value));
    unit->environment.insert(unit->environment.end(), more.begin(), more.end());
  }
}

}  // namespace

SystemdUnit ReadSystemdUnit(const std::filesystem::path& file, const std::string& instance,
                            const SystemdFolders& folders) {
  std::ifstream stream(file);
  SystemdUnit unit;
  const Specifiers specifiers(file, instance, folders);
  try {
    for (std::string line; std::getline(stream, line);) {
      const size_t equal = line.find('=');
      if (line.starts_with('#') || equal == std::string::npos) continue;
      Set(line.substr(0, equal), line.substr(equal + 1), specifiers, &unit);
    }
    if (unit.start.words.empty()) throw std::runtime_error("no ExecStart");
  } catch (const std::exception& error) {
    throw std::runtime_error(fmt::format("{}: {}", file.string(), error.what()));
  }
  return unit;
}

}  // namespace plslam::test
