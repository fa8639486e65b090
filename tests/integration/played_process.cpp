// SPDX-License-Identifier: BSD-3-Clause
#include "tests/integration/played_process.h"

#include <chrono>
#include <stdexcept>

#include "plslam/camera_t.hpp"
#include "plslam/ground_truth_t.hpp"
#include "plslam/image_strip_t.hpp"
#include "plslam/keyframe_t.hpp"
#include "plslam/loop_closure_t.hpp"
#include "plslam/pose_t.hpp"
#include "plslam/relocalisation_t.hpp"
#include "plslam/status_t.hpp"
#include "plslam/stream_t.hpp"
#include "plslam/tracks_t.hpp"

namespace plslam::test {
namespace {

/// More often than a process publishes its status (1 Hz), so that one lost message is not missed.
constexpr std::chrono::milliseconds kRepeat(400);

template <class Message>
void PublishAs(bus::Bus& bus, const bus::Channel& channel, bus::ByteView bytes) {
  bus.Publish(channel, MessageOf<Message>(bytes));
}

/// The types that are only passed on.
using Publish = void (*)(bus::Bus&, const bus::Channel&, bus::ByteView);
const std::map<std::string_view, Publish> kPublish = {
    {"camera_t", PublishAs<camera_t>},
    {"stream_t", PublishAs<stream_t>},
    {"image_strip_t", PublishAs<image_strip_t>},
    {"ground_truth_t", PublishAs<ground_truth_t>},
    {"pose_t", PublishAs<pose_t>},
    {"tracks_t", PublishAs<tracks_t>},
    {"keyframe_t", PublishAs<keyframe_t>},
    {"loop_closure_t", PublishAs<loop_closure_t>},
    {"relocalisation_t", PublishAs<relocalisation_t>},
    {"status_t", PublishAs<status_t>},
};

}  // namespace

bus::BusOptions BusOptionsFor(const std::string& url) {
  bus::BusOptions options;
  options.url = url;
  return options;
}

PlayedProcess::PlayedProcess(const bus::BusOptions& options, const std::string& name)
    : bus_(options, name), map_publisher_(bus_, [this] { map_is_asked_for_ = true; }) {
  bus_.Every(kRepeat, [this] {
    const std::scoped_lock lock(mutex_);
    for (const auto& [key, said] : newest_) kPublish.at(said.first->type)(bus_, *said.first, said.second);
  });
  thread_ = std::thread([this] { bus_.Run(); });
}

PlayedProcess::~PlayedProcess() {
  bus_.Stop();
  thread_.join();
}

void PlayedProcess::Say(const bus::Channel& channel, bus::ByteView message) {
  if (channel.type == "map_update_t") return SayMap(MessageOf<map_update_t>(message));
  if (channel.delivery == bus::Delivery::kLatest) {
    const std::scoped_lock lock(mutex_);
    newest_[channel.name] = {&channel, {message.begin(), message.end()}};
  }
  kPublish.at(channel.type)(bus_, channel, message);
}

void PlayedProcess::SayMap(const map_update_t& page) {
  if (assembler_.Add(page) != bus::PageOutcome::kComplete) return;
  last_update_ = assembler_.Take();
  map_.Apply(last_update_);
  map_publisher_.Publish(last_update_);
}

void PlayedProcess::AnswerMapRequests() {
  if (!map_is_asked_for_.exchange(false)) return;
  MapUpdate whole = WholeMap(map_.map());
  whole.version = last_update_.version;
  whole.newest = last_update_.newest;
  whole.t_ns = last_update_.t_ns;
  whole.committed = last_update_.committed;
  whole.answer = last_update_.answer;
  whole.adjustment = last_update_.adjustment;
  whole.map_id = last_update_.map_id;
  map_publisher_.Publish(whole);
}

Doubler::Doubler(const std::string& url, std::set<SourceId> sources) : sources_(std::move(sources)), transport_(url) {
  transport_.SetReceiver([this](std::string_view channel, bus::ByteView bytes) { Double(channel, bytes); });
  transport_.ListenToAll();
  thread_ = std::thread([this] {
    while (!stopping_) transport_.Receive(100);
  });
}

Doubler::~Doubler() {
  stopping_ = true;
  transport_.Wake();
  thread_.join();
}

void Doubler::Double(std::string_view channel, bus::ByteView bytes) {
  if (bytes.size() < bus::kWireHeaderBytes) return;
  const bus::WireHeader header = bus::ReadHeader(bytes);
  // The process receives its own messages back.
  if (!sources_.contains(header.source) || !doubled_.emplace(channel, header.source, header.seq).second) return;
  transport_.Send(std::string(channel), bytes);
}

}  // namespace plslam::test
