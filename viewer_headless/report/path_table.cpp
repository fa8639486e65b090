// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/accuracy/association.h"
#include "core/geometry/similarity.h"
#include "viewer_headless/final_trajectory.h"
#include "viewer_headless/outputs.h"
#include "viewer_headless/report/frame_tables.h"

namespace plslam::viewer {
namespace {

constexpr float kNone = std::numeric_limits<float>::quiet_NaN();

/// A frame of the run, with its truth if that is known. Poses of the left camera as calibrated.
struct PathFrame {
  SE3 T_w_c;
  SE3 T_w_l;
  SE3 T_w_l_live;
  const SE3* truth = nullptr;
  bool has_pose = true;
};

std::vector<PathFrame> Frames(const Recorder& recorder, const Map& map, const Eigen::Quaterniond& q_l_c) {
  const FinalPoses final_poses(map, recorder);
  const SE3 T_c_l(q_l_c.conjugate(), Eigen::Vector3d::Zero());
  std::vector<PathFrame> frames;
  frames.reserve(recorder.frames().size());
  for (const auto& [frame_id, frame] : recorder.frames()) {
    PathFrame row;
    row.T_w_c = final_poses(frame_id, frame);
    row.T_w_l = row.T_w_c * T_c_l;
    row.T_w_l_live = frame.T_w_odom * frame.T_odom_c * T_c_l;
    row.has_pose = HasPose(frame);
    const auto truth = recorder.truth().find(frame_id);
    if (truth != recorder.truth().end()) row.truth = &truth->second.T_w_l;
    frames.push_back(row);
  }
  return frames;
}

SE3 Align(const std::vector<PathFrame>& frames, SE3 PathFrame::*pose) {
  std::vector<SE3> estimated, truth;
  for (const PathFrame& frame : frames) {
    if (frame.truth == nullptr || !frame.has_pose) continue;
    estimated.push_back(frame.*pose);
    truth.push_back(*frame.truth);
  }
  return AlignPaths(estimated, truth, false).T_a_b;
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

double TrueSpread_m(const std::vector<PathFrame>& frames) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  double squares_m2 = 0.0;
  double n = 0.0;
  for (const PathFrame& frame : frames) {
    if (frame.truth == nullptr || !frame.has_pose) continue;
    const Eigen::Vector3d p = frame.truth->translation() - frames.front().T_w_l.translation();
    sum += p;
    squares_m2 += p.squaredNorm();
    ++n;
  }
  return n > 0.0 ? std::sqrt(std::max(0.0, squares_m2 / n - (sum / n).squaredNorm())) : 0.0;
}

double AngleDeg(const SE3& a, const SE3& b) { return a.rotation().angularDistance(b.rotation()) * 180.0 / M_PI; }

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
  PathWriter(const SE3& T_w_truth, const SE3& T_live_truth) : T_w_truth_(T_w_truth), T_live_truth_(T_live_truth) {}

  void Add(const PathFrame& frame, bool shown) {
    const bool measured = frame.truth != nullptr && frame.has_pose;
    const SE3 truth = frame.truth != nullptr ? T_w_truth_ * *frame.truth : SE3();
    const double error_m = (truth.translation() - frame.T_w_l.translation()).norm();
    const double live_error_m =
        frame.truth == nullptr
            ? 0.0
            : ((T_live_truth_ * *frame.truth).translation() - frame.T_w_l_live.translation()).norm();
    if (measured) {
      error_.Add(error_m);
      live_error_.Add(live_error_m);
    }
    if (!shown) return;
    Append(frame.T_w_c.translation(), columns_.p);
    Append(frame.T_w_c.rotation().coeffs(), columns_.q);
    columns_.error_m.push_back(measured ? static_cast<float>(error_m) : kNone);
    columns_.error_deg.push_back(measured ? static_cast<float>(AngleDeg(truth, frame.T_w_l)) : kNone);
    columns_.live_error_m.push_back(measured ? static_cast<float>(live_error_m) : kNone);
    if (frame.truth != nullptr) return Append(truth.translation(), columns_.truth);
    columns_.truth.insert(columns_.truth.end(), 3, kNone);
  }

  PathOfRun Take(double length_m, double true_spread_m) {
    return {columns_.Take(error_.Get().has_value()), error_.Get(), live_error_.Get(), length_m, true_spread_m, {}};
  }

 private:
  SE3 T_w_truth_, T_live_truth_;
  PathColumns columns_;
  RootMeanSquare error_, live_error_;
};

/// As `plslam run` evaluates the files that are written at the end.
Consistency ConsistencyOf(const Recorder& recorder, const Map& map, const Eigen::Quaterniond& q_l_c) {
  if (recorder.truth().empty()) return {};
  const RunTrajectories run = BuildTrajectories(recorder, map, q_l_c);
  return PoseConsistency(AssociateNearest(run.all, run.truth, kSameMoment_ns), run.covariances);
}

}  // namespace

PathOfRun PathTable(const Recorder& recorder, const Map& map, const Eigen::Quaterniond& q_l_c, int64_t stride) {
  const std::vector<PathFrame> frames = Frames(recorder, map, q_l_c);
  PathWriter writer(Align(frames, &PathFrame::T_w_l), Align(frames, &PathFrame::T_w_l_live));
  double length_m = 0.0;
  for (size_t i = 0; i < frames.size(); ++i) {
    writer.Add(frames[i], static_cast<int64_t>(i) % stride == 0);
    if (i > 0) length_m += (frames[i].T_w_c.translation() - frames[i - 1].T_w_c.translation()).norm();
  }
  PathOfRun path = writer.Take(length_m, TrueSpread_m(frames));
  path.consistency = ConsistencyOf(recorder, map, q_l_c);
  return path;
}

}  // namespace plslam::viewer
