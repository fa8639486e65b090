// SPDX-License-Identifier: BSD-3-Clause
#include "viewer_headless/report/table.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <limits>

namespace plslam::viewer {

size_t Rows(const Table& table) {
  if (table.empty()) return 0;
  const size_t n = std::visit([](const auto& values) { return values.size(); }, table.front().values);
  return n / static_cast<size_t>(table.front().width);
}

const Column* FindColumn(const Table& table, const std::string& name) {
  const auto found = std::find_if(table.begin(), table.end(), [&](const Column& c) { return c.name == name; });
  return found == table.end() ? nullptr : &*found;
}

std::string LittleEndianBytes(const Column& column) {
  static_assert(std::endian::native == std::endian::little, "the page reads little-endian values");
  return std::visit(
      [](const auto& values) {
        std::string bytes(values.size() * sizeof(values[0]), '\0');
        if (!values.empty()) std::memcpy(bytes.data(), values.data(), bytes.size());
        return bytes;
      },
      column.values);
}

std::string TypeName(const Column& column) {
  if (std::holds_alternative<std::vector<float>>(column.values)) return "f32";
  if (std::holds_alternative<std::vector<int32_t>>(column.values)) return "i32";
  return std::holds_alternative<std::vector<uint16_t>>(column.values) ? "u16" : "u8";
}

int32_t Clamp32(int64_t value) { return static_cast<int32_t>(std::clamp<int64_t>(value, -1, 2'000'000'000)); }

void Append(const Eigen::Ref<const Eigen::VectorXd>& vector, std::vector<float>& values) {
  for (const double value : vector) values.push_back(static_cast<float>(value));
}

void AppendRow(const std::vector<float>& row, size_t width, std::vector<float>& values) {
  for (size_t i = 0; i < width; ++i) {
    values.push_back(i < row.size() ? row[i] : std::numeric_limits<float>::quiet_NaN());
  }
}

}  // namespace plslam::viewer
