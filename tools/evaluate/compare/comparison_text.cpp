// SPDX-License-Identifier: BSD-3-Clause
#include "tools/evaluate/compare/comparison_text.h"

#include <fmt/format.h>

#include <algorithm>

namespace plslam::evaluate {
namespace {

constexpr const char* kNothing = "-";

std::string Number(double value, int digits) { return fmt::format("{:.{}f}", value, digits); }

std::string Cell(const Spread& spread, const Metric& metric) {
  if (spread.n == 0) return kNothing;
  const std::string median = Number(spread.median, metric.digits);
  return spread.n == 1 ? median : fmt::format("{} ({})", median, Number(spread.worst, metric.digits));
}

std::string Runs(const RunGroup& group) {
  const std::string lacking = LackingText(group);
  return fmt::format("{}{}", group.runs.size(), lacking.empty() ? "" : " (" + lacking + ")");
}

template <class Escape>
std::string Joined(const std::vector<std::string>& cells, const char* between, const Escape& escape) {
  std::string row;
  for (size_t i = 0; i < cells.size(); ++i) row += (i == 0 ? "" : between) + escape(cells[i]);
  return row;
}

std::string EscapedForLatex(const std::string& text) {
  std::string escaped;
  for (const char c : text) {
    if (std::string_view("&%$#_{}").find(c) != std::string_view::npos) escaped += '\\';
    escaped += c == '~' || c == '^' || c == '\\' ? '-' : c;
  }
  return escaped;
}

std::string EscapedForMarkdown(const std::string& text) {
  std::string escaped;
  for (const char c : text) escaped += c == '|' ? '/' : c;
  return escaped;
}

std::string EscapedForCsv(const std::string& text) {
  if (text.find_first_of(",\"\n") == std::string::npos) return text;
  std::string escaped = "\"";
  for (const char c : text) escaped += c == '"' ? std::string("\"\"") : std::string(1, c);
  return escaped + '"';
}

nlohmann::ordered_json RunJson(const RunRecord& run) {
  nlohmann::ordered_json json = {{"folder", run.folder}, {"completed", run.completed}};
  if (!run.completed) json["reason"] = run.reason;
  for (size_t i = 0; i < Metrics().size(); ++i) {
    json[Metrics()[i].key] = run.values[i] ? nlohmann::ordered_json(*run.values[i]) : nlohmann::ordered_json();
  }
  return json;
}

}  // namespace

std::string LackingText(const RunGroup& group) {
  std::string text = group.failed > 0 ? fmt::format("{} failed", group.failed) : "";
  if (group.untracked > 0) text += fmt::format("{}{} without ATE", text.empty() ? "" : ", ", group.untracked);
  return text;
}

ComparisonTable TableOf(const std::vector<RunGroup>& groups) {
  ComparisonTable table;
  table.columns = {"dataset", "configuration", "runs"};
  std::vector<const RunGroup*> all;
  all.reserve(groups.size());
  for (const RunGroup& group : groups) all.push_back(&group);
  const std::vector<size_t> known = KnownMetrics(all);
  for (const size_t i : known) table.columns.push_back(NameWithUnit(Metrics()[i]));
  for (const RunGroup& group : groups) {
    std::vector<std::string> row{group.dataset, group.label, Runs(group)};
    for (const size_t i : known) row.push_back(Cell(group.metrics[i], Metrics()[i]));
    table.rows.push_back(std::move(row));
  }
  return table;
}

/// Turned: a row for each metric, since terminals are narrow.
std::string ComparisonText(const std::vector<RunGroup>& groups) {
  const ComparisonTable table = TableOf(groups);
  std::string text;
  for (size_t group = 0; group < table.rows.size(); ++group) {
    const std::vector<std::string>& row = table.rows[group];
    const bool same = group > 0 && table.rows[group - 1][0] == row[0];
    if (!same) text += fmt::format("{}{}\n", group == 0 ? "" : "\n", row[0]);
    text += fmt::format("  {}, {} run{}{}\n", row[1], row[2], row[2] == "1" ? "" : "s",
                        groups[group].runs.size() > 1 ? ": median (worst), spread" : "");
    for (size_t column = 3; column < row.size(); ++column) {
      if (row[column] == kNothing) continue;
      text += fmt::format("    {:<32} {:>22}", table.columns[column], row[column]);
      const auto metric = std::find_if(Metrics().begin(), Metrics().end(),
                                       [&](const Metric& m) { return NameWithUnit(m) == table.columns[column]; });
      const Spread& spread = groups[group].metrics[static_cast<size_t>(metric - Metrics().begin())];
      if (spread.n > 1) text += fmt::format(" {:>12}", Number(spread.spread, metric->digits));
      text += '\n';
    }
  }
  return text;
}

std::string ComparisonMarkdown(const std::vector<RunGroup>& groups) {
  const ComparisonTable table = TableOf(groups);
  std::string text = "| " + Joined(table.columns, " | ", EscapedForMarkdown) + " |\n|";
  for (size_t i = 0; i < table.columns.size(); ++i) text += i < 2 ? "---|" : "--:|";
  text += '\n';
  for (const auto& row : table.rows) text += "| " + Joined(row, " | ", EscapedForMarkdown) + " |\n";
  return text;
}

std::string ComparisonLatex(const std::vector<RunGroup>& groups) {
  const ComparisonTable table = TableOf(groups);
  std::string text = "\\begin{tabular}{ll|" + std::string(table.columns.size() - 2, 'r') + "}\n";
  text += Joined(table.columns, " & ", EscapedForLatex) + " \\\\\n\\hline\\hline\n";
  for (const auto& row : table.rows) text += Joined(row, " & ", EscapedForLatex) + " \\\\\n";
  return text + "\\end{tabular}\n";
}

std::string ComparisonCsv(const std::vector<RunGroup>& groups) {
  std::string text = "dataset,configuration,runs,failed,metric,n,median,worst,spread\n";
  for (const RunGroup& group : groups) {
    for (size_t i = 0; i < Metrics().size(); ++i) {
      const Spread& s = group.metrics[i];
      if (s.n == 0) continue;
      text += fmt::format("{},{},{},{},{},{},{:.9g},{:.9g},{:.9g}\n", EscapedForCsv(group.dataset),
                          EscapedForCsv(group.label), group.runs.size(), group.failed, Metrics()[i].key, s.n,
                          s.median, s.worst, s.spread);
    }
  }
  return text;
}

nlohmann::ordered_json ComparisonJson(const std::vector<RunGroup>& groups) {
  nlohmann::ordered_json json = nlohmann::ordered_json::array();
  for (const RunGroup& group : groups) {
    nlohmann::ordered_json metrics = nlohmann::ordered_json::object(), runs = nlohmann::ordered_json::array();
    for (size_t i = 0; i < Metrics().size(); ++i) {
      const Spread& s = group.metrics[i];
      if (s.n == 0) continue;
      metrics[Metrics()[i].key] = {{"n", s.n}, {"median", s.median}, {"worst", s.worst}, {"spread", s.spread}};
    }
    for (const RunRecord& run : group.runs) runs.push_back(RunJson(run));
    json.push_back({{"dataset", group.dataset},
                    {"configuration", group.label},
                    {"failed", group.failed},
                    {"without_ate", group.untracked},
                    {"metrics", std::move(metrics)},
                    {"runs", std::move(runs)}});
  }
  return json;
}

}  // namespace plslam::evaluate
