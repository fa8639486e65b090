// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tools/evaluate/compare/comparison.h"

namespace plslam::evaluate {

/// Returns "1 failed, 2 without ATE" about a group's runs; empty if all are complete.
std::string LackingText(const RunGroup& group);

/// A row of cells for each group, under the names of the columns; columns without any value are left out. Cells of more
/// than one run are "median (worst)"; "-" for unknown values.
struct ComparisonTable {
  std::vector<std::string> columns;
  std::vector<std::vector<std::string>> rows;
};

ComparisonTable TableOf(const std::vector<RunGroup>& groups);

/// For terminals, Markdown, and LaTeX as a tabular.
std::string ComparisonText(const std::vector<RunGroup>& groups);
std::string ComparisonMarkdown(const std::vector<RunGroup>& groups);
std::string ComparisonLatex(const std::vector<RunGroup>& groups);

/// One row for each group and metric: dataset, configuration, runs, failed, metric, n, median, worst, spread.
std::string ComparisonCsv(const std::vector<RunGroup>& groups);

/// All numbers, and those of each run.
nlohmann::ordered_json ComparisonJson(const std::vector<RunGroup>& groups);

}  // namespace plslam::evaluate
