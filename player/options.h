// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>

#include "core/config/fields.h"
#include "core/datasets/dataset_kinds.h"
#include "core/run/process_names.h"

namespace plslam::player {

/// The dataset to play, the pace, and the range of frames. Frames are numbered as in the dataset.
struct PlayerOptions {
  std::string dataset;
  std::string kind;
  std::string pace = stream_pace::kLockstep;
  int64_t start = 0;
  int64_t stop = -1;
  int64_t stride = 1;
  int64_t loop = 1;
  int64_t right_offset_frames = 0;
  bool bounce = false;
  bool skip_bad = false;
  bool exit = false;
  /// Mask images for the left and the right images, in pixels as recorded: 0 (black) is masked out.
  std::string mask_left;
  std::string mask_right;
  /// Resume after this frame, "ID@T_NS" as in its pose, or "bus", the newest frame that has a pose on the bus: the
  /// frames up to it have been sent. Empty: from the start.
  std::string resume_after;
  /// Send no new frame before a command to resume.
  bool paused = false;
};

inline OneOf KindOrNone() {
  OneOf names{{""}};
  for (const DatasetKind& kind : DatasetKinds()) names.values.emplace_back(kind.name);
  return names;
}

template <class Visitor>
void VisitFields(Visitor& visit, PlayerOptions& o) {
  visit("dataset", o.dataset, DatasetHelp().c_str());
  visit("kind", o.kind, KindOrNone(), "format of the dataset; empty: recognised from its files");
  visit("pace", o.pace, "lockstep (each frame waits for the pose of the previous one), realtime, or realtimexN");
  visit("start", o.start, Bounds{0, 1e9}, "first frame");
  visit("stop", o.stop, Bounds{-1, 1e9}, "frame before which to stop; -1: the end");
  visit("stride", o.stride, Bounds{1, 1e9}, "play every n-th frame");
  visit("loop", o.loop, Bounds{1, 1e6}, "number of times to play the dataset, with continuous times and frame ids");
  visit("right_offset_frames", o.right_offset_frames, Bounds{-1e6, 1e6},
        "pair each left image with the right image of this many frames later (negative: earlier)");
  visit("bounce", o.bounce, "play forth and back each time, so that the path closes");
  visit("skip_bad", o.skip_bad, "skip unreadable frames, and count them");
  visit("exit", o.exit, "exit when all frames are sent and acknowledged");
  visit("mask_left", o.mask_left, "mask of the left camera: no features where the image is black (0)");
  visit("mask_right", o.mask_right, "mask of the right camera, likewise");
  visit("resume_after", o.resume_after,
        "continue after this frame (ID@T_NS), or after the newest pose on the bus (bus)");
  visit("paused", o.paused, "begin paused: send no frame before `plslam resume`");
}

}  // namespace plslam::player
