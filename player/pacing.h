// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "player/options.h"

namespace plslam::player {

/// The frames in playing order, with continuing times: each pass over the dataset follows the previous one at the mean
/// step between frames; on the way back (`bounce`) times continue by the same steps.
class PlayOrder {
 public:
  struct Item {
    int index = 0;
    int64_t t_ns = 0;
  };

  /// Returns the time of a frame of the dataset: increasing, and called when the frame is played, since some datasets
  /// read it from a file.
  using TimeOf = std::function<int64_t(int index)>;

  /// `rate_hz` is used if only one frame is played. Throws std::runtime_error if the options leave no frame.
  PlayOrder(int64_t n_frames, TimeOf time_of, const PlayerOptions& options, double rate_hz);

  /// Number of items in all.
  int64_t size() const { return size_; }
  /// The frames of the dataset that are played, each once.
  const std::vector<int>& pass() const { return pass_; }
  std::optional<Item> Next();
  /// Skips the frames that are not later than `t_ns`; returns their number.
  int64_t SkipTo(int64_t t_ns);
  /// Mean time step of the played frames.
  int64_t period_ns() const { return period_ns_; }

 private:
  size_t Position(int64_t step) const;
  int64_t MeanPeriod(double rate_hz) const;

  TimeOf time_of_;
  std::vector<int> pass_;
  bool bounce_;
  int64_t size_;
  int64_t period_ns_;
  int64_t step_ = 0;
  int64_t t_ns_ = 0;
};

}  // namespace plslam::player
