// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/config/choices.h"
#include "core/files/atomic_file.h"
#include "core/files/notes.h"
#include "core/geometry/se3.h"

namespace plslam {

/// A pose of a trajectory. Its creator defines the frames a and b.
struct TrajectoryPose {
  int64_t t_ns = 0;
  SE3 T_a_b;
};

using Trajectory = std::vector<TrajectoryPose>;

enum class TrajectoryFormat {
  kTum,       ///< `t tx ty tz qx qy qz qw`, seconds
  kKitti,     ///< 12 numbers, the rows of [R t]; no times
  kEuroc,     ///< `t_ns, px, py, pz, qw, qx, qy, qz, ...` (further columns ignored), with a header line; rows with
              ///< commas and times in seconds are `kTum`
  kVslamLab,  ///< `t_ns, px, py, pz, qx, qy, qz, qw`, with a header line; never recognised, only named in the code
};
/// The formats that users can name.
constexpr auto ChoicesOf(TrajectoryFormat) {
  return std::array{Choice{"tum", TrajectoryFormat::kTum}, Choice{"kitti", TrajectoryFormat::kKitti},
                    Choice{"euroc", TrajectoryFormat::kEuroc}};
}

/// Reads a trajectory, its format recognised by its first data line unless given (row_format.h: a header that names its
/// columns decides the order of the quaternion and the unit of time). KITTI files take their times from
/// `times_path` (one second value a line) or, without one, use the frame index as seconds; the other formats contain
/// times and ignore `times_path`.
///
/// Empty lines, lines that begin with # and a header with commas are skipped, and both line endings are supported.
/// Times must increase from row to row and are exact to the nanosecond (further digits are rounded). Quaternions and
/// rotation matrices are normalised when they are within 1 % of a rotation. A file without rows is an empty trajectory.
/// Anything else throws std::runtime_error with file, line and value.
Trajectory ReadTrajectory(const std::string& path, const std::string& times_path = "");
Trajectory ReadTrajectory(const std::string& path, TrajectoryFormat format, const std::string& times_path = "");

/// Treatment of invalid rows, and of rows whose times do not increase.
enum class BadRows { kRefuse, kPassOver };

/// A trajectory with the findings of reading it.
struct TrajectoryFile {
  Trajectory poses;
  /// Format of the file, even if none of its rows is a pose; nullopt: it has no rows, or an unknown format.
  std::optional<TrajectoryFormat> format;
  /// Number of rows, including skipped ones.
  size_t n_rows = 0;
  /// The format assumed for rows with commas as a remark, and the number of skipped rows as a warning, with file, line
  /// and reason of the first.
  Notes notes;
};

/// Reads a trajectory of another program, which may have equal times, or rows of NaN without a measurement. As few rows
/// as possible are skipped. Poses of KITTI have the index of their row as their time. Throws std::runtime_error as
/// `ReadTrajectory` does; with `kPassOver` only if the file cannot be read at all.
TrajectoryFile ReadTrajectoryFile(const std::string& path, std::optional<TrajectoryFormat> format, BadRows bad_rows,
                                  const std::string& times_path = "");

/// Writes a trajectory pose by pose, as an AtomicFile. Times of TUM files have nine decimals, positions nine,
/// quaternions (w >= 0) twelve. Throws std::runtime_error if a pose is not finite or the file cannot be written.
class TrajectoryWriter {
 public:
  TrajectoryWriter(const std::string& path, TrajectoryFormat format);
  void Add(const TrajectoryPose& pose);
  void PutInPlace() { file_.PutInPlace(); }

 private:
  std::string path_;
  TrajectoryFormat format_;
  AtomicFile file_;
};

/// Writes all poses with a TrajectoryWriter.
void WriteTrajectory(const std::string& path, TrajectoryFormat format, const Trajectory& trajectory);

/// Seconds with nine decimals, exactly ("1403636579.763555584").
std::string SecondsText(int64_t t_ns);

/// The largest gap of a ground truth that datasets interpolate over.
inline constexpr int64_t kMaxTruthGap_ns = 150'000'000;
/// Times so near are one moment: files round them, to milliseconds at worst.
inline constexpr int64_t kSameMoment_ns = 1'000'000;

/// Returns the pose at a time between two poses of a trajectory: translation on the straight line, rotation on the
/// great arc. Before the first and after the last pose, and if the two are further apart than `max_gap_ns`, it is the
/// pose of the same moment, or nullopt if there is none: there is no extrapolation. Exactly a pose of the trajectory if
/// the times agree.
std::optional<SE3> InterpolatePose(const Trajectory& trajectory, int64_t t_ns, int64_t max_gap_ns);

}  // namespace plslam
