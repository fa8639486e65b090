// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <deque>
#include <string>
#include <utility>
#include <vector>

namespace plslam::ros2 {

/// Compares the number of images that arrive with the one that their stamps promise: large messages over UDP are lost
/// whole if one of their parts does not fit into the receive buffer.
///
/// A long step is a gap, unless it is one of eight equal ones in a row, before or after the short ones: then the camera
/// takes fewer images, as with a longer exposure in the dark.
class ImageRate {
 public:
  /// An image with this stamp arrived at `now_s`.
  void Add(int64_t t_ns, double now_s);

  struct Rates {
    double sent_hz = 0.0;     ///< by the steps between stamps that are without a gap
    double arrived_hz = 0.0;  ///< of the last five seconds
    int64_t from_ns = 0;      ///< stamps for which `sent_hz` is the rate
    int64_t to_ns = 0;
  };
  /// Both rates are 0 if fewer than 10 images arrived within the last five seconds.
  Rates Of(double now_s);

  /// Counts the images that are missing between those that have arrived, by the gaps of their stamps at this rate;
  /// steps after its time are counted later. DDS does not count what best-effort readers miss. Gaps of more than two
  /// seconds do not count: the camera may have been off.
  void CountMissing(const Rates& rates);
  int64_t n_missing() const { return n_missing_; }

 private:
  struct Step {
    int64_t end_ns = 0;  ///< stamp of the later image
    int64_t step_ns = 0;
  };

  std::vector<Step> new_steps_;  ///< not counted yet
  int64_t n_missing_ = 0;
  std::deque<std::pair<int64_t, double>> arrivals_;
};

/// Returns a sentence if less than nine tenths of the images arrive, else an empty text. `pair_bytes` are those of the
/// images of a frame, `buffer_bytes` what the kernel grants.
std::string LossSentence(const ImageRate::Rates& rates, int64_t pair_bytes, int64_t buffer_bytes);

/// Returns a sentence if the buffer is too small for pairs of raw images of a small camera, else an empty text: for the
/// start, when the robot's images are not known yet.
std::string SmallBufferSentence(int64_t buffer_bytes);

}  // namespace plslam::ros2
