// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <optional>
#include <utility>

#include "core/bus/bus.h"
#include "core/geometry/calibration.h"
#include "core/process/partner_wait.h"
#include "vo_process/options.h"

namespace plslam::vo {

/// A tracker's link to whoever says what is to be left out of single frames (channel MASK). In lockstep a frame waits
/// for its mask until that comes, or nobody has been heard of for `wait_s`; live for `live_wait_ms` after the frame
/// has come.
class MaskLink {
 public:
  /// Number and time.
  using FrameName = std::pair<int64_t, int64_t>;

  /// `go_on`: a mask has come, or a wait may be over.
  MaskLink(bus::Bus& bus, const MaskUseOptions& options, std::function<void()> go_on);

  /// Whether the frame, which came at `came_s` of the steady clock, has to wait.
  bool Awaits(const FrameName& frame, bool lockstep, double came_s);
  /// The mask of a frame that waits no longer, once; nullopt: it has none.
  std::optional<FrameMask> Take(const FrameName& frame);

 private:
  std::deque<std::pair<FrameName, FrameMask>>::iterator Find(const FrameName& frame);

  MaskUseOptions options_;
  std::function<void()> go_on_;
  /// In the order in which they came.
  std::deque<std::pair<FrameName, FrameMask>> masks_;
  bus::PartnerWait wait_;
  FrameName awaited_{-1, 0};
};

}  // namespace plslam::vo
