// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

namespace plslam {

/// The line before the rows of a table of poses that names their columns: "#timestamp [ns],p_RS_R_x [m],...,q_RS_w []",
/// "timestamp,tx,ty,tz,qw,qx,qy,qz".
struct TableHeader {
  int line = 0;  ///< from 1
  size_t n_columns = 0;
  std::string time_name;             ///< of the column with the time, in full
  size_t time = 0;                   ///< index of that column
  std::optional<int> time_decimals;  ///< its unit is 10^this ns: 0, 3, 6 or 9; nullopt: not named
  /// Columns of x, y, z and of x, y, z, w; nullopt unless all are named.
  std::optional<std::array<size_t, 3>> position;
  std::optional<std::array<size_t, 4>> quaternion;
};

/// Returns the last line before the rows that names a quaternion, or else at least eight columns, of which one is a
/// time with its unit. Throws std::runtime_error if it names a column of the pose twice.
std::optional<TableHeader> ReadTableHeader(const std::string& path);

/// The name of a unit of 10^`decimals` ns: "nanoseconds".
std::string_view UnitOfTimeName(int decimals);

/// Returns the unit in which `step`, a number of units, is nearest to the 50 ms of a camera of 20 Hz, as decimals.
int LikelyUnitOfStep(double step);

}  // namespace plslam
