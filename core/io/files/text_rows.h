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
  bool is_first = false;  ///< no row stands before it

  /// The names of the columns of a list with commas, as some tools write them, without #: no number begins with a
  /// letter.
  bool IsCsvHeader() const;

  /// `PATH:LINE: MESSAGE`, thrown as std::runtime_error.
  [[noreturn]] void Fail(const std::string& message) const;
  /// A finite number, or `Fail` with the text that is none.
  double Number(size_t field) const;
  /// A decimal number times 10^`decimals`, rounded to the nearest integer without the detour over a double:
  /// `Scaled(i, 9)` reads seconds as nanoseconds. Knows exponents; `Fail`s where it does not fit.
  int64_t Scaled(size_t field, int decimals) const;
};

/// Calls `use` for each line that is neither empty nor begins with #, its fields separated by commas where the line
/// has one, otherwise by blanks and tabs. Lines may end with CR LF, and the first may begin with a byte order mark.
/// Throws std::runtime_error, with the file and the line, where the file cannot be read, a line has more than 4096
/// characters or the file more than ten million lines.
void ForEachRow(const std::string& path, const std::function<void(const TextRow&)>& use);

}  // namespace plslam
