// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <optional>
#include <utility>

#include "core/geometry/calibration.h"
#include "core/process/partner_wait.h"
#include "core/process/process.h"
#include "vo_process/options.h"

namespace plslam::vo {

/// A tracker's link to the program that masks regions of single frames (channel MASK); masks that do not arrive are
/// reported once. In lockstep a frame waits until its mask arrives, or no mask has been received for
/// `bus.partner_wait_s`; live for `live_wait_ms` after the frame arrived.
class MaskLink {
 public:
  /// Frame number and time.
  using FrameName = std::pair<FrameId, int64_t>;

  /// `on_arrival` is called when a mask has arrived, or a wait may be over.
  MaskLink(bus::Process& process, const MaskUseOptions& options, std::function<void()> on_arrival);

  /// Whether the frame, which arrived at `came_s` of the steady clock, has to wait.
  bool Awaits(const FrameName& frame, bool lockstep, double came_s);
  /// Removes and returns the mask of a frame after its wait; nullopt if it has none.
  std::optional<FrameMask> Take(const FrameName& frame);

 private:
  std::deque<std::pair<FrameName, FrameMask>>::iterator Find(const FrameName& frame);

  bus::Process& process_;
  MaskUseOptions options_;
  std::function<void()> on_arrival_;
  /// In the order of arrival.
  std::deque<std::pair<FrameName, FrameMask>> masks_;
  bus::PartnerWait wait_;
  FrameName awaited_{-1, 0};
  int n_in_a_row_ = 0;  ///< frames without a mask since the last one with it
};

}  // namespace plslam::vo
