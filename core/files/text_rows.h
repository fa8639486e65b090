// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace plslam {

/// One line of a text file with numbers.
struct TextRow {
  const std::string* path;
  int line;  ///< from 1
  std::vector<std::string_view> fields;
  bool has_commas;        ///< they separate the fields
  bool is_first = false;  ///< no row precedes it

  /// Returns whether the row has the names of the columns of a list with commas, as some tools write them, without #:
  /// no number begins with a letter.
  bool IsCsvHeader() const;

  /// `PATH:LINE: MESSAGE`, thrown as std::runtime_error.
  [[noreturn]] void Fail(const std::string& message) const;
  /// Returns a finite number, or calls `Fail` with the invalid text.
  double Number(size_t field) const;
  /// Returns a decimal number times 10^`decimals`, rounded to the nearest integer without conversion to double:
  /// `Scaled(i, 9)` reads seconds as nanoseconds. Exponents are supported; calls `Fail` if it overflows.
  int64_t Scaled(size_t field, int decimals) const;
};

/// Calls `use` for each line that is neither empty nor begins with #, its fields separated by commas if the line has
/// one, otherwise by blanks and tabs. Lines may end with CR LF, and the first may begin with a byte order mark. Throws
/// std::runtime_error, with the file and the line, if the file cannot be read, a line has more than 4096 characters or
/// the file more than ten million lines.
void ForEachRow(const std::string& path, const std::function<void(const TextRow&)>& use);

}  // namespace plslam
