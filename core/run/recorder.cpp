// SPDX-License-Identifier: BSD-3-Clause
#include "core/run/recorder.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace plslam {
namespace {

// Against a publisher that invents frames or names without end.
constexpr size_t kMaxFrames = 20'000'000;
constexpr size_t kMaxBodiesOfFrame = 64;

}  // namespace

PackedCovariance::PackedCovariance(const Matrix6d& covariance) {
  // Sums of larger ones would not be finite numbers of single precision.
  constexpr double kMost = 1e30;
  size_t k = 0;
  for (int row = 0; row < 6; ++row) {
    for (int column = 0; column <= row; ++column) {
      values_[k++] = static_cast<float>(std::clamp(covariance(row, column), -kMost, kMost));
    }
  }
}

Matrix6d PackedCovariance::Unpack() const {
  Matrix6d covariance;
  size_t k = 0;
  for (int row = 0; row < 6; ++row) {
    for (int column = 0; column <= row; ++column) {
      covariance(row, column) = covariance(column, row) = static_cast<double>(values_[k++]);
    }
  }
  return covariance;
}

StoredPose::StoredPose(const SE3& T) {
  const Eigen::Vector3d& t = T.translation();
  const Eigen::Vector4d& q = T.rotation().coeffs();
  values_ = {t.x(), t.y(), t.z(), q.x(), q.y(), q.z(), q.w()};
}

SE3 StoredPose::Unpack() const {
  const auto& v = values_;
  return SE3::FromUnit(Eigen::Quaterniond(v[6], v[3], v[4], v[5]), Eigen::Vector3d(v[0], v[1], v[2]));
}

StoredFrame::StoredFrame(const FrameRecord& frame)
    : t_ns_(frame.t_ns),
      keyframe_id_(frame.keyframe_id),
      session_(frame.session),
      T_odom_c_(frame.T_odom_c),
      T_w_odom_(frame.T_w_odom),
      covariance_(frame.covariance),
      motion_covariance_(frame.motion_covariance),
      counts_(frame.counts),
      entropy_ratio_(frame.entropy_ratio),
      stages_ms_{},
      n_stages_(static_cast<uint8_t>(std::min(frame.stages_ms.size(), kMaxStages))),
      state_(static_cast<uint8_t>(frame.state)),
      anchored_(frame.anchored ? 1 : 0) {
  std::copy_n(frame.stages_ms.begin(), n_stages_, stages_ms_.begin());
}

FrameRecord StoredFrame::Unpack() const {
  return {t_ns_,
          session_,
          static_cast<TrackingState>(state_),
          T_odom_c_.Unpack(),
          T_w_odom_.Unpack(),
          anchored_ != 0,
          covariance_,
          motion_covariance_,
          keyframe_id_,
          entropy_ratio_,
          counts_,
          {stages_ms_.begin(), stages_ms_.begin() + n_stages_}};
}

bool Recorder::AddPose(const FramePose& pose) {
  const bool finite = pose.T_odom_c.IsFinite() && pose.T_w_odom.IsFinite() && pose.covariance.allFinite() &&
                      pose.motion_covariance.allFinite();
  if (!finite || !IsTrackingState(static_cast<int>(pose.state)) || pose.frame_id < 0 ||
      pose.counts.skipped_frames < 0)
    return false;
  const std::optional<FrameRecord> earlier = frames_.Find(pose.frame_id.value);
  if (!earlier && frames_.size() >= kMaxFrames) return false;
  if (earlier) Count(*earlier, -1);
  FrameRecord record{pose.t_ns,
                     pose.session,
                     pose.state,
                     pose.T_odom_c,
                     pose.T_w_odom,
                     pose.anchored,
                     PackedCovariance(pose.covariance),
                     PackedCovariance(pose.motion_covariance),
                     pose.keyframe_id,
                     static_cast<float>(pose.entropy_ratio),
                     pose.counts,
                     {}};
  StoreStages(pose, record);
  Count(record, 1);
  frames_.Set(pose.frame_id.value, record);
  return true;
}

void Recorder::Count(const FrameRecord& record, int sign) {
  if (record.keyframe_id >= 0) keyframes_ += sign;
  tally_.Count(record.state, record.keyframe_id, sign);
  tally_.skipped += sign * int64_t{record.counts.skipped_frames};
}

FrameTally Recorder::Tally(bool is_over) const {
  FrameTally tally = tally_;
  tally.unreadable = sent_.unreadable();
  if (is_over) tally.unanswered = sent_.Unanswered(tally);
  return tally;
}

void Recorder::StoreStages(const FramePose& pose, FrameRecord& record) {
  for (const auto& [name, ms] : pose.stages_ms) {
    const auto found = std::find(stage_names_.begin(), stage_names_.end(), name);
    if (found == stage_names_.end() && stage_names_.size() >= StoredFrame::kMaxStages) continue;
    const auto index = static_cast<size_t>(found - stage_names_.begin());
    if (found == stage_names_.end()) stage_names_.push_back(name);
    if (record.stages_ms.size() <= index) {
      record.stages_ms.resize(index + 1, std::numeric_limits<float>::quiet_NaN());
    }
    record.stages_ms[index] = static_cast<float>(ms);
  }
}

bool Recorder::AddTruth(FrameId frame_id, const TruthRecord& truth) {
  if (frame_id < 0 || !truth.T_w_l.IsFinite() || truth_.size() >= kMaxFrames) return false;
  truth_.Set(frame_id.value, truth);
  return true;
}

bool Recorder::AddBodies(FrameId frame_id, BodiesOfFrame seen) {
  const std::vector<BodyRecord>& bodies = seen.bodies;
  const bool finite = std::all_of(bodies.begin(), bodies.end(),
                                  [](const BodyRecord& body) { return body.id >= 0 && body.T_c_body.IsFinite(); });
  if (frame_id < 0 || !finite || bodies.size() > kMaxBodiesOfFrame || bodies_.size() >= kMaxFrames) return false;
  bodies_[frame_id] = std::move(seen);
  return true;
}

std::optional<KeyframeName> Recorder::LastKeyframe() const {
  for (auto at = frames_.end(); at != frames_.begin();) {
    const FrameRecord frame = (*--at).second;
    if (frame.keyframe_id >= 0) return KeyframeName{frame.session, frame.keyframe_id};
  }
  return std::nullopt;
}

bool Recorder::IsComplete() const {
  return n_frames_ && static_cast<int64_t>(frames_.size()) + tally_.skipped >= *n_frames_;
}

bool Recorder::HasLastPose() const { return n_frames_ && (IsComplete() || frames_.Find(*n_frames_ - 1)); }

}  // namespace plslam
