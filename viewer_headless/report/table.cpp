#include "viewer_headless/report/table.h"

#include <algorithm>

namespace plslam {

size_t Rows(const Table& table) {
  if (table.empty()) return 0;
  const size_t n = std::visit([](const auto& values) { return values.size(); }, table.front().values);
  return n / static_cast<size_t>(table.front().width);
}

const Column* FindColumn(const Table& table, const std::string& name) {
  const auto found = std::find_if(table.begin(), table.end(), [&](const Column& c) { return c.name == name; });
  return found == table.end() ? nullptr : &*found;
}

}  // namespace plslam
