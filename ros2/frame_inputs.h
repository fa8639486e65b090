// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "core/robot/frame_progress.h"
#include "core/robot/stamp_pairing.h"
#include "ros2/diagnosis.h"

namespace plslam::ros2 {

/// The topics of images and CameraInfo, and what they have received since frames were sent last: the symptoms of frames
/// that are missing.
class FrameInputs {
 public:
  explicit FrameInputs(double now_s) : progress_(now_s) {}

  /// `reader`: its number in the participant.
  void SetImages(robot::Side side, const std::string& topic, const std::string& type, size_t reader);
  void AddInfo(const std::string& topic, size_t reader);

  /// An image with this stamp has arrived.
  void OnImage(robot::Side side, int64_t t_ns);
  /// A message was rejected. Returns their number since the start.
  int64_t OnRejected() { return ++n_rejected_; }
  void ReadStates(const std::function<ReaderState(size_t reader)>& state_of);

  /// Returns whether frames were sent since the last call; then messages are counted from here on, and no reason is
  /// known. `n_sent`: frames since the start.
  bool HasProgress(int64_t n_sent, double now_s);
  bool AreLate(double now_s) const { return progress_.IsLate(now_s); }
  /// Returns topics, states and rejected messages, as they are since the last progress.
  Symptoms SinceProgress() const;
  /// Records why there are no frames, and returns the reason before; empty: none since the last progress.
  std::string SetReason(const std::string& why);
  bool has_reason() const { return !reason_.empty(); }

 private:
  struct Reader {
    Input input;
    size_t number = 0;
    int64_t n_before = 0;  ///< messages at the last progress
  };

  std::array<Reader, 2> sides_;
  std::vector<Reader> infos_;
  int64_t n_rejected_ = 0;
  int64_t n_rejected_before_ = 0;  ///< at the last progress
  robot::FrameProgress progress_;
  std::string reason_;
};

}  // namespace plslam::ros2
