// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <optional>
#include <vector>

#include "core/accuracy/association.h"
#include "core/accuracy/roll.h"
#include "core/geometry/similarity.h"
#include "core/run/final_trajectory.h"
#include "core/run/run_writer.h"
#include "viewer_headless/report/frame_tables.h"

namespace plslam::viewer {
namespace {

constexpr float kNone = std::numeric_limits<float>::quiet_NaN();

/// A frame of the run, with its truth if that is known. Poses of the left camera as calibrated.
struct PathFrame {
  SE3 T_w_c;
  SE3 T_w_l;
  SE3 T_w_l_live;
  std::optional<SE3> truth;
  bool has_pose = true;

  bool IsMeasured() const { return truth && has_pose; }
};

void VisitPath(const Recorder& recorder, const FinalPoses& final_poses, const RunParts& parts,
               const Eigen::Quaterniond& q_l_c, const std::function<void(const PathFrame&)>& visit) {
  const SE3 T_c_l(q_l_c.conjugate(), Eigen::Vector3d::Zero());
  SE3 before;
  for (const auto& [frame_id, frame] : recorder.frames()) {
    PathFrame row;
    row.T_w_c = final_poses(FrameId(frame_id), frame);
    row.T_w_l = row.T_w_c * T_c_l;
    row.T_w_l_live = frame.T_w_odom * frame.T_odom_c * T_c_l;
    row.has_pose = HasPose(frame);
    if (parts.Of(frame.session) != 0) {
      // It has a frame of its own: the path stays where it was.
      row.has_pose = false;
      row.T_w_c = before;
      row.T_w_l = row.T_w_c * T_c_l;
    }
    before = row.T_w_c;
    if (const auto truth = recorder.truth().Find(frame_id)) row.truth = truth->T_w_l;
    visit(row);
  }
}

/// The frames with a truth, estimated and true.
struct MeasuredPath {
  std::vector<SE3> final, live, truth;

  void Add(const PathFrame& frame) {
    if (!frame.IsMeasured()) return;
    final.push_back(frame.T_w_l);
    live.push_back(frame.T_w_l_live);
    truth.push_back(*frame.truth);
  }
};

/// Takes true positions and true orientations into w. Orientations have a rotation of their own: on a nearly straight
/// path, positions leave the roll about it free.
struct TruthAlignment {
  SE3 T_w_truth;
  Eigen::Quaterniond q_w_truth;
};

TruthAlignment Align(const std::vector<SE3>& estimated, const std::vector<SE3>& truth) {
  return {AlignPaths(estimated, truth, false).T_a_b, AlignOrientations(estimated, truth)};
}

class RootMeanSquare {
 public:
  void Add(double value) {
    sum_ += value * value;
    ++n_;
  }
  std::optional<double> Get() const {
    return n_ > 0 ? std::optional(std::sqrt(sum_ / static_cast<double>(n_))) : std::nullopt;
  }

 private:
  double sum_ = 0.0;
  int64_t n_ = 0;
};

double TrueSpread_m(const std::vector<SE3>& truth) {
  if (truth.empty()) return 0.0;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  double squares_m2 = 0.0;
  for (const SE3& T_w_l : truth) {
    const Eigen::Vector3d p = T_w_l.translation() - truth.front().translation();
    sum += p;
    squares_m2 += p.squaredNorm();
  }
  const auto n = static_cast<double>(truth.size());
  return std::sqrt(std::max(0.0, squares_m2 / n - (sum / n).squaredNorm()));
}

double AngleDeg(const Eigen::Quaterniond& a, const Eigen::Quaterniond& b) {
  return a.angularDistance(b) * 180.0 / M_PI;
}

struct PathColumns {
  std::vector<float> p, q, truth, error_m, error_deg, live_error_m;

  Table Take(bool with_truth) {
    Table table{{"p", 3, std::move(p)}, {"q", 4, std::move(q)}};
    if (!with_truth) return table;
    table.push_back({"truth", 3, std::move(truth)});
    table.push_back({"error_m", 1, std::move(error_m)});
    table.push_back({"error_deg", 1, std::move(error_deg)});
    table.push_back({"live_error_m", 1, std::move(live_error_m)});
    return table;
  }
};

/// Fills the columns row by row; true poses are taken into the map by the two alignments.
class PathWriter {
 public:
  PathWriter(const TruthAlignment& final, const TruthAlignment& live)
      : T_w_truth_(final.T_w_truth), q_w_truth_(final.q_w_truth), T_live_truth_(live.T_w_truth) {}

  void Add(const PathFrame& frame, bool shown) {
    const bool measured = frame.IsMeasured();
    const SE3 truth = frame.truth ? T_w_truth_ * *frame.truth : SE3();
    const double error_m = (truth.translation() - frame.T_w_l.translation()).norm();
    const double live_error_m =
        frame.truth ? ((T_live_truth_ * *frame.truth).translation() - frame.T_w_l_live.translation()).norm() : 0.0;
    if (measured) {
      error_.Add(error_m);
      live_error_.Add(live_error_m);
    }
    if (!shown) return;
    Append(frame.T_w_c.translation(), columns_.p);
    Append(frame.T_w_c.rotation().coeffs(), columns_.q);
    columns_.error_m.push_back(measured ? static_cast<float>(error_m) : kNone);
    columns_.error_deg.push_back(measured ? ErrorDeg(frame) : kNone);
    columns_.live_error_m.push_back(measured ? static_cast<float>(live_error_m) : kNone);
    if (frame.truth) return Append(truth.translation(), columns_.truth);
    columns_.truth.insert(columns_.truth.end(), 3, kNone);
  }

  PathOfRun Take(double length_m, double true_spread_m) {
    return {
        columns_.Take(error_.Get().has_value()), error_.Get(), live_error_.Get(), {}, length_m, true_spread_m, {}};
  }

 private:
  float ErrorDeg(const PathFrame& frame) const {
    return static_cast<float>(AngleDeg(q_w_truth_ * frame.truth->rotation(), frame.T_w_l.rotation()));
  }

  SE3 T_w_truth_;
  Eigen::Quaterniond q_w_truth_;
  SE3 T_live_truth_;
  PathColumns columns_;
  RootMeanSquare error_, live_error_;
};

/// As `plslam run` evaluates the files that are written at the end.
Consistency ConsistencyOf(const Recorder& recorder, const Map& map, const Eigen::Quaterniond& q_l_c) {
  if (recorder.truth().empty()) return {};
  const Run run = RunOf(recorder, map, q_l_c);
  return PoseConsistency(AssociateNearest(*run.trajectory, *run.truth, kSameMoment_ns), *run.covariance);
}

}  // namespace

PathOfRun PathTable(const Recorder& recorder, const Map& map, const Eigen::Quaterniond& q_l_c, int64_t stride) {
  const FinalPoses final_poses(map, recorder);
  const RunParts parts(map, recorder);
  MeasuredPath measured;
  if (!recorder.truth().empty()) {
    VisitPath(recorder, final_poses, parts, q_l_c, [&](const PathFrame& row) { measured.Add(row); });
  }
  PathWriter writer(Align(measured.final, measured.truth), Align(measured.live, measured.truth));
  double length_m = 0.0;
  int64_t i = 0;
  SE3 before;
  VisitPath(recorder, final_poses, parts, q_l_c, [&](const PathFrame& row) {
    writer.Add(row, i % stride == 0);
    if (i++ > 0) length_m += (row.T_w_c.translation() - before.translation()).norm();
    before = row.T_w_c;
  });
  PathOfRun path = writer.Take(length_m, TrueSpread_m(measured.truth));
  if (path.ate_m) path.roll_sigma_deg = RollSigma_rad(measured.truth, *path.ate_m) * 180.0 / M_PI;
  path.consistency = ConsistencyOf(recorder, map, q_l_c);
  return path;
}

}  // namespace plslam::viewer
