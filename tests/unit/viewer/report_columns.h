// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "viewer_headless/report/table.h"

namespace plslam::viewer {

/// Returns the numbers of the column of that name; empty if there is no such column, or of another type.
template <class Number>
std::vector<Number> Numbers(const Table& table, const std::string& name) {
  const Column* column = FindColumn(table, name);
  if (column == nullptr || !std::holds_alternative<std::vector<Number>>(column->values)) return {};
  return std::get<std::vector<Number>>(column->values);
}

}  // namespace plslam::viewer
