// SPDX-License-Identifier: BSD-3-Clause
#include "core/bus/messages/map_channel.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <optional>
#include <utility>
#include <vector>

#include "plslam/map_request_t.hpp"
#include "plslam/map_update_t.hpp"

namespace plslam::bus {
namespace {

constexpr std::chrono::milliseconds kAskAgain(500);
/// Number of remembered publishers, to distinguish old ones from new ones.
constexpr size_t kMaxMapPublishers = 64;

}  // namespace

struct MapUpdatePublisher::State {
  std::function<void()> asked;
  SourceId source;
  std::atomic<int64_t> version = 0;
};

MapUpdatePublisher::MapUpdatePublisher(Bus& bus, std::function<void()> asked)
    : bus_(bus), state_(std::make_shared<State>()) {
  state_->asked = std::move(asked);
  state_->source = bus.source();
  bus.Subscribe<map_request_t>(kMapRequest, [weak = std::weak_ptr<State>(state_)](const map_request_t& request) {
    const auto state = weak.lock();
    if (state == nullptr || (request.publisher != 0 && SourceId(request.publisher) != state->source)) return;
    const int64_t known = SourceId(request.publisher) == state->source ? request.version : 0;
    if (known < state->version) state->asked();
  });
}

void MapUpdatePublisher::Publish(const MapUpdate& update) {
  std::vector<map_update_t> pages = CutIntoPages(update, bus_.page_bytes());
  const std::lock_guard lock(publishing_);
  for (map_update_t& page : pages) bus_.Publish(kMapUpdate, std::move(page));
  state_->version = update.version;
}

struct MapUpdateSubscriber::State {
  State(Bus& bus_in, std::function<void(MapUpdate)> handler_in) : bus(bus_in), handler(std::move(handler_in)) {}

  void OnPage(const map_update_t& page);
  void OnUpdate(MapUpdate update);
  void OnTick();
  void Lack();
  void Ask();
  bool IsOld(SourceId source);

  Bus& bus;
  std::function<void(MapUpdate)> handler;
  MapUpdateAssembler assembler;
  std::optional<MapVersion> known;
  /// In the order of their first messages.
  std::vector<SourceId> publishers;
  bool lacking = true;
  /// Pages of a complete map have arrived since the last tick.
  bool being_served = false;
};

bool MapUpdateSubscriber::State::IsOld(SourceId source) {
  const auto place = [this](SourceId publisher) {
    return std::find(publishers.begin(), publishers.end(), publisher);
  };
  if (place(source) == publishers.end()) {
    if (publishers.size() >= kMaxMapPublishers) publishers.erase(publishers.begin());
    publishers.push_back(source);
  }
  const auto ours = known ? place(known->numbering) : publishers.end();
  return ours != publishers.end() && place(source) < ours;
}

void MapUpdateSubscriber::State::OnPage(const map_update_t& page) {
  if (IsOld(SourceId(page.header.source))) return;
  being_served = being_served || page.base_version == 0;
  const bool is_news = !known || SourceId(page.header.source) != known->numbering || page.version > known->number;
  switch (assembler.Add(page)) {
    case PageOutcome::kTaken:
      return;
    case PageOutcome::kComplete:
      return OnUpdate(assembler.Take());
    case PageOutcome::kNonsense:
      bus.CountRejected();
      [[fallthrough]];
    case PageOutcome::kPassedOver:
      if (is_news) Lack();
  }
}

void MapUpdateSubscriber::State::OnUpdate(MapUpdate update) {
  switch (Advance(update, known)) {
    case MapStep::kKnown:
      return;
    case MapStep::kGap:
      return Lack();
    case MapStep::kNext:
      lacking = false;
      handler(std::move(update));
  }
}

void MapUpdateSubscriber::State::Lack() {
  if (!std::exchange(lacking, true)) Ask();
}

void MapUpdateSubscriber::State::OnTick() {
  if (lacking && !std::exchange(being_served, false)) Ask();
}

void MapUpdateSubscriber::State::Ask() {
  map_request_t request{};
  const SourceId newest = publishers.empty() ? SourceId() : publishers.back();
  request.publisher = newest.value;
  request.version = known && known->numbering == newest ? known->number : 0;
  bus.Publish(kMapRequest, request);
}

MapUpdateSubscriber::MapUpdateSubscriber(Bus& bus, std::function<void(MapUpdate)> handler)
    : state_(std::make_shared<State>(bus, std::move(handler))) {
  const std::weak_ptr<State> weak = state_;
  bus.Subscribe<map_update_t>(kMapUpdate, [weak](const map_update_t& page) {
    if (const auto state = weak.lock()) state->OnPage(page);
  });
  bus.Every(kAskAgain, [weak] {
    if (const auto state = weak.lock()) state->OnTick();
  });
  state_->Ask();
}

MapSubscriber::MapSubscriber(Bus& bus, std::function<void(const MapUpdate&)> handler)
    : updates_(bus, [replica = follower_, handler = std::move(handler)](const MapUpdate& update) {
        replica->Apply(update);
        handler(update);
      }) {}

}  // namespace plslam::bus
