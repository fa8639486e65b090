// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>

#include "camera/pairing.h"

namespace plslam::camera {

/// Quality of the frames of two cameras: values over the last few seconds (rate, skew), and counts since the start.
class CaptureHealth {
 public:
  /// `rate_hz` is the nominal rate of the cameras; 0: their most frequent rate.
  explicit CaptureHealth(double rate_hz) : nominal_hz_(rate_hz) {}

  void Add(const CapturedPair& pair);
  /// The gap between the last pair and the next one is not counted as missing frames.
  void Interrupt() { last_t_ns_.reset(); }

  double rate_hz() const;
  /// Median absolute time between the left and the right image.
  double skew_ms() const;
  int64_t pairs() const { return pairs_; }
  /// Number of frames missing between received ones.
  int64_t missing() const { return missing_; }
  /// Pairs with an image that is mostly white, or mostly black.
  int64_t overexposed() const { return overexposed_; }
  int64_t underexposed() const { return underexposed_; }

 private:
  void CountMissing(int64_t t_ns);

  double nominal_hz_;
  std::deque<int64_t> steps_ns_;
  std::deque<int64_t> skews_ns_;
  std::optional<int64_t> last_t_ns_;
  int64_t pairs_ = 0;
  int64_t missing_ = 0;
  int64_t overexposed_ = 0;
  int64_t underexposed_ = 0;
};

/// Shares of the pixels of an 8-bit grey image that are saturated or black, from each fourth row and column.
struct Exposure {
  double saturated = 0.0;
  double black = 0.0;
};
Exposure MeasureExposure(const cv::Mat& image);

}  // namespace plslam::camera
