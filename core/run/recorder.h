// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/files/disk_map.h"
#include "core/geometry/se3.h"
#include "core/ids/ids.h"
#include "core/run/frame_tally.h"

namespace plslam {

/// Numbers of one frame that the tables and captions show.
struct FrameCounts {
  int32_t points = 0;
  int32_t lines = 0;
  int32_t tracked_points = 0;
  int32_t tracked_lines = 0;
  int32_t skipped_frames = 0;
  int32_t moving = 0;  ///< features on moving bodies, and bodies of the session so far
  int32_t bodies = 0;
};

/// A pose from the tracker as plain values. Frames: c rectified left camera.
struct FramePose {
  FrameId frame_id = 0;
  int64_t t_ns = 0;
  SessionId session;
  TrackingState state = TrackingState::kInitialising;
  SE3 T_odom_c;
  SE3 T_w_odom;
  bool anchored = true;  ///< whether T_w_odom is known
  Matrix6d covariance = Matrix6d::Zero();
  Matrix6d motion_covariance = Matrix6d::Zero();
  int64_t keyframe_id = -1;
  double entropy_ratio = 0.0;
  FrameCounts counts;
  std::vector<std::pair<std::string, double>> stages_ms;
};

/// Lower triangle of a covariance in single precision, to save memory.
class PackedCovariance {
 public:
  PackedCovariance() = default;
  explicit PackedCovariance(const Matrix6d& covariance);
  Matrix6d Unpack() const;

 private:
  std::array<float, 21> values_{};
};

/// A pose as numbers, bit for bit.
class StoredPose {
 public:
  StoredPose() = default;
  explicit StoredPose(const SE3& T);
  SE3 Unpack() const;

 private:
  std::array<double, 7> values_;
};

/// A frame as it is kept.
struct FrameRecord {
  int64_t t_ns = 0;
  SessionId session;
  TrackingState state = TrackingState::kInitialising;
  SE3 T_odom_c;
  SE3 T_w_odom;
  bool anchored = true;
  PackedCovariance covariance;
  PackedCovariance motion_covariance;
  int64_t keyframe_id = -1;
  float entropy_ratio = 0.0F;
  FrameCounts counts;
  /// One number for each of `Recorder::stage_names`; NaN if the frame has no such stage.
  std::vector<float> stages_ms;
};

/// IsTracked.
inline bool HasPose(const FrameRecord& frame) { return IsTracked(frame.state, frame.keyframe_id); }

/// A FrameRecord in the file of frames, with at most `kMaxStages` times.
class StoredFrame {
 public:
  static constexpr size_t kMaxStages = 32;

  StoredFrame() = default;
  explicit StoredFrame(const FrameRecord& frame);
  FrameRecord Unpack() const;

 private:
  int64_t t_ns_, keyframe_id_;
  SessionId session_;
  StoredPose T_odom_c_, T_w_odom_;
  PackedCovariance covariance_, motion_covariance_;
  FrameCounts counts_;
  float entropy_ratio_;
  std::array<float, kMaxStages> stages_ms_;
  uint8_t n_stages_, state_, anchored_;
};

/// Pose of a moving body in a frame.
struct BodyRecord {
  int64_t id = 0;
  SE3 T_c_body;
  int32_t n_features = 0;
};

struct BodiesOfFrame {
  SessionId session;
  std::vector<BodyRecord> bodies;
};

struct TruthRecord {
  int64_t t_ns = 0;
  SE3 T_w_l;
};

class StoredTruth {
 public:
  StoredTruth() = default;
  explicit StoredTruth(const TruthRecord& truth) : t_ns_(truth.t_ns), T_w_l_(truth.T_w_l) {}
  TruthRecord Unpack() const { return {t_ns_, T_w_l_.Unpack()}; }

 private:
  int64_t t_ns_;
  StoredPose T_w_l_;
};

using Frames = DiskMap<FrameRecord, StoredFrame>;
using Truths = DiskMap<TruthRecord, StoredTruth>;

/// The record of a run, in order of frames. Messages may arrive in any order and more than once; of two poses of a
/// frame the later one counts (a restarted tracker publishes some again). Non-finite poses, invalid states and negative
/// frame ids are rejected.
class Recorder {
 public:
  /// Frames are kept in a file without a name in `folder`, about half a kilobyte each; without a folder in memory.
  Recorder() = default;
  explicit Recorder(const std::string& folder) : frames_(folder), truth_(folder) {}

  /// Returns false if the message is rejected.
  bool AddPose(const FramePose& pose);
  bool AddTruth(FrameId frame_id, const TruthRecord& truth);
  bool AddBodies(FrameId frame_id, BodiesOfFrame seen);
  /// The stream has ended after `n_frames` frames; `n_bad` could not be read.
  void SetEnd(int64_t n_frames, int64_t n_bad = 0) {
    n_frames_ = n_frames;
    sent_.OnStream(true, n_frames, n_bad);
  }
  /// Takes the player's counts during the run: frames sent, and frames it could not read.
  void SetSent(int64_t sent, int64_t unreadable) { sent_.OnStatus(sent, unreadable); }

  const SentFrames& sent() const { return sent_; }

  /// Number of frames of the ended stream; nullopt while it runs.
  std::optional<int64_t> n_frames() const { return n_frames_; }
  /// Returns whether every frame of the ended stream has a pose or was skipped by the tracker.
  bool IsComplete() const;
  /// Returns whether no pose of the ended stream is to come: poses arrive in order, and frames without one before the
  /// last were lost before the tracker.
  bool HasLastPose() const;

  /// The newest keyframe.
  std::optional<KeyframeName> LastKeyframe() const;

  const Frames& frames() const { return frames_; }
  const Truths& truth() const { return truth_; }
  /// One sentence if frames that should be in the file are in memory.
  const std::string& failure() const { return frames_.failure().empty() ? truth_.failure() : frames_.failure(); }
  /// By frame.
  const std::map<FrameId, BodiesOfFrame>& bodies() const { return bodies_; }
  const std::vector<std::string>& stage_names() const { return stage_names_; }
  int64_t keyframes() const { return keyframes_; }
  /// Returns the counts of the frames so far. Unanswered frames are counted only if the run `is_over`: before that they
  /// are on their way.
  FrameTally Tally(bool is_over) const;

 private:
  void Count(const FrameRecord& record, int sign);
  void StoreStages(const FramePose& pose, FrameRecord& record);

  Frames frames_;
  Truths truth_;
  std::map<FrameId, BodiesOfFrame> bodies_;
  std::vector<std::string> stage_names_;
  std::optional<int64_t> n_frames_;
  int64_t keyframes_ = 0;
  FrameTally tally_;
  SentFrames sent_;
};

}  // namespace plslam
