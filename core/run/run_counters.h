// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <utility>

namespace plslam {

/// Counters of statuses that tell how good the data of a run are. By vo: points of the left image, those of them that
/// the right image has, too, frames that are nearly black, by how many pixels rows of the right image differ in a
/// corner, the offset of the disparities with its sigma and the
/// change of lengths by it, by how much later the right images are taken than the left ones, or the
/// left ones than the right ones, the same in frames, and by how much the times differ in which the two cameras read
/// an image. By the player, where the dataset has a ground truth: frames with a true pose, and without. By the
/// viewer: frames without the picture that report, film or overlays should have had. By live cameras: pairs of images,
/// the median time between left and right, frames that are missing between others, images without a partner,
/// pairs that are mostly white or mostly black, and how often they gave nothing for a while.
inline constexpr const char* kPointsSeen = "points.seen";
inline constexpr const char* kPointsMatched = "points.matched";
inline constexpr const char* kPointsAmbiguous = "points.ambiguous";
inline constexpr const char* kFramesDark = "frames.dark";
inline constexpr const char* kCornerRows = "rows.corner_px";
inline constexpr const char* kDisparityError = "disparities.error_px";
inline constexpr const char* kDisparitySigma = "disparities.sigma_px";
inline constexpr const char* kLengthError = "lengths.error_percent";
inline constexpr const char* kTruthFrames = "truth.frames";
inline constexpr const char* kTruthMissing = "truth.missing";
inline constexpr const char* kPicturesMissing = "pictures.missing";
inline constexpr const char* kRightLate = "sync.right_late_ms";
inline constexpr const char* kLeftLate = "sync.left_late_ms";
inline constexpr const char* kLateFrames = "sync.late_frames";
/// Of that, what is made up for; beyond, frames are at most weak.
inline constexpr double kMostLateMadeUpFor_frames = 0.3;
inline constexpr const char* kUnequalReadout = "sync.unequal_readout_ms";
/// Set by the process that sends frames, beside these: 1 while it is paused.
inline constexpr const char* kSenderPaused = "paused";
inline constexpr const char* kFramesCaptured = "frames.captured";
inline constexpr const char* kSkew = "frames.skew_ms";
inline constexpr const char* kFramesMissing = "frames.missing";
inline constexpr const char* kDroppedLeft = "frames.dropped_left";
inline constexpr const char* kDroppedRight = "frames.dropped_right";
inline constexpr const char* kOverexposed = "frames.overexposed";
inline constexpr const char* kUnderexposed = "frames.underexposed";
inline constexpr const char* kOutages = "cameras.outages";
inline constexpr const char* kRecordingScan = "recording.scan_s";
inline constexpr std::array<const char*, 24> kRunCounters{
    kPointsSeen,      kPointsMatched, kFramesDark,     kCornerRows,  kDisparityError, kTruthFrames,    kTruthMissing,
    kPicturesMissing, kRightLate,     kLeftLate,       kLateFrames,  kUnequalReadout, kFramesCaptured, kSkew,
    kFramesMissing,   kDroppedLeft,   kDroppedRight,   kOverexposed, kUnderexposed,   kOutages,        kRecordingScan,
    kDisparitySigma,  kLengthError,   kPointsAmbiguous};

/// The newest of these counters by process, also of those that have ended since; others are passed over.
class RunCounters {
 public:
  /// `source` names the process.
  void Take(int64_t source, const std::string& name, double value);
  /// Over all processes; 0 where nobody has told it.
  double Sum(std::string_view name) const;
  double Largest(std::string_view name) const;

 private:
  std::map<std::pair<std::string, int64_t>, double> values_;
};

}  // namespace plslam
