// SPDX-License-Identifier: BSD-3-Clause
#include "vo_process/node/mask_link.h"

#include <spdlog/spdlog.h>

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

}  // namespace

MaskLink::MaskLink(bus::Bus& bus, const MaskUseOptions& options, std::function<void()> on_arrival)
    : options_(options), on_arrival_(std::move(on_arrival)), wait_(options.wait_s) {
  bus.Subscribe<mask_t>(bus::kMask, [this, &bus](const mask_t& message) {
    const auto mask = bus::FromMessage(message);
    if (!mask) return bus.CountRejected();
    wait_.OnSignOfLife(bus::NowS());
    masks_.emplace_back(FrameName(message.frame_id, message.header.t_ns), *mask);
    if (masks_.size() > kMaxMasks) masks_.pop_front();
    on_arrival_();
  });
  bus.Every(kTick, [this] {
    if (wait_.GiveUp(bus::NowS())) spdlog::warn("no masks arrive: frames are processed without masks");
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
  if (std::exchange(awaited_, frame) != frame) wait_.Begin(frame.first, now_s);
  return wait_.awaited().has_value();
}

std::optional<FrameMask> MaskLink::Take(const FrameName& frame) {
  wait_.End();
  const auto mask = Find(frame);
  if (mask == masks_.end()) return std::nullopt;
  FrameMask found = std::move(mask->second);
  masks_.erase(mask);
  return found;
}

}  // namespace plslam::vo
