// SPDX-License-Identifier: BSD-3-Clause
#include "core/io/trajectories/trajectory.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>
#include <stdexcept>

#include <fmt/format.h>

#include "core/io/files/atomic_file.h"
#include "core/io/files/text_rows.h"

namespace plslam {
namespace {

// How far a quaternion's norm or a matrix product R R^T may be from 1: files are rounded to five digits and more.
constexpr double kRotationTolerance = 0.01;
constexpr int64_t kNsPerS = 1'000'000'000;
// The year 2115; the difference of two times within it fits 64 bits.
constexpr int64_t kMaxTime_ns = 4'600'000'000 * kNsPerS;

// 25 times round the Earth. What is further away is a number in another column or of a solver that diverged, of which
// errors would be infinite.
constexpr double kMaxPosition_m = 1e9;

void RequireFields(const TextRow& row, size_t n, const char* format) {
  if (row.fields.size() != n) {
    row.Fail(fmt::format("{} numbers, but a row of the {} format has {}", row.fields.size(), format, n));
  }
}

Eigen::Vector3d Position(const TextRow& row, size_t first) {
  return {row.Number(first), row.Number(first + 1), row.Number(first + 2)};
}

SE3 UnitPose(const TextRow& row, const Eigen::Quaterniond& q, const Eigen::Vector3d& t) {
  if (!(std::abs(q.norm() - 1.0) <= kRotationTolerance)) {
    row.Fail(fmt::format("the quaternion has norm {:.6g}, not 1", q.norm()));
  }
  return {q, t};
}

TrajectoryPose ParseTum(const TextRow& row) {
  RequireFields(row, 8, "TUM");
  const int64_t t_ns = row.Scaled(0, 9);
  const Eigen::Quaterniond q(row.Number(7), row.Number(4), row.Number(5), row.Number(6));
  return {t_ns, UnitPose(row, q, Position(row, 1))};
}

TrajectoryPose ParseVslamLab(const TextRow& row) {
  RequireFields(row, 8, "VSLAM-LAB");
  const int64_t t_ns = row.Scaled(0, 0);
  const Eigen::Quaterniond q(row.Number(7), row.Number(4), row.Number(5), row.Number(6));
  return {t_ns, UnitPose(row, q, Position(row, 1))};
}

TrajectoryPose ParseEuroc(const TextRow& row) {
  if (row.fields.size() < 8) {
    row.Fail(fmt::format("{} columns, but a row of the EuRoC format has at least 8", row.fields.size()));
  }
  const int64_t t_ns = row.Scaled(0, 0);
  const Eigen::Quaterniond q(row.Number(4), row.Number(5), row.Number(6), row.Number(7));
  return {t_ns, UnitPose(row, q, Position(row, 1))};
}

SE3 ParseKitti(const TextRow& row) {
  RequireFields(row, 12, "KITTI");
  Eigen::Matrix<double, 3, 4> m;
  for (int i = 0; i < 12; ++i) m(i / 4, i % 4) = row.Number(static_cast<size_t>(i));
  const Eigen::Matrix3d R = m.leftCols<3>();
  const double error = (R * R.transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
  if (!(error <= kRotationTolerance) || R.determinant() < 0.0) {
    row.Fail(fmt::format("the matrix is no rotation (determinant {:.6g}, off by {:.3g})", R.determinant(), error));
  }
  return {R, m.col(3)};
}

TrajectoryFormat Recognise(const TextRow& row) {
  if (row.has_commas) return TrajectoryFormat::kEuroc;
  if (row.fields.size() == 12) return TrajectoryFormat::kKitti;
  if (row.fields.size() == 8) return TrajectoryFormat::kTum;
  row.Fail(fmt::format("{} numbers fit none of the formats TUM (8), KITTI (12) and EuRoC (8 or more, with commas)",
                       row.fields.size()));
}

void RequireTimeInRange(const TextRow& row, int64_t t_ns) {
  if (t_ns > kMaxTime_ns || t_ns < -kMaxTime_ns) row.Fail(fmt::format("time {} ns is beyond the year 2115", t_ns));
}

void Append(const TextRow& row, const TrajectoryPose& pose, Trajectory& trajectory) {
  RequireTimeInRange(row, pose.t_ns);
  if (!trajectory.empty() && pose.t_ns <= trajectory.back().t_ns) {
    row.Fail(fmt::format("time {} ns is not after the {} ns of the row before", pose.t_ns, trajectory.back().t_ns));
  }
  const double distance_m = pose.T_a_b.translation().stableNorm();
  if (!(distance_m <= kMaxPosition_m)) {
    row.Fail(fmt::format("the position is {:.3g} m from the origin, more than {:g} m", distance_m, kMaxPosition_m));
  }
  trajectory.push_back(pose);
}

TrajectoryPose ParseRow(const TextRow& row, TrajectoryFormat format, int64_t index) {
  if (format == TrajectoryFormat::kTum) return ParseTum(row);
  if (format == TrajectoryFormat::kEuroc) return ParseEuroc(row);
  if (format == TrajectoryFormat::kVslamLab) return ParseVslamLab(row);
  return {index * kNsPerS, ParseKitti(row)};
}

void ApplyTimes(const std::string& path, const std::string& times_path, Trajectory& trajectory) {
  size_t n = 0;
  ForEachRow(times_path, [&](const TextRow& row) {
    RequireFields(row, 1, "times");
    const int64_t t_ns = row.Scaled(0, 9);
    RequireTimeInRange(row, t_ns);
    if (n > 0 && n <= trajectory.size() && t_ns <= trajectory[n - 1].t_ns) {
      row.Fail(fmt::format("time {} s is not after the one before", row.fields[0]));
    }
    if (n < trajectory.size()) trajectory[n].t_ns = t_ns;
    ++n;
  });
  if (n != trajectory.size()) {
    throw std::runtime_error(
        fmt::format("{}: {} times for the {} poses of {}", times_path, n, trajectory.size(), path));
  }
}

Trajectory Read(const std::string& path, std::optional<TrajectoryFormat> format, const std::string& times_path) {
  Trajectory trajectory;
  ForEachRow(path, [&](const TextRow& row) {
    if (row.IsCsvHeader()) return;
    if (!format) format = Recognise(row);
    Append(row, ParseRow(row, *format, static_cast<int64_t>(trajectory.size())), trajectory);
  });
  if (format == TrajectoryFormat::kKitti && !times_path.empty()) ApplyTimes(path, times_path, trajectory);
  return trajectory;
}

void FormatRow(TrajectoryFormat format, const TrajectoryPose& pose, std::back_insert_iterator<std::string> out) {
  const Eigen::Vector3d& t = pose.T_a_b.translation();
  Eigen::Quaterniond q = pose.T_a_b.rotation();
  if (q.w() < 0.0) q.coeffs() = -q.coeffs();
  if (format == TrajectoryFormat::kTum) {
    fmt::format_to(out, "{} {:.9f} {:.9f} {:.9f} {:.12f} {:.12f} {:.12f} {:.12f}\n", SecondsText(pose.t_ns), t.x(),
                   t.y(), t.z(), q.x(), q.y(), q.z(), q.w());
  } else if (format == TrajectoryFormat::kEuroc) {
    fmt::format_to(out, "{},{:.9f},{:.9f},{:.9f},{:.12f},{:.12f},{:.12f},{:.12f}\n", pose.t_ns, t.x(), t.y(), t.z(),
                   q.w(), q.x(), q.y(), q.z());
  } else {
    const Eigen::Matrix4d m = pose.T_a_b.matrix();
    for (int i = 0; i < 12; ++i) fmt::format_to(out, "{:.12e}{}", m(i / 4, i % 4), i < 11 ? ' ' : '\n');
  }
}

}  // namespace

std::string SecondsText(int64_t t_ns) {
  const bool negative = t_ns < 0;
  const uint64_t magnitude = negative ? -static_cast<uint64_t>(t_ns) : static_cast<uint64_t>(t_ns);
  return fmt::format("{}{}.{:09d}", negative ? "-" : "", magnitude / kNsPerS, magnitude % kNsPerS);
}

Trajectory ReadTrajectory(const std::string& path, const std::string& times_path) {
  return Read(path, std::nullopt, times_path);
}

Trajectory ReadTrajectory(const std::string& path, TrajectoryFormat format, const std::string& times_path) {
  return Read(path, format, times_path);
}

void WriteTrajectory(const std::string& path, TrajectoryFormat format, const Trajectory& trajectory) {
  std::string text;
  if (format == TrajectoryFormat::kEuroc) {
    text = "#timestamp [ns],p_x [m],p_y [m],p_z [m],q_w [],q_x [],q_y [],q_z []\n";
  }
  for (const TrajectoryPose& pose : trajectory) {
    if (!pose.T_a_b.IsFinite()) {
      throw std::runtime_error(fmt::format("{}: the pose at {} ns is not finite", path, pose.t_ns));
    }
    FormatRow(format, pose, std::back_inserter(text));
  }
  WriteFileAtomically(path, text);
}

TrajectoryFormat TrajectoryFormatFromName(std::string_view name) {
  if (name == "tum") return TrajectoryFormat::kTum;
  if (name == "kitti") return TrajectoryFormat::kKitti;
  if (name == "euroc") return TrajectoryFormat::kEuroc;
  throw std::runtime_error(fmt::format("no trajectory format '{}' (tum, kitti, euroc)", name));
}

namespace {

// Unsigned, since hostile times may be further apart than a signed number holds.
uint64_t Between(int64_t earlier_ns, int64_t later_ns) {
  return static_cast<uint64_t>(later_ns) - static_cast<uint64_t>(earlier_ns);
}

/// The one of the poses before and behind a time that is of the same moment.
std::optional<SE3> PoseOfTheMoment(const Trajectory& trajectory, Trajectory::const_iterator after, int64_t t_ns) {
  const uint64_t none = static_cast<uint64_t>(kSameMoment_ns) + 1;
  const uint64_t until = after == trajectory.end() ? none : Between(t_ns, after->t_ns);
  const uint64_t since = after == trajectory.begin() ? none : Between((after - 1)->t_ns, t_ns);
  if (std::min(until, since) >= none) return std::nullopt;
  return until < since ? after->T_a_b : (after - 1)->T_a_b;
}

}  // namespace

std::optional<SE3> InterpolatePose(const Trajectory& trajectory, int64_t t_ns, int64_t max_gap_ns) {
  const auto after = std::lower_bound(trajectory.begin(), trajectory.end(), t_ns,
                                      [](const TrajectoryPose& pose, int64_t t) { return pose.t_ns < t; });
  const bool between = after != trajectory.begin() && after != trajectory.end();
  const uint64_t gap_ns = between ? Between((after - 1)->t_ns, after->t_ns) : 0;
  if (!between || gap_ns > static_cast<uint64_t>(max_gap_ns)) return PoseOfTheMoment(trajectory, after, t_ns);
  if (after->t_ns == t_ns) return after->T_a_b;
  const TrajectoryPose& a = *(after - 1);
  const TrajectoryPose& b = *after;
  // Differences first: times as doubles are good to some 100 ns only.
  const double share = static_cast<double>(t_ns - a.t_ns) / static_cast<double>(gap_ns);
  const Eigen::Vector3d t = (1.0 - share) * a.T_a_b.translation() + share * b.T_a_b.translation();
  return SE3(a.T_a_b.rotation().slerp(share, b.T_a_b.rotation()), t);
}

}  // namespace plslam
