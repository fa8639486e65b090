// SPDX-License-Identifier: BSD-3-Clause
#include "core/io/trajectories/table_header.h"

#include <algorithm>
#include <cctype>
#include <fstream>
#include <stdexcept>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "core/errors/error_text.h"

namespace plslam {
namespace {

constexpr int kMostLines = 100;
constexpr size_t kMostCharacters = 4096;
constexpr size_t kLeastColumns = 8;

/// Words in which headers name units, and their powers of ten of a nanosecond.
constexpr auto kUnits = std::to_array<std::pair<std::string_view, int>>({{"ns", 0},
                                                                         {"nsec", 0},
                                                                         {"nsecs", 0},
                                                                         {"nanosec", 0},
                                                                         {"nanoseconds", 0},
                                                                         {"us", 3},
                                                                         {"usec", 3},
                                                                         {"microseconds", 3},
                                                                         {"ms", 6},
                                                                         {"msec", 6},
                                                                         {"millis", 6},
                                                                         {"milliseconds", 6},
                                                                         {"s", 9},
                                                                         {"sec", 9},
                                                                         {"secs", 9},
                                                                         {"seconds", 9}});
constexpr auto kTimes =
    std::to_array<std::string_view>({"time", "times", "timestamp", "timestamps", "stamp", "ts", "t"});
constexpr auto kPositions = std::to_array<std::string_view>({"p", "t", "pos", "position", "trans", "translation"});
constexpr auto kRotations =
    std::to_array<std::string_view>({"q", "quat", "quaternion", "rot", "rotation", "orientation", "ori"});

template <class List>
bool Contains(const List& list, std::string_view word) {
  return std::find(list.begin(), list.end(), word) != list.end();
}

/// The words of a name, in small letters: "q_RS_w []" has q, rs and w.
std::vector<std::string> WordsOf(std::string_view name) {
  std::vector<std::string> words(1);
  for (const char c : name) {
    if (std::isalnum(static_cast<unsigned char>(c)) != 0) {
      words.back() += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    } else if (!words.back().empty()) {
      words.emplace_back();
    }
  }
  if (words.back().empty()) words.pop_back();
  return words;
}

/// The name without its unit, which is in brackets, and the unit.
std::pair<std::string, std::string> WithoutUnit(std::string_view name) {
  const size_t bracket = name.find_first_of("[(");
  if (bracket == name.npos) return {std::string(name), ""};
  return {std::string(name.substr(0, bracket)), std::string(name.substr(bracket))};
}

std::optional<int> UnitOf(const std::vector<std::string>& words) {
  for (const auto& [name, decimals] : kUnits) {
    if (!words.empty() && words.back() == name) return decimals;
  }
  return std::nullopt;
}

std::vector<std::string> SplitNames(std::string_view line) {
  const bool has_commas = line.find(',') != line.npos;
  std::vector<std::string> names;
  std::string name;
  int depth = 0;  // of brackets, in which a unit may have blanks
  const auto end_name = [&] {
    const size_t first = name.find_first_not_of(" \t\r\"");
    if (has_commas || first != name.npos) names.push_back(first == name.npos ? "" : name.substr(first));
    name.clear();
  };
  for (size_t i = 0; i < line.size(); ++i) {
    const char c = line[i];
    depth += c == '[' || c == '(' ? 1 : c == ']' || c == ')' ? -1 : 0;
    const bool is_blank = c == ' ' || c == '\t';
    const size_t next = line.find_first_not_of(" \t", i);
    const bool unit_follows = is_blank && next != line.npos && (line[next] == '[' || line[next] == '(');
    const bool ends = has_commas ? c == ',' : is_blank && depth <= 0 && !unit_follows;
    if (ends) {
      end_name();
    } else {
      name += c;
    }
  }
  end_name();
  return names;
}

/// A part of a pose: a coordinate of the position (0 to 2), or of the quaternion (3 to 6: x, y, z, w).
std::optional<size_t> PartOf(const std::vector<std::string>& words) {
  constexpr std::string_view kAxes = "xyzw";
  if (words.empty() || words.back().size() > 2) return std::nullopt;
  const std::string& last = words.back();
  const size_t axis = kAxes.find(last.back());
  if (axis == kAxes.npos) return std::nullopt;
  const auto begins_with_one_of = [&](const auto& list) {
    return std::any_of(words.begin(), words.end() - 1, [&](const auto& word) { return Contains(list, word); });
  };
  const bool is_short = last.size() == 2;
  if (is_short ? last[0] == 'q' : begins_with_one_of(kRotations)) return 3 + axis;
  const bool is_position =
      is_short ? last[0] == 't' || last[0] == 'p' : words.size() == 1 || begins_with_one_of(kPositions);
  return is_position && axis < 3 ? std::optional(axis) : std::nullopt;
}

std::optional<TableHeader> HeaderOf(const std::string& path, int line, std::string_view text) {
  const std::vector<std::string> names = SplitNames(text);
  TableHeader header{line, names.size(), "", 0, {}, {}, {}};
  std::array<std::optional<size_t>, 7> parts;
  for (size_t i = 0; i < names.size(); ++i) {
    const auto [name, unit] = WithoutUnit(names[i]);
    const std::vector<std::string> words = WordsOf(name);
    if (header.time_name.empty() &&
        std::any_of(words.begin(), words.end(), [](const auto& word) { return Contains(kTimes, word); }) &&
        !PartOf(words)) {
      header.time = i;
      header.time_name = names[i];
      header.time_decimals = unit.empty() ? UnitOf(words) : UnitOf(WordsOf(unit));
    }
    const std::optional<size_t> part = PartOf(words);
    if (!part) continue;
    if (parts[*part]) {
      // Two positions, say of a marker too, leave the first three; two quaternions leave no order.
      if (*part < 3) continue;
      throw std::runtime_error(
          fmt::format("{}:{}: columns {} and {} ('{}', '{}') are both the {} of a quaternion: keep one", path, line,
                      *parts[*part] + 1, i + 1, Shown(names[*parts[*part]]), Shown(names[i]), "xyzw"[*part - 3]));
    }
    parts[*part] = i;
  }
  if (parts[0] && parts[1] && parts[2]) header.position = {*parts[0], *parts[1], *parts[2]};
  if (parts[3] && parts[4] && parts[5] && parts[6]) header.quaternion = {*parts[3], *parts[4], *parts[5], *parts[6]};
  const bool names_unit = header.time_decimals && names.size() >= kLeastColumns;
  return header.quaternion || names_unit ? std::optional(header) : std::nullopt;
}

}  // namespace

std::optional<TableHeader> ReadTableHeader(const std::string& path) {
  std::ifstream file = OpenInput(path);
  std::optional<TableHeader> found;
  std::string line;
  for (int n = 1; n <= kMostLines && std::getline(file, line) && line.size() <= kMostCharacters; ++n) {
    constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
    std::string_view text = line;
    if (n == 1 && text.starts_with(kByteOrderMark)) text.remove_prefix(kByteOrderMark.size());
    const size_t first = text.find_first_not_of(" \t\r");
    if (first == text.npos) continue;
    const bool is_comment = text[first] == '#';
    const bool is_name = std::isalpha(static_cast<unsigned char>(text[first])) != 0;
    if (!is_comment && !is_name) break;
    text.remove_prefix(is_comment ? text.find_first_not_of("# \t", first) == text.npos
                                        ? text.size()
                                        : text.find_first_not_of("# \t", first)
                                  : first);
    while (!text.empty() && std::isspace(static_cast<unsigned char>(text.back())) != 0) text.remove_suffix(1);
    const std::optional<TableHeader> header = HeaderOf(path, n, text);
    if (header && (header->quaternion || !found || !found->quaternion)) found = header;
    if (!is_comment) break;
  }
  return found;
}

std::string_view UnitOfTimeName(int decimals) {
  return decimals == 0 ? "nanoseconds" : decimals == 3 ? "microseconds" : decimals == 6 ? "milliseconds" : "seconds";
}

int LikelyUnitOfStep(double step) {
  const double unit_ns = 50e6 / step;
  return unit_ns < 30.0 ? 0 : unit_ns < 3e4 ? 3 : unit_ns < 3e7 ? 6 : 9;
}

}  // namespace plslam
