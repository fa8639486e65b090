// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <vector>

#include "core/geometry/calibration.h"
#include "core/ids/ids.h"
#include "core/io/images/image_file.h"
#include "core/map/keyframe.h"
#include "dense_process/body_mask.h"
#include "dense_process/dense_map.h"

namespace plslam::dense {

/// A keyframe that can be fused, and what was received of its frame.
struct ReadyKeyframe {
  Keyframe keyframe;
  StereoImages images;
  FrameMask mask;     ///< of a detector; empty: none
  BodyPixels bodies;  ///< of moving bodies; empty: none
};

/// Keyframes that wait for their images and for their place in the map, and the newest frames, which wait for their
/// keyframe. If too many keyframes wait, the oldest are dropped and counted: first those without images, then live
/// ones.
class WaitingKeyframes {
 public:
  /// Frames that are kept. A tracker announces the keyframe of a frame before it tracks the next one; live, a few
  /// frames later.
  static constexpr size_t kMostFrames = 12;
  static constexpr size_t kMostWaiting = 24;

  /// Returns whether a keyframe has waited for these images.
  bool AddImages(const StereoImages& images);
  void AddBodies(FrameId frame_id, BodyPixels bodies);
  void AddMask(FrameId frame_id, const FrameMask& mask);
  /// Replaces a keyframe of the same session and frame.
  void Add(const Keyframe& keyframe);

  /// Takes the keyframes that have images and satisfy `is_placed`, by session and frame.
  std::vector<ReadyKeyframe> Take(const std::function<bool(const Keyframe&)>& is_placed);
  /// Drops all keyframes, which are not counted; frames stay.
  void Clear() { keyframes_.clear(); }

  bool empty() const { return keyframes_.empty(); }
  size_t size() const { return keyframes_.size(); }
  /// Dropped keyframes without images, and with images.
  int64_t n_without_images() const { return n_without_images_; }
  int64_t n_dropped() const { return n_dropped_; }

 private:
  struct Waiting {
    Keyframe keyframe;
    std::optional<StereoImages> images;
  };

  void DropOldest();

  std::map<KeyframeFrame, Waiting> keyframes_;
  std::map<FrameId, StereoImages> frames_;
  std::map<FrameId, BodyPixels> bodies_;
  std::map<FrameId, FrameMask> masks_;
  int64_t n_without_images_ = 0;
  int64_t n_dropped_ = 0;
};

}  // namespace plslam::dense
