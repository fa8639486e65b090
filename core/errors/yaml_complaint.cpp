// SPDX-License-Identifier: BSD-3-Clause
#include "core/errors/yaml_complaint.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/errors/error_text.h"

namespace plslam {
namespace {

/// Cuts the first line off `text`.
std::string_view TakeLine(std::string_view& text) {
  const size_t end = std::min(text.find('\n'), text.size());
  const std::string_view line = text.substr(0, end);
  text.remove_prefix(std::min(end + 1, text.size()));
  return line;
}

bool IsIndentedByTab(std::string_view line) {
  const size_t first = line.find_first_not_of(" \t");
  return first != std::string_view::npos && line[first] != '#' && line.substr(0, first).find('\t') != line.npos;
}

}  // namespace

std::string YamlComplaint(const std::string& name, std::string_view text, int line, const std::string& what) {
  if (text.find('\0') != std::string_view::npos) return name + ": is no YAML, but binary: " + Shown(text);
  std::string_view rest = text, culprit;
  for (int i = 0; i <= line && !rest.empty(); ++i) {
    culprit = TakeLine(rest);
    if (IsIndentedByTab(culprit)) {
      return fmt::format("{}:{}: is indented by a tab; YAML wants spaces", name, i + 1);
    }
  }
  if (line < 0) return fmt::format("{}: not valid YAML: {}", name, what);
  return fmt::format("{}:{}: not valid YAML: {} ('{}')", name, line + 1, what, Shown(culprit));
}

}  // namespace plslam
