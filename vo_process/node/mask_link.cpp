// SPDX-License-Identifier: BSD-3-Clause
#include "vo_process/node/mask_link.h"

#include <algorithm>
#include <chrono>

#include "core/bus/messages/convert.h"
#include "core/bus/run_loop.h"
#include "plslam/mask_t.hpp"

namespace plslam::vo {
namespace {

// Number of masks kept for frames to come, and the period of checks of waits.
constexpr size_t kMaxMasks = 64;
constexpr std::chrono::milliseconds kTick(5);
// Frames in a row without a mask after which that is reported: a detector may start later than the cameras.
constexpr int kReportAfter = 20;
constexpr const char* kNoMasks =
    "masks do not arrive (vo.masks.enabled, channel MASK), so frames are tracked without them: does the detector run "
    "on the same bus, with the same prefix?";

}  // namespace

MaskLink::MaskLink(bus::Process& process, const MaskUseOptions& options, std::function<void()> on_arrival)
    : process_(process),
      options_(options),
      on_arrival_(std::move(on_arrival)),
      wait_(process.bus().options().partner_wait_s) {
  process.bus().Subscribe<mask_t>(bus::kMask, [this, &process](const mask_t& message) {
    const auto mask = bus::FromMessage(message);
    if (!mask) return process.bus().CountRejected();
    wait_.OnSignOfLife(bus::NowS());
    masks_.emplace_back(FrameName(FrameId(message.frame_id), message.header.t_ns), *mask);
    if (masks_.size() > kMaxMasks) masks_.pop_front();
    on_arrival_();
  });
  process.bus().Every(kTick, [this] {
    if (wait_.GiveUp(bus::NowS())) process_.Warn("masks_missing", kNoMasks);
    on_arrival_();
  });
}

std::deque<std::pair<MaskLink::FrameName, FrameMask>>::iterator MaskLink::Find(const FrameName& frame) {
  return std::find_if(masks_.begin(), masks_.end(), [&frame](const auto& mask) { return mask.first == frame; });
}

bool MaskLink::Awaits(const FrameName& frame, bool lockstep, double came_s) {
  if (Find(frame) != masks_.end()) return false;
  const double now_s = bus::NowS();
  if (!lockstep) return now_s - came_s < 1e-3 * options_.live_wait_ms;
  if (std::exchange(awaited_, frame) != frame) wait_.Begin(frame.first.value, now_s);
  return wait_.awaited().has_value();
}

std::optional<FrameMask> MaskLink::Take(const FrameName& frame) {
  wait_.End();
  const auto mask = Find(frame);
  if (mask == masks_.end()) {
    if (++n_in_a_row_ == kReportAfter) process_.Warn("masks_missing", kNoMasks);
    return std::nullopt;
  }
  n_in_a_row_ = 0;
  FrameMask found = std::move(mask->second);
  masks_.erase(mask);
  return found;
}

}  // namespace plslam::vo
