// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

#include "core/files/notes.h"
#include "core/io/trajectories/trajectory.h"

namespace plslam {

/// The year 2115; the difference of two times within it fits 64 bits.
inline constexpr int64_t kMaxTime_ns = 4'600'000'000LL * 1'000'000'000;

/// Where a row of a trajectory has its numbers. Formats whose rows may be longer have further columns, which are
/// ignored.
struct RowLayout {
  const char* name;
  TrajectoryFormat format;
  int time_decimals;                 ///< the unit of time is 10^this ns
  std::array<size_t, 4> quaternion;  ///< x, y, z, w
  bool may_be_longer = false;
  size_t n_fields = 8;  ///< at least
  size_t time = 0;
  std::array<size_t, 3> position{1, 2, 3};
};

/// Format of the rows of a file.
struct RowFormat {
  std::optional<RowLayout> layout;  ///< nullopt: of KITTI, the rows of [R t]
  int header_line = 0;              ///< the line that names the columns; 0: none
};

/// Finds the format of a file: `format`, or that of its first row. A header that names columns of quaternions, or the
/// unit of time, has the last word on both. Without it, the unit of rows with commas follows from the steps between
/// times: seconds are TUM's, nanoseconds EuRoC's; other units have no order of the quaternion, and throw
/// std::runtime_error, as does a header that the times contradict. Returns nullopt if there are no rows. `notes`
/// reports what was assumed.
std::optional<RowFormat> FindRowFormat(const std::string& path, std::optional<TrajectoryFormat> format, Notes* notes);

}  // namespace plslam
