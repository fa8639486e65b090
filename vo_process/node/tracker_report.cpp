// SPDX-License-Identifier: BSD-3-Clause
#include "vo_process/node/tracker_report.h"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <utility>

#include "core/errors/error_text.h"
#include "core/errors/log.h"
#include "core/run/process_names.h"
#include "core/run/run_counters.h"
#include "core/run/run_warnings.h"

namespace plslam::vo {
namespace {

/// Whether the image is darker than sensor noise: below a mean of 8 of 255 in every 8th row.
bool IsNearlyBlack(const cv::Mat& image) {
  constexpr int kEveryRow = 8;
  constexpr double kDark = 8.0;
  double sum = 0.0;
  int rows = 0;
  for (int row = 0; row < image.rows; row += kEveryRow, ++rows) sum += cv::mean(image.row(row))[0];
  return rows > 0 && sum < kDark * rows;
}

}  // namespace

void TrackerReport::Count(const std::string& name, double increment) {
  double& count = counts_[name];
  count += increment;
  process_.SetCounter(name, count);
}

void TrackerReport::CountUnanchored(bool is_unanchored) {
  if (is_unanchored) Count(kFramesUnanchored, 1);
  const double now = is_unanchored ? counts_[kUnanchoredNow] + 1 : 0.0;
  if (now != counts_[kUnanchoredNow]) Count(kUnanchoredNow, now - counts_[kUnanchoredNow]);
}

void TrackerReport::CountTooEarly(FrameId frame_id) {
  Count("frames.bad", 1);
  if (std::exchange(too_early_reported_, true)) return;
  LogWarning("frame {} is up to a second older than the previous frame: such frames are not used", frame_id);
}

void TrackerReport::SetState(const std::string& state) {
  if (state == std::exchange(state_, state)) return;
  process_.SetState(state, warnings_);
}

void TrackerReport::LookAt(const StereoImages& images, const StereoFeatures& features, bool preselected) {
  if (IsNearlyBlack(images.left)) Count(kFramesDark, 1);
  if (preselected) return;
  // Only points: many lines are nearly parallel to the baseline and have no depth.
  const auto matched =
      std::count_if(features.points.begin(), features.points.end(), [](const auto& p) { return p.HasDepth(); });
  Count(kPointsSeen, static_cast<double>(features.points.size()));
  Count(kPointsMatched, static_cast<double>(matched));
  const auto ambiguous =
      std::count_if(features.points.begin(), features.points.end(), [](const auto& p) { return p.is_ambiguous; });
  Count(kPointsAmbiguous, static_cast<double>(ambiguous));
}

void TrackerReport::ReportWarnings() {
  static constexpr int kEvery = 20;
  if (frames() % kEvery == 0) UpdateWarnings();
}

void TrackerReport::Finish() {
  UpdateWarnings();
  SetState(process_state::kFinished);
}

bool TrackerReport::finished() const { return state_ == process_state::kFinished; }

void TrackerReport::UpdateWarnings() {
  RunFindings findings;
  findings.points_seen = counts_[kPointsSeen];
  findings.points_matched = counts_[kPointsMatched];
  findings.points_ambiguous = counts_[kPointsAmbiguous];
  findings.frames.tracked = frames();
  findings.frames_unanchored = counts_[kFramesUnanchored];
  findings.unanchored_now = counts_[kUnanchoredNow];
  findings.corner_rows_px = counts_[kCornerRows];
  findings.right_late_ms = counts_[kRightLate];
  findings.left_late_ms = counts_[kLeftLate];
  findings.late_frames = counts_[kLateFrames];
  findings.unequal_readout_ms = counts_[kUnequalReadout];
  findings.readout_ms = counts_[kReadout];
  findings.readout_path_mm = counts_[kReadoutPath];
  findings.other_readout_ms = counts_[kOtherReadout];
  findings.lens_dirt_percent = counts_[kLensDirt];
  findings.lens_dirt_u_px = counts_[kLensDirtColumn];
  findings.lens_dirt_v_px = counts_[kLensDirtRow];
  findings.right_lens_dirt_percent = counts_[kRightLensDirt];
  findings.right_lens_dirt_u_px = counts_[kRightLensDirtColumn];
  findings.right_lens_dirt_v_px = counts_[kRightLensDirtRow];
  findings.length_error_percent = counts_[kLengthError];
  findings.length_sigma_percent = counts_[kLengthSigma];
  std::string warnings;
  for (const RunWarning& warning : WarningsOf(findings)) warnings = Joined(warnings, warning.sentence);
  if (warnings == warnings_) return;
  warnings_ = std::move(warnings);
  process_.SetState(state_, warnings_);
}

void TrackerReport::ReportVerticalDisparity(const RowField& rows, const StereoCamera& camera) {
  if (vertical_disparity_reported_ || rows.is_zero()) return;
  vertical_disparity_reported_ = true;
  double most_px = 0.0;
  for (const double u_px : {0.0, camera.width_px - 1.0}) {
    for (const double v_px : {0.0, camera.height_px - 1.0}) {
      most_px = std::max(most_px, std::abs(rows.Offset_px({u_px, v_px})));
    }
  }
  Count(kCornerRows, most_px);
  LogInfo("the vertical disparity in the image corners is up to {:.1f} px: it is corrected", most_px);
}

void TrackerReport::ReportCameraErrors(const SelfCalibrator& calibration) {
  const SyncCheck& sync = calibration.sync();
  const auto tell = [this](const char* name, double value) {
    if (value > 0.0 || counts_[name] > 0.0) Count(name, std::max(value, 0.0) - counts_[name]);
  };
  tell(kRightLate, 1e3 * sync.late_s());
  tell(kLeftLate, -1e3 * sync.late_s());
  tell(kLateFrames, std::abs(sync.late_frames()));
  tell(kUnequalReadout, 1e3 * std::abs(sync.longer_readout_s()));
  const double readout_s = calibration.found_readout_s();
  if (readout_s > 0.0 && counts_[kReadout] == 0.0) {
    LogInfo(
        "the rows of an image are read within {:.1f} ms (rolling shutter), in which the camera moves {:.0f} mm: this "
        "is "
        "corrected",
        1e3 * readout_s, 1e3 * calibration.PathOfReadout_m());
  }
  tell(kReadout, 1e3 * readout_s);
  if (readout_s > 0.0) tell(kReadoutPath, std::max(counts_[kReadoutPath], 1e3 * calibration.PathOfReadout_m()));
  tell(kOtherReadout, 1e3 * calibration.contradicting_readout_s());
  const auto tell_dirt = [&](const LensDirt& dirt, const char* percent, const char* column, const char* row) {
    if (100.0 * dirt.CoveredShare() <= counts_[percent]) return;
    const Eigen::Vector2d px = dirt.Place_px();
    tell(percent, 100.0 * dirt.CoveredShare());
    tell(column, px.x());
    tell(row, px.y());
  };
  tell_dirt(calibration.lenses().left(), kLensDirt, kLensDirtColumn, kLensDirtRow);
  tell_dirt(calibration.lenses().right(), kRightLensDirt, kRightLensDirtColumn, kRightLensDirtRow);
  const auto lengths = calibration.disparities().length_error().value_or(DisparityCalibration::LengthError());
  tell(kLengthError, 100.0 * std::abs(lengths.share));
  tell(kLengthSigma, 100.0 * lengths.sigma);
}

void TrackerReport::SetImuFigures(const MotionPredictor& motion) {
  const InertialMotionModel& inertial = motion.inertial();
  if (motion.diagnosis() == nullptr || !inertial.filter().has_begun()) return;
  if (inertial.IsTrusted()) Count(kImuUsed, 1);
  process_.SetCounter(kImuInnovation, inertial.normalised_innovation());
  const TurnFit& fit = motion.diagnosis()->fit();
  process_.SetCounter(kImuDelay, 1e3 * fit.delay_s);
  process_.SetCounter(kImuDelaySigma, 1e3 * fit.delay_sigma_s);
  const ImuBiasEstimate bias = inertial.filter().Bias();
  for (size_t i = 0; i < kImuRateBias.size(); ++i) {
    const auto axis = static_cast<Eigen::Index>(i);
    process_.SetCounter(kImuRateBias[i], bias.mean.rate_rad_s[axis]);
    process_.SetCounter(kImuForceBias[i], bias.mean.force_m_s2[axis]);
  }
  process_.SetCounter(kImuRateBiasSigma, bias.rate_sigma_rad_s);
  process_.SetCounter(kImuForceBiasSigma, bias.force_sigma_m_s2);
}

void TrackerReport::ReportImu(const MotionPredictor& motion) {
  SetImuFigures(motion);
  const std::string contradiction = motion.ImuContradiction();
  if (!contradiction.empty() && !std::exchange(imu_reported_, true)) process_.Warn("imu_contradicts", contradiction);
  const std::string faults = motion.ImuSampleFaults();
  if (!faults.empty() && !std::exchange(imu_samples_reported_, true)) process_.Warn("imu_samples", faults);
}

}  // namespace plslam::vo
