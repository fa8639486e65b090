// SPDX-License-Identifier: BSD-3-Clause
#include "tools/evaluate/keyframe_error.h"

#include <algorithm>
#include <cmath>

#include "core/accuracy/consistency.h"
#include "tools/evaluate/absolute_error.h"
#include "tools/evaluate/relative_error.h"

namespace plslam {
namespace {

// Below this a relative error says more about the standing still than about the estimate.
constexpr double kMinMotion_m = 0.01;
constexpr double kDegPerRad = 180.0 / M_PI;

PosePairs SelectKeyframes(const PosePairs& pairs, const std::vector<int64_t>& keyframe_t_ns) {
  PosePairs keyframes;
  std::copy_if(pairs.begin(), pairs.end(), std::back_inserter(keyframes), [&](const PosePair& pair) {
    return std::binary_search(keyframe_t_ns.begin(), keyframe_t_ns.end(), pair.t_ns);
  });
  return keyframes;
}

}  // namespace

KeyframeErrors ComputeKeyframeErrors(const PosePairs& pairs, const std::vector<int64_t>& keyframe_t_ns) {
  const PosePairs keyframes = SelectKeyframes(pairs, keyframe_t_ns);
  std::vector<double> translation_m;
  std::vector<double> rotation_deg;
  std::vector<double> ratio;
  std::vector<double> deg_per_m;
  for (size_t i = 1; i < keyframes.size(); ++i) {
    const SE3 error = MotionError(keyframes[i - 1], keyframes[i]);
    const double distance_m = (keyframes[i].truth.translation() - keyframes[i - 1].truth.translation()).norm();
    translation_m.push_back(error.translation().norm());
    rotation_deg.push_back(kDegPerRad * AngleBetween(Eigen::Quaterniond::Identity(), error.rotation()));
    if (distance_m < kMinMotion_m) continue;
    ratio.push_back(translation_m.back() / distance_m);
    deg_per_m.push_back(rotation_deg.back() / distance_m);
  }
  const Statistics relative = Summarise(ratio);
  KeyframeErrors errors;
  errors.motions = static_cast<int>(translation_m.size());
  errors.rmse_m = Summarise(translation_m).rmse;
  errors.rmse_deg = Summarise(rotation_deg).rmse;
  errors.moving = relative.n;
  errors.relative_rmse = relative.rmse;
  errors.t_rel_percent = 100.0 * relative.mean;
  errors.R_rel_deg_per_100m = 100.0 * Summarise(deg_per_m).mean;
  return errors;
}

}  // namespace plslam
