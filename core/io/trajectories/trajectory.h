// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/geometry/se3.h"

namespace plslam {

/// A pose of a trajectory. Which frames `T_a_b` joins is said by whoever made it.
struct TrajectoryPose {
  int64_t t_ns = 0;
  SE3 T_a_b;
};

using Trajectory = std::vector<TrajectoryPose>;

enum class TrajectoryFormat {
  kTum,       ///< `t tx ty tz qx qy qz qw`, seconds
  kKitti,     ///< 12 numbers, the rows of [R t]; no times
  kEuroc,     ///< `t_ns, px, py, pz, qw, qx, qy, qz, ...` (further columns ignored), with a header line; rows with
              ///< commas whose times are in seconds are of `kTum`
  kVslamLab,  ///< `t_ns, px, py, pz, qx, qy, qz, qw`, with a header line; never recognised, only named in the code
};

/// Reads a trajectory, its format recognised by its first data line unless named. KITTI files take their times from
/// `times_path` (one second value a line) or, without one, count frames as seconds; the other formats have times of
/// their own and leave `times_path` unread.
///
/// Empty lines, lines that begin with # and the names of columns with commas are passed over, and both ends of line
/// are understood. Times must increase from row to row and are exact to the nanosecond (further digits are rounded).
/// Quaternions and rotation matrices are normalised when they are within 1 % of a rotation. A file without rows is an
/// empty trajectory. Anything else throws std::runtime_error with file, line and value.
Trajectory ReadTrajectory(const std::string& path, const std::string& times_path = "");
Trajectory ReadTrajectory(const std::string& path, TrajectoryFormat format, const std::string& times_path = "");

/// Treatment of rows that are no pose, or whose times do not increase.
enum class BadRows { kRefuse, kPassOver };

/// A trajectory with what was found on the way.
struct TrajectoryFile {
  Trajectory poses;
  /// Format of the file, also where none of its rows is a pose; nullopt: it has no rows, or none of a known format.
  std::optional<TrajectoryFormat> format;
  /// Number of rows, including those that are passed over.
  size_t n_rows = 0;
  /// Notes for the user, in whole sentences: the format assumed for rows with commas, and the number of rows that are
  /// passed over, with file, line and reason of the first.
  std::vector<std::string> notes;
};

/// Reads a trajectory of another program, which may have a time twice, or rows of NaN where nothing was measured. The
/// fewest possible rows are passed over. Poses of KITTI keep the number of their row as their time. Throws
/// std::runtime_error as `ReadTrajectory` does; with `kPassOver` only where the file cannot be read at all.
TrajectoryFile ReadTrajectoryFile(const std::string& path, std::optional<TrajectoryFormat> format, BadRows bad_rows,
                                  const std::string& times_path = "");

/// Writes beside the file and renames, so that a reader never sees half of it. Times of TUM files have nine decimals,
/// positions nine, quaternions (w >= 0) twelve. Throws std::runtime_error where a pose is not finite or the file
/// cannot be written.
void WriteTrajectory(const std::string& path, TrajectoryFormat format, const Trajectory& trajectory);

/// "tum", "kitti" or "euroc"; throws std::runtime_error for any other name.
TrajectoryFormat TrajectoryFormatFromName(std::string_view name);

/// Seconds with nine decimals, exactly ("1403636579.763555584").
std::string SecondsText(int64_t t_ns);

/// The largest gap of a ground truth that datasets interpolate over.
inline constexpr int64_t kMaxTruthGap_ns = 150'000'000;
/// Times so near are one moment: files round them, to milliseconds at worst.
inline constexpr int64_t kSameMoment_ns = 1'000'000;

/// Pose at a time between two poses of a trajectory: translation on the straight line, rotation on the great arc.
/// Before the first and after the last pose, and where the two are further apart than `max_gap_ns`, it is that of the
/// same moment, and nullopt where there is none: nothing is extrapolated. Exactly the pose itself where the times
/// agree.
std::optional<SE3> InterpolatePose(const Trajectory& trajectory, int64_t t_ns, int64_t max_gap_ns);

}  // namespace plslam
