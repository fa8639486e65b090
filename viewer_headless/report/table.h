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

}  // namespace plslam
