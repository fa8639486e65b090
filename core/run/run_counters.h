// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "core/ids/ids.h"

namespace plslam {

/// Counters of statuses about the quality of a run's data. From vo: points of the left image, those of them with a
/// match in the right image, nearly black frames, the vertical disparity in a corner in pixels, the change of lengths
/// by an offset of the disparities with its sigma, the delay of the right images after the left ones, or of the left
/// ones after the right ones, the same in frames, and the difference of the two cameras' readout times. From the
/// player, if the dataset has a ground truth: frames with a true pose, and without. From the viewer: frames without the
/// picture for report, film or overlays. From live cameras: pairs of images, the median time between left and right,
/// missing frames, images without a partner, pairs that are mostly white or mostly black, and the number of
/// interruptions.
inline constexpr const char* kPointsSeen = "points.seen";
inline constexpr const char* kPointsMatched = "points.matched";
inline constexpr const char* kPointsAmbiguous = "points.ambiguous";
inline constexpr const char* kFramesDark = "frames.dark";
inline constexpr const char* kCornerRows = "rows.corner_px";
inline constexpr const char* kLengthError = "lengths.error_percent";
inline constexpr const char* kLengthSigma = "lengths.sigma_percent";
inline constexpr const char* kTruthFrames = "truth.frames";
inline constexpr const char* kTruthMissing = "truth.missing";
inline constexpr const char* kPicturesMissing = "pictures.missing";
inline constexpr const char* kRightLate = "sync.right_late_ms";
inline constexpr const char* kLeftLate = "sync.left_late_ms";
inline constexpr const char* kLateFrames = "sync.late_frames";
/// The largest part of a delay that is compensated, in frame periods; beyond it, frames are at most weak.
inline constexpr double kLargestCompensatedDelay_frames = 0.3;
inline constexpr const char* kUnequalReadout = "sync.unequal_readout_ms";
/// Readout time of the rows that is not stated but found, the longest way of the camera in it, and the readout time
/// that contradicts the stated one.
inline constexpr const char* kReadout = "shutter.readout_ms";
inline constexpr const char* kReadoutPath = "shutter.path_mm";
inline constexpr const char* kOtherReadout = "shutter.other_readout_ms";
/// Largest share of the left image that dirt on the lens covered, and a pixel of the largest spot then.
inline constexpr const char* kLensDirt = "lens.dirt_percent";
inline constexpr const char* kLensDirtColumn = "lens.dirt_u_px";
inline constexpr const char* kLensDirtRow = "lens.dirt_v_px";
/// The same of the right image.
inline constexpr const char* kRightLensDirt = "lens.right_dirt_percent";
inline constexpr const char* kRightLensDirtColumn = "lens.right_dirt_u_px";
inline constexpr const char* kRightLensDirtRow = "lens.right_dirt_v_px";
/// Set by the process that sends frames, beside these: 1 while it is paused.
inline constexpr const char* kSenderPaused = "paused";
/// Set by the process that sends frames: 1 if they come from a sensor, which cannot wait.
inline constexpr const char* kLiveSource = "source.live";
inline constexpr const char* kFramesCaptured = "frames.captured";
inline constexpr const char* kSkew = "frames.skew_ms";
inline constexpr const char* kFramesMissing = "frames.missing";
inline constexpr const char* kDroppedLeft = "frames.dropped_left";
inline constexpr const char* kDroppedRight = "frames.dropped_right";
inline constexpr const char* kOverexposed = "frames.overexposed";
inline constexpr const char* kUnderexposed = "frames.underexposed";
inline constexpr const char* kOutages = "cameras.outages";
inline constexpr const char* kRecordingScan = "recording.scan_s";
/// From vo: frames after the first keyframe that have no known place in the map.
inline constexpr const char* kFramesUnanchored = "frames.unanchored";
/// The same since the last frame with a known place.
inline constexpr const char* kUnanchoredNow = "frames.unanchored_now";
/// From vo: frames that were lost, and whose pose the inertial sensor carried.
inline constexpr const char* kFramesLost = "frames.lost";
inline constexpr const char* kFramesCarried = "frames.carried";
/// From vo, with an inertial sensor: frames in which it was used, and its newest estimates: the mean normalised
/// innovation of measured poses (1: consistent), the delay of its stamps beyond the stated offset (0 if none is
/// significant), and its biases, each with its sigma. Unlike others these may be negative.
inline constexpr const char* kImuUsed = "imu.used";
inline constexpr const char* kImuInnovation = "imu.innovation";
inline constexpr const char* kImuDelay = "imu.delay_ms";
inline constexpr const char* kImuDelaySigma = "imu.delay_sigma_ms";
inline constexpr std::array<const char*, 3> kImuRateBias{"imu.rate_bias_x_rad_s", "imu.rate_bias_y_rad_s",
                                                         "imu.rate_bias_z_rad_s"};
inline constexpr const char* kImuRateBiasSigma = "imu.rate_bias_sigma_rad_s";
inline constexpr std::array<const char*, 3> kImuForceBias{"imu.force_bias_x_m_s2", "imu.force_bias_y_m_s2",
                                                          "imu.force_bias_z_m_s2"};
inline constexpr const char* kImuForceBiasSigma = "imu.force_bias_sigma_m_s2";
inline constexpr std::array<const char*, 37> kRunCounters{kPointsSeen,       kPointsMatched,
                                                          kFramesDark,       kCornerRows,
                                                          kLengthError,      kTruthFrames,
                                                          kTruthMissing,     kPicturesMissing,
                                                          kRightLate,        kLeftLate,
                                                          kLateFrames,       kUnequalReadout,
                                                          kFramesCaptured,   kSkew,
                                                          kFramesMissing,    kDroppedLeft,
                                                          kDroppedRight,     kOverexposed,
                                                          kUnderexposed,     kOutages,
                                                          kRecordingScan,    kLengthSigma,
                                                          kLiveSource,       kPointsAmbiguous,
                                                          kFramesUnanchored, kUnanchoredNow,
                                                          kReadout,          kReadoutPath,
                                                          kOtherReadout,     kLensDirt,
                                                          kLensDirtColumn,   kLensDirtRow,
                                                          kRightLensDirt,    kRightLensDirtColumn,
                                                          kRightLensDirtRow, kFramesCarried,
                                                          kImuUsed};

/// The newest values of these counters and of those of an inertial sensor, by process, including exited processes;
/// other counters are ignored.
class RunCounters {
 public:
  /// `source` names the process.
  void Take(SourceId source, const std::string& name, double value);
  /// Sum over all processes; 0 if none has published the counter.
  double Sum(std::string_view name) const;
  double Largest(std::string_view name) const;
  /// The value that came last of all processes; nullopt if none has published the counter.
  std::optional<double> Newest(std::string_view name) const;

 private:
  std::map<std::pair<std::string, SourceId>, double> values_;
  std::map<std::string, double, std::less<>> newest_;
};

/// The inertial sensor of a run, as its tracker estimated it last.
struct ImuFigures {
  int64_t used_frames = 0;
  double innovation = 1.0;
  /// Delay of its stamps beyond the stated offset; nullopt if none is significant.
  struct Delay {
    double ms = 0.0, sigma_ms = 0.0;
  };
  std::optional<Delay> delay;
  std::array<double, 3> rate_bias_rad_s{}, force_bias_m_s2{};
  double rate_bias_sigma_rad_s = 0.0, force_bias_sigma_m_s2 = 0.0;
};

/// Returns nullopt for runs without a sensor.
std::optional<ImuFigures> ImuFiguresOf(const RunCounters& counters);

}  // namespace plslam
