// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "core/bus/bus.h"
#include "core/bus/messages/pager.h"
#include "core/map/loop_closure.h"
#include "plslam/loop_closure_t.hpp"
#include "plslam/relocalisation_t.hpp"

namespace plslam::bus {

/// `closure` as pages of at most `page_bytes`. Throws std::invalid_argument for content that readers would reject:
/// non-finite numbers, poses or names that do not ascend.
std::vector<loop_closure_t> CutIntoPages(const LoopClosure& closure, int64_t page_bytes);

/// Puts loop closures together again.
class LoopClosureAssembler : public PageAssembler<loop_closure_t, LoopClosure> {
 public:
  LoopClosureAssembler();
};

/// Publishes the results of loop_process. Safe from any thread.
class LoopClosurePublisher {
 public:
  explicit LoopClosurePublisher(Bus& bus) : bus_(bus) {}
  void Publish(const LoopClosure& closure);

 private:
  Bus& bus_;
  std::mutex publishing_;  // pages of two closures must not mix
};

/// Hands every closure of every publisher to `handler`, in order, on the thread of `Bus::Run`. Pages that cannot be
/// are counted in `BusCounters::rejected`.
class LoopClosureSubscriber {
 public:
  LoopClosureSubscriber(Bus& bus, std::function<void(const LoopClosure&)> handler);

 private:
  std::shared_ptr<void> subscription_;
};

/// The session and the time go into the header.
relocalisation_t ToMessage(const Relocalisation& relocalisation);
std::optional<Relocalisation> FromMessage(const relocalisation_t& message);

}  // namespace plslam::bus
