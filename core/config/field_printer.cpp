// SPDX-License-Identifier: BSD-3-Clause
#include <array>
#include <charconv>
#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <yaml-cpp/yaml.h>

#include "core/config/config.h"

namespace plslam {
namespace {

/// Shortest decimal that reads back as the same number.
std::string Print(double value) { return fmt::format("{}", value); }
std::string Print(int value) { return fmt::format("{}", value); }
std::string Print(int64_t value) { return fmt::format("{}", value); }
std::string Print(bool value) { return value ? "true" : "false"; }
std::string Print(const std::string& value) {
  YAML::Emitter emitter;
  emitter << YAML::DoubleQuoted << value;
  return emitter.c_str();
}
std::string Print(const std::vector<double>& values) { return fmt::format("[{}]", fmt::join(values, ", ")); }
std::string Print(const NamedValue& value) { return Print(value.name()); }
template <class T>
std::string Print(T* value) {
  return Print(*value);
}

std::string PrintValue(const Field& field) {
  return std::visit([](const auto& value) { return Print(value); }, field.value);
}

/// "0 to 100", "at least 3", "one of a, b", or empty.
std::string PrintLimits(const Field& field, const char* separator) {
  if (!field.choices.empty()) return fmt::format("one of {}", fmt::join(field.choices, separator));
  const bool has_min = std::isfinite(field.bounds.min), has_max = std::isfinite(field.bounds.max);
  if (has_min && has_max) return fmt::format("{} to {}", field.bounds.min, field.bounds.max);
  if (has_min) return fmt::format("at least {}", field.bounds.min);
  if (has_max) return fmt::format("at most {}", field.bounds.max);
  return "";
}

std::vector<std::string> SplitKey(const std::string& key) {
  std::vector<std::string> parts;
  size_t start = 0;
  for (size_t dot = key.find('.'); dot != std::string::npos; dot = key.find('.', start)) {
    parts.push_back(key.substr(start, dot - start));
    start = dot + 1;
  }
  parts.push_back(key.substr(start));
  return parts;
}

}  // namespace

std::string FieldsToYaml(const std::string& section, const std::vector<Field>& fields, bool comments) {
  std::string yaml = section + ":\n";
  std::vector<std::string> open;
  for (const Field& field : fields) {
    std::vector<std::string> parts = SplitKey(field.key);
    const std::string name = parts.back();
    parts.pop_back();
    size_t common = 0;
    while (common < std::min(open.size(), parts.size()) && open[common] == parts[common]) ++common;
    for (size_t depth = common; depth < parts.size(); ++depth) {
      yaml += std::string(2 * depth + 2, ' ') + parts[depth] + ":\n";
    }
    const std::string indent(2 * parts.size() + 2, ' ');
    const std::string limits = PrintLimits(field, ", ");
    if (comments) yaml += fmt::format("{}# {}{}\n", indent, field.help, limits.empty() ? "" : " (" + limits + ")");
    yaml += fmt::format("{}{}: {}\n", indent, name, PrintValue(field));
    open = std::move(parts);
  }
  return yaml;
}

std::string FieldsToMarkdown(const std::string& section, const std::vector<Field>& fields) {
  std::string table = "| key | default | allowed | meaning |\n|---|---|---|---|\n";
  for (const Field& field : fields) {
    table += fmt::format("| `{}.{}` | `{}` | {} | {} |\n", section, field.key, PrintValue(field),
                         PrintLimits(field, ", "), field.help);
  }
  return table;
}

}  // namespace plslam
