#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <variant>
#include <vector>

namespace plslam {

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

/// The column of that name; nullptr where there is none.
const Column* FindColumn(const Table& table, const std::string& name);

/// The numbers as little endian bytes, and what they are called in a page: "f32", "i32", "u16", "u8".
std::string LittleEndianBytes(const Column& column);
std::string TypeName(const Column& column);

}  // namespace plslam
