// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
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

/// A frame of a stream: its number, and its time, because another stream has the same numbers.
struct FrameName {
  FrameId id;
  int64_t t_ns = 0;
  bool operator==(const FrameName&) const = default;
};

/// A keyframe that can be fused, and what was received of its frame.
struct ReadyKeyframe {
  Keyframe keyframe;
  StereoImages images;
  FrameMask mask;     ///< of a detector; empty: none
  BodyPixels bodies;  ///< of moving bodies; empty: none
};

/// Keyframes that wait for their images, for what the tracker found in them (a moving body must not become a wall), and
/// for their place in the map; and the frames received last, which wait for their keyframe. If too many keyframes wait,
/// the oldest are dropped and counted: first incomplete ones, then live ones.
class WaitingKeyframes {
 public:
  /// Frames that are kept. A tracker announces the keyframe of a frame before it tracks the next one; live, a few
  /// frames later.
  static constexpr size_t kMostFrames = 24;
  static constexpr size_t kMostWaiting = 24;

  /// Return whether a keyframe of this frame waits.
  bool AddImages(const StereoImages& images);
  bool AddBodies(const FrameName& frame, const BodyPixels& bodies);
  void AddMask(const FrameName& frame, const FrameMask& mask);
  /// Replaces a keyframe of the same session and frame.
  void Add(const Keyframe& keyframe);

  /// Whether images and bodies of a keyframe have been received.
  bool HasComplete() const;
  /// Takes these keyframes if they satisfy `is_placed`, by session and frame.
  std::vector<ReadyKeyframe> Take(const std::function<bool(const Keyframe&)>& is_placed);
  /// Drops all keyframes, which are not counted; frames stay.
  void Clear() { keyframes_.clear(); }

  bool empty() const { return keyframes_.empty(); }
  size_t size() const { return keyframes_.size(); }
  /// Dropped keyframes that were not complete, and others.
  int64_t n_incomplete() const { return n_incomplete_; }
  int64_t n_dropped() const { return n_dropped_; }

 private:
  /// The received parts of a frame.
  struct Frame {
    FrameName name;
    std::optional<StereoImages> images;
    FrameMask mask;
    std::optional<BodyPixels> bodies;  ///< empty: there are none

    bool IsComplete() const { return images && bodies; }
  };
  struct Waiting {
    Keyframe keyframe;
    Frame frame;
  };

  Frame& FrameOf(const FrameName& name);
  template <class Set>
  bool ForEach(const FrameName& name, const Set& set);
  void DropOldest();

  std::map<KeyframeFrame, Waiting> keyframes_;
  std::deque<Frame> frames_;  ///< in the order of their first message
  int64_t n_incomplete_ = 0;
  int64_t n_dropped_ = 0;
};

}  // namespace plslam::dense
