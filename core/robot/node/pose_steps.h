// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>

#include "plslam/pose_t.hpp"

namespace plslam::robot {

/// The time steps between poses of one stream.
class PoseSteps {
 public:
  /// Returns the time since the previous pose, to which the motion refers; nullopt if that pose was not received.
  std::optional<double> SecondsSinceLast(const pose_t& message) {
    const header_t& header = message.header;
    const bool follows = header.source == last_source_ && header.session == last_session_ &&
                         header.seq == last_seq_ + 1 && header.t_ns > last_t_ns_;
    const double dt_s = 1e-9 * static_cast<double>(header.t_ns - last_t_ns_);
    last_source_ = header.source;
    last_session_ = header.session;
    last_seq_ = header.seq;
    last_t_ns_ = header.t_ns;
    return follows ? std::optional(dt_s) : std::nullopt;
  }

 private:
  int64_t last_source_ = 0, last_session_ = 0, last_seq_ = 0, last_t_ns_ = 0;
};

}  // namespace plslam::robot
