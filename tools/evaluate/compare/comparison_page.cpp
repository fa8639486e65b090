// SPDX-License-Identifier: BSD-3-Clause
#include "tools/evaluate/compare/comparison_page.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/errors/error_text.h"
#include "tools/evaluate/compare/comparison_figures.h"
#include "tools/evaluate/compare/comparison_text.h"

namespace plslam::evaluate {
namespace {

constexpr const char* kHead = R"(<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><title>Comparison of runs</title>
<meta name="viewport" content="width=device-width, initial-scale=1">
<style>
body { font: 15px/1.45 system-ui, sans-serif; color: #222; max-width: 1200px; margin: 2em auto; padding: 0 1em; }
table { border-collapse: collapse; margin: 0.6em 0 1.4em; font-variant-numeric: tabular-nums; }
th, td { padding: 0.25em 0.7em; border-bottom: 1px solid #ddd; text-align: right; }
th { border-bottom: 2px solid #888; }
th:first-child, td:first-child { text-align: left; }
td small { color: #777; display: block; }
.best { font-weight: 700; }
.failed { color: #b00020; }
.figures { display: flex; flex-wrap: wrap; gap: 1.2em; align-items: flex-start; }
.figures svg { width: 350px; height: auto; border: 1px solid #eee; }
.scroll { overflow-x: auto; }
h2 { margin-top: 1.8em; overflow-wrap: anywhere; }
</style></head><body>
<h1>Comparison of runs</h1>
<p>Medians of the runs of each configuration; below them the worst and the spread (largest less smallest). The best median of
each column is bold. Runs that were not completed count as failed and are in no figure.</p>
)";

using Groups = std::vector<const RunGroup*>;

std::string HeadRow(const std::string& first, const std::vector<size_t>& metrics) {
  std::string row = "<tr><th>" + first + "</th>";
  for (const size_t i : metrics) {
    const Metric& metric = Metrics()[i];
    const std::string unit = metric.unit.empty() ? "" : "<br><small>" + InHtml(metric.unit) + "</small>";
    row += "<th>" + InHtml(metric.name) + unit + "</th>";
  }
  return row + "</tr>\n";
}

bool IsBest(const Groups& groups, const RunGroup& group, size_t metric) {
  if (groups.size() < 2 || !Metrics()[metric].has_best) return false;
  const double sign = Metrics()[metric].larger_is_better ? -1.0 : 1.0;
  return std::none_of(groups.begin(), groups.end(), [&](const RunGroup* other) {
    return other->metrics[metric].n > 0 && sign * other->metrics[metric].median < sign * group.metrics[metric].median;
  });
}

std::string Cell(const Groups& groups, const RunGroup& group, size_t metric) {
  const Spread& s = group.metrics[metric];
  if (s.n == 0) return "<td>-</td>";
  const int digits = Metrics()[metric].digits;
  std::string cell = IsBest(groups, group, metric) ? "<td class=\"best\">" : "<td>";
  cell += fmt::format("{:.{}f}", s.median, digits);
  if (s.n > 1)
    cell +=
        fmt::format("<small>worst {:.{}f}</small><small>spread {:.{}f}</small>", s.worst, digits, s.spread, digits);
  return cell + "</td>";
}

std::string GroupTable(const Groups& groups) {
  const std::vector<size_t> metrics = KnownMetrics(groups);
  std::string table = "<div class=\"scroll\"><table>\n" + HeadRow("configuration", metrics);
  for (const RunGroup* group : groups) {
    const std::string lacking = LackingText(*group);
    table += fmt::format("<tr><td>{}<small>{} run{}{}</small></td>", InHtml(group->label), group->runs.size(),
                         group->runs.size() == 1 ? "" : "s",
                         lacking.empty() ? "" : fmt::format(", <span class=\"failed\">{}</span>", lacking));
    for (const size_t i : metrics) table += Cell(groups, *group, i);
    table += "</tr>\n";
  }
  return table + "</table></div>\n";
}

/// `dataset` counts the datasets of the page.
std::string FiguresOf(const Groups& groups, int dataset) {
  std::string html = "<div class=\"figures\">\n";
  for (const NamedDrawing& figure : ComparisonFigures(groups)) {
    // All ids of a page are one set, and an element has no XML declaration.
    const std::string svg = ToSvg(figure.drawing, fmt::format("d{}_{}_", dataset, figure.name));
    html += fmt::format("<svg role=\"img\" aria-label=\"{}\" {}", figure.name, svg.substr(svg.find("<svg ") + 5));
  }
  return html + "</div>\n";
}

std::string RunRow(const RunRecord& run, const std::vector<size_t>& metrics) {
  std::string row = "<tr><td>" + InHtml(run.folder);
  if (run.completed && run.untracked) row += "<small class=\"failed\">no pose with a true pose</small>";
  if (!run.completed) row += "<small class=\"failed\">" + InHtml(run.reason) + "</small>";
  row += "</td>";
  for (const size_t i : metrics) {
    row += run.values[i] ? fmt::format("<td>{:.{}f}</td>", *run.values[i], Metrics()[i].digits) : "<td>-</td>";
  }
  return row + "</tr>\n";
}

std::string RunsOf(const Groups& groups) {
  const std::vector<size_t> metrics = KnownMetrics(groups);
  std::string html = "<details><summary>Each run</summary><div class=\"scroll\"><table>\n" + HeadRow("run", metrics);
  for (const RunGroup* group : groups) {
    for (const RunRecord& run : group->runs) html += RunRow(run, metrics);
  }
  return html + "</table></div></details>\n";
}

/// Returns the table of the options that differ between groups: a row for each option, a column for each group.
std::string OptionTable(const Groups& groups) {
  std::vector<const RunRecord*> firsts;
  for (const RunGroup* group : groups) firsts.push_back(&group->runs.front());
  std::string rows;
  for (const std::string& name : DifferingOptions(firsts)) {
    rows += "<tr><td>" + InHtml(name) + "</td>";
    for (const RunRecord* run : firsts) rows += "<td>" + InHtml(ValueOf(*run, name)) + "</td>";
    rows += "</tr>\n";
  }
  if (rows.empty()) return "";
  std::string head = "<tr><th>option</th>";
  for (const RunGroup* group : groups) head += "<th>" + InHtml(group->label) + "</th>";
  return "<details><summary>Options that differ</summary><div class=\"scroll\"><table>\n" + head + "</tr>\n" + rows +
         "</table></div></details>\n";
}

}  // namespace

std::string ComparisonPage(const std::vector<RunGroup>& groups, const std::string& map_link) {
  std::string html = kHead;
  if (!map_link.empty()) {
    html += fmt::format("<p><a href=\"{}\">Paths and landmarks in one map</a></p>\n", InHtml(map_link));
  }
  int dataset = 0;
  for (size_t i = 0; i < groups.size(); ++dataset) {
    Groups of_dataset;
    while (i < groups.size() && (of_dataset.empty() || groups[i].dataset == of_dataset.front()->dataset)) {
      of_dataset.push_back(&groups[i++]);
    }
    html += "<h2>" + InHtml(of_dataset.front()->dataset) + "</h2>\n" + GroupTable(of_dataset) +
            FiguresOf(of_dataset, dataset) + RunsOf(of_dataset) + OptionTable(of_dataset);
  }
  return html + "</body></html>\n";
}

}  // namespace plslam::evaluate
