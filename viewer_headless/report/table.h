// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace plslam::viewer {

/// Numbers of one kind, `width` of them in each row.
struct Column {
  std::string name;
  int width = 1;
  std::variant<std::vector<float>, std::vector<int32_t>, std::vector<uint16_t>, std::vector<uint8_t>> values;
};

/// Columns with the same number of rows.
using Table = std::vector<Column>;

/// Rows of the first column; 0 without columns.
size_t Rows(const Table& table);

/// Returns the column of that name; nullptr if there is none.
const Column* FindColumn(const Table& table, const std::string& name);

/// Returns the numbers as little endian bytes, and their type name in a page: "f32", "i32", "u16", "u8".
std::string LittleEndianBytes(const Column& column);
std::string TypeName(const Column& column);

/// Returns a frame or keyframe id as a column stores it; -1: none.
int32_t Clamp32(int64_t value);

/// Appends the numbers of a vector.
void Append(const Eigen::Ref<const Eigen::VectorXd>& vector, std::vector<float>& values);

/// Appends a row of `width` numbers: NaN for numbers that `row` does not have.
void AppendRow(const std::vector<float>& row, size_t width, std::vector<float>& values);

/// Drops the second, the fourth, the sixth, ... value.
template <class T>
void KeepEverySecond(std::vector<T>& values) {
  for (size_t i = 1; 2 * i < values.size(); ++i) values[i] = std::move(values[2 * i]);
  values.resize((values.size() + 1) / 2);
}

}  // namespace plslam::viewer
