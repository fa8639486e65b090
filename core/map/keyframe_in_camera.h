// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <utility>

#include "core/features/features_in_camera.h"
#include "core/map/keyframe.h"

namespace plslam {

/// Returns a keyframe with its features re-expressed in another camera, that of a map; nullopt if the two differ too
/// much (`AreComparable`).
inline std::optional<Keyframe> KeyframeInCamera(const StereoCamera& to, Keyframe keyframe) {
  if (!AreComparable(to, keyframe.camera)) return std::nullopt;
  keyframe.features = FeaturesInCamera(to, std::move(keyframe.features), keyframe.camera);
  keyframe.camera = to;
  return keyframe;
}

}  // namespace plslam
