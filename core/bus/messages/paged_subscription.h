#pragma once

#include <functional>
#include <memory>
#include <utility>

#include "core/bus/bus.h"
#include "core/bus/messages/page_assembler.h"

namespace plslam::bus {

/// Hands every value that comes over `channel` by pages to `handler`, on the thread of `Bus::Run`, until what is returned goes
/// away. Pages that cannot be, or that go on with what never began, are counted in `BusCounters::rejected`.
template <class Page, class Assembler, class Value>
std::shared_ptr<void> SubscribePaged(Bus& bus, const Channel& channel, std::function<void(const Value&)> handler) {
  struct State {
    Assembler assembler;
    std::function<void(const Value&)> handler;
  };
  const auto state = std::make_shared<State>();
  state->handler = std::move(handler);
  bus.Subscribe<Page>(channel, [&bus, weak = std::weak_ptr<State>(state)](const Page& page) {
    const auto still = weak.lock();
    if (still == nullptr) return;
    const PageOutcome outcome = still->assembler.Add(page);
    if (outcome == PageOutcome::kNonsense || outcome == PageOutcome::kPassedOver) bus.CountRejected();
    if (outcome == PageOutcome::kComplete) still->handler(still->assembler.Take());
  });
  return state;
}

}  // namespace plslam::bus
