// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <utility>

#include "core/features/told_in.h"
#include "core/map/keyframe.h"

namespace plslam {

/// Returns a keyframe with its features re-expressed in another camera, that of a map; nullopt if the two differ too
/// much (`CanBeToldIn`).
inline std::optional<Keyframe> ToldIn(const StereoCamera& to, Keyframe keyframe) {
  if (!CanBeToldIn(to, keyframe.camera)) return std::nullopt;
  keyframe.features = ToldIn(to, std::move(keyframe.features), keyframe.camera);
  keyframe.camera = to;
  return keyframe;
}

}  // namespace plslam
