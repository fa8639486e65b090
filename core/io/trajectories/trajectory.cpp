// SPDX-License-Identifier: BSD-3-Clause
#include "core/io/trajectories/trajectory.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <optional>
#include <stdexcept>

#include <fmt/format.h>

#include "core/errors/error_text.h"
#include "core/files/atomic_file.h"
#include "core/files/text_rows.h"
#include "core/io/trajectories/row_format.h"

namespace plslam {
namespace {

// Tolerance for a quaternion's norm or a matrix product R R^T: files are rounded to five digits and more.
constexpr double kRotationTolerance = 0.01;
constexpr int64_t kNsPerS = 1'000'000'000;
// 25 times round the Earth. A larger position is a number of another column or of a diverged solver, and would make
// errors infinite.
constexpr double kMaxPosition_m = 1e9;

void RequireFields(const TextRow& row, size_t n, const char* format) {
  if (row.fields.size() != n) {
    row.Fail(fmt::format("{} numbers, but a row of {} has {}", row.fields.size(), format, n));
  }
}

SE3 UnitPose(const TextRow& row, const Eigen::Quaterniond& q, const Eigen::Vector3d& t) {
  if (!(std::abs(q.norm() - 1.0) <= kRotationTolerance)) {
    row.Fail(fmt::format("the quaternion has norm {:.6g}, not 1", q.norm()));
  }
  return {q, t};
}

TrajectoryPose ParsePose(const TextRow& row, const RowLayout& layout) {
  const size_t n = layout.n_fields;
  if (row.fields.size() < n && layout.may_be_longer) {
    row.Fail(fmt::format("{} columns, but a row of {} has at least {}", row.fields.size(), layout.name, n));
  }
  if (!layout.may_be_longer) RequireFields(row, n, layout.name);
  const auto& [x, y, z, w] = layout.quaternion;
  const auto& [px, py, pz] = layout.position;
  const int64_t t_ns = row.Scaled(layout.time, layout.time_decimals);
  const Eigen::Quaterniond q(row.Number(w), row.Number(x), row.Number(y), row.Number(z));
  return {t_ns, UnitPose(row, q, {row.Number(px), row.Number(py), row.Number(pz)})};
}

SE3 ParseKitti(const TextRow& row) {
  RequireFields(row, 12, "the KITTI format");
  Eigen::Matrix<double, 3, 4> m;
  for (int i = 0; i < 12; ++i) m(i / 4, i % 4) = row.Number(static_cast<size_t>(i));
  const Eigen::Matrix3d R = m.leftCols<3>();
  const double error = (R * R.transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
  if (!(error <= kRotationTolerance) || R.determinant() < 0.0) {
    row.Fail(fmt::format("the matrix is not a rotation (determinant {:.6g}, off by {:.3g})", R.determinant(), error));
  }
  return {R, m.col(3)};
}

std::string BeyondRange(int64_t t_ns) {
  if (t_ns <= kMaxTime_ns && t_ns >= -kMaxTime_ns) return "";
  return fmt::format("time {} ns is beyond the year 2115", t_ns);
}

std::string NotAfter(int64_t t_ns, int64_t before_ns) {
  return fmt::format("time {} ns is not after the {} ns of the previous row", t_ns, before_ns);
}

/// Parses a row; without a layout, of KITTI.
TrajectoryPose ParseRow(const TextRow& row, const std::optional<RowLayout>& layout, int64_t index) {
  const TrajectoryPose pose = layout ? ParsePose(row, *layout) : TrajectoryPose{index * kNsPerS, ParseKitti(row)};
  const std::string complaint = BeyondRange(pose.t_ns);
  if (!complaint.empty()) row.Fail(complaint);
  const double distance_m = pose.T_a_b.translation().stableNorm();
  if (!(distance_m <= kMaxPosition_m)) {
    row.Fail(fmt::format("the position is {:.3g} m from the origin, more than {:g} m", distance_m, kMaxPosition_m));
  }
  return pose;
}

/// Replaces the numbers of rows by the times of a file.
void ApplyTimes(const std::string& path, const std::string& times_path, size_t n_rows, Trajectory& trajectory) {
  std::vector<int64_t> times_ns;
  ForEachRow(times_path, [&](const TextRow& row) {
    RequireFields(row, 1, "the times format");
    const int64_t t_ns = row.Scaled(0, 9);
    const std::string complaint = BeyondRange(t_ns);
    if (!complaint.empty()) row.Fail(complaint);
    if (!times_ns.empty() && t_ns <= times_ns.back()) {
      row.Fail(fmt::format("time {} s is not after the previous one", row.fields[0]));
    }
    times_ns.push_back(t_ns);
  });
  if (times_ns.size() != n_rows) {
    throw std::runtime_error(
        fmt::format("{}: {} times for the {} poses of {}", times_path, times_ns.size(), n_rows, path));
  }
  for (TrajectoryPose& pose : trajectory) pose.t_ns = times_ns.at(static_cast<size_t>(pose.t_ns / kNsPerS));
}

/// A pose with its line.
struct PoseRow {
  int line = 0;
  TrajectoryPose pose;
};

/// Returns the indices of a longest subsequence of rows with increasing times; of rows with equal times the first.
std::vector<size_t> LongestIncreasing(const std::vector<PoseRow>& rows) {
  constexpr size_t kNone = std::numeric_limits<size_t>::max();
  // The row with the smallest time that ends an increasing subsequence of each length, and the predecessor of each row.
  std::vector<size_t> ends, before(rows.size(), kNone);
  for (size_t i = 0; i < rows.size(); ++i) {
    const int64_t t_ns = rows[i].pose.t_ns;
    const auto at = std::lower_bound(ends.begin(), ends.end(), t_ns,
                                     [&](size_t row, int64_t t) { return rows[row].pose.t_ns < t; });
    if (at != ends.end() && rows[*at].pose.t_ns == t_ns) continue;
    if (at != ends.begin()) before[i] = *(at - 1);
    if (at == ends.end()) {
      ends.push_back(i);
    } else {
      *at = i;
    }
  }
  std::vector<size_t> part;
  for (size_t i = ends.empty() ? kNone : ends.back(); i != kNone; i = before[i]) part.push_back(i);
  std::reverse(part.begin(), part.end());
  return part;
}

/// Rows that are no poses: how many, and the first.
class PassedOver {
 public:
  void Add(int line, const std::string& sentence) {
    ++n_;
    if (first_line_ != 0 && line >= first_line_) return;
    first_line_ = line;
    sentence_ = sentence;
  }
  std::string Note(size_t n_rows) const {
    return n_ == 0 ? "" : fmt::format("{}; {} of {} rows {} skipped", sentence_, n_, n_rows, n_ == 1 ? "is" : "are");
  }

 private:
  size_t n_ = 0;
  int first_line_ = 0;
  std::string sentence_;
};

/// Returns the reason why a row is not among those whose times increase.
std::string WhyOutOfOrder(const std::vector<PoseRow>& rows, size_t i) {
  const int64_t t_ns = rows[i].pose.t_ns;
  if (i > 0 && t_ns <= rows[i - 1].pose.t_ns) return NotAfter(t_ns, rows[i - 1].pose.t_ns);
  return fmt::format("time {} ns is out of order relative to the following rows", t_ns);
}

/// Returns the poses of the rows with increasing times.
Trajectory TakeIncreasing(const std::string& path, const std::vector<PoseRow>& rows, PassedOver* passed) {
  Trajectory poses;
  std::vector<size_t> kept = LongestIncreasing(rows);
  size_t next = 0;
  for (size_t i = 0; i < rows.size(); ++i) {
    if (next < kept.size() && kept[next] == i) {
      poses.push_back(rows[i].pose);
      ++next;
    } else {
      passed->Add(rows[i].line, fmt::format("{}:{}: {}", path, rows[i].line, WhyOutOfOrder(rows, i)));
    }
  }
  return poses;
}

/// Parses rows with their lines in one format.
class RowReader {
 public:
  RowReader(const RowFormat& format, BadRows bad_rows) : format_(format), bad_rows_(bad_rows) {}

  /// Reads all rows of a file.
  void Read(const std::string& path) {
    ForEachRow(path, [&](const TextRow& row) {
      if (row.IsCsvHeader() || row.line == format_.header_line) return;
      const auto index = static_cast<int64_t>(n_rows_++);
      try {
        Take(row, index);
      } catch (const std::runtime_error& error) {
        if (bad_rows_ == BadRows::kRefuse) throw;
        passed_.Add(row.line, error.what());
      }
    });
  }

  size_t n_rows() const { return n_rows_; }
  const std::vector<PoseRow>& rows() const { return rows_; }
  PassedOver& passed() { return passed_; }

 private:
  void Take(const TextRow& row, int64_t index) {
    const TrajectoryPose pose = ParseRow(row, format_.layout, index);
    if (bad_rows_ == BadRows::kRefuse && !rows_.empty() && pose.t_ns <= rows_.back().pose.t_ns) {
      row.Fail(NotAfter(pose.t_ns, rows_.back().pose.t_ns));
    }
    rows_.push_back({row.line, pose});
  }

  RowFormat format_;
  BadRows bad_rows_;
  size_t n_rows_ = 0;
  std::vector<PoseRow> rows_;
  PassedOver passed_;
};

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

TrajectoryFile ReadTrajectoryFile(const std::string& path, std::optional<TrajectoryFormat> format, BadRows bad_rows,
                                  const std::string& times_path) {
  TrajectoryFile file;
  const std::optional<RowFormat> found = FindRowFormat(path, format, &file.notes);
  file.format = !found ? format : found->layout ? found->layout->format : TrajectoryFormat::kKitti;
  RowReader reader(found.value_or(RowFormat{}), bad_rows);
  reader.Read(path);
  file.n_rows = reader.n_rows();
  file.poses = TakeIncreasing(path, reader.rows(), &reader.passed());
  if (file.format == TrajectoryFormat::kKitti && !times_path.empty()) {
    ApplyTimes(path, times_path, file.n_rows, file.poses);
  }
  const std::string note = reader.passed().Note(file.n_rows);
  if (!note.empty()) file.notes.Warn(note);
  return file;
}

Trajectory ReadTrajectory(const std::string& path, const std::string& times_path) {
  return ReadTrajectoryFile(path, std::nullopt, BadRows::kRefuse, times_path).poses;
}

Trajectory ReadTrajectory(const std::string& path, TrajectoryFormat format, const std::string& times_path) {
  return ReadTrajectoryFile(path, format, BadRows::kRefuse, times_path).poses;
}

TrajectoryWriter::TrajectoryWriter(const std::string& path, TrajectoryFormat format)
    : path_(path), format_(format), file_(path) {
  if (format != TrajectoryFormat::kEuroc) return;
  file_.Append("#timestamp [ns],p_x [m],p_y [m],p_z [m],q_w [],q_x [],q_y [],q_z []\n");
}

void TrajectoryWriter::Add(const TrajectoryPose& pose) {
  if (!pose.T_a_b.IsFinite()) {
    throw std::runtime_error(fmt::format("{}: the pose at {} ns is not finite", path_, pose.t_ns));
  }
  std::string row;
  FormatRow(format_, pose, std::back_inserter(row));
  file_.Append(row);
}

void WriteTrajectory(const std::string& path, TrajectoryFormat format, const Trajectory& trajectory) {
  TrajectoryWriter writer(path, format);
  for (const TrajectoryPose& pose : trajectory) writer.Add(pose);
  writer.PutInPlace();
}

namespace {

// Unsigned, since hostile times may be further apart than a signed number holds.
uint64_t Between(int64_t earlier_ns, int64_t later_ns) {
  return static_cast<uint64_t>(later_ns) - static_cast<uint64_t>(earlier_ns);
}

/// Returns the pose before or after a time that is of the same moment.
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
