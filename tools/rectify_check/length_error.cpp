// SPDX-License-Identifier: BSD-3-Clause
#include "tools/rectify_check/length_error.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "core/run/run_warnings.h"
#include "core/run/tracking_state.h"
#include "vo_process/stereo/stereo_front_end.h"
#include "vo_process/tracking/odometry.h"

namespace plslam::rectify_check {
namespace {

/// Offsets of real sequences are proved within 30 to 75 frames; 200 take 3 to 8 seconds.
constexpr int kMostFrames = 200;

/// Fewer tracked frames than these show no motion.
constexpr int kLeastFrames = 3;

}  // namespace

std::string Sentence(const LengthError& error) {
  if (error.tracked < kLeastFrames) {
    return fmt::format("disparities were not measured: only {} of {} frames could be tracked", error.tracked,
                       error.frames);
  }
  if (!error.percent) {
    return fmt::format("no offset of the disparities was found (lengths: sigma {:.1g} %)", error.sigma_percent);
  }
  RunFindings findings;
  findings.length_error_percent = *error.percent;
  findings.length_sigma_percent = error.sigma_percent;
  for (const RunWarning& warning : WarningsOf(findings)) return warning.sentence;
  return fmt::format(
      "disparities have an offset that would change lengths at the median depth by {:.0f} % (sigma {:.1g} %): it is "
      "corrected",
      *error.percent, error.sigma_percent);
}

LengthError MeasureLengthError(const Dataset& dataset, const RigCalibration& rig) {
  const vo::VoOptions options;
  vo::StereoFrontEnd front_end(rig, options);
  vo::Odometry odometry(front_end.camera(), options, front_end.shutter());
  LengthError result;
  result.frames = std::min(dataset.size(), kMostFrames);
  for (int i = 0; i < result.frames; ++i) {
    const StereoImages images = dataset.Read(i);
    vo::StageTimer timer;
    StereoFeatures features = odometry.SeePair(front_end, images, timer);
    const vo::OdometryResult frame = odometry.Track(images.t_ns, std::move(features));
    if (IsTracked(frame.state, frame.keyframe ? frame.keyframe->id : -1)) ++result.tracked;
  }
  const vo::DisparityCalibration& disparities = odometry.calibration().disparities();
  result.sigma_percent = 100.0 * disparities.LengthSigma();
  if (const auto error = disparities.length_error()) {
    result.percent = 100.0 * std::abs(error->share);
    result.sigma_percent = 100.0 * error->sigma;
  }
  return result;
}

}  // namespace plslam::rectify_check
