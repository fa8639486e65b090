// SPDX-License-Identifier: BSD-3-Clause
#include "tests/integration/run_watcher.h"

#include <chrono>

#include "core/bus/run_loop.h"
#include "core/bus/transport/wire.h"
#include "core/process/process_status.h"
#include "plslam/pose_t.hpp"
#include "tests/support/sanitized.h"

namespace plslam::test {
namespace {

constexpr int kLost = 3;

bus::BusOptions On(const std::string& url) {
  bus::BusOptions options;
  options.url = url;
  return options;
}

std::vector<uint8_t> Content(pose_t pose) {
  pose.header = {};
  pose.stages.clear();
  pose.n_stages = 0;
  pose.age_ms = 0.0;
  return bus::Encoded(pose);
}

std::map<SessionId, std::set<int64_t>> KeyframesOf(const Map& map) {
  std::map<SessionId, std::set<int64_t>> keyframes;
  for (const auto& [id, keyframe] : map.keyframes()) {
    keyframes[keyframe.name.session].insert(keyframe.name.number);
  }
  return keyframes;
}

}  // namespace

double Heard::Counter(const std::string& process, const std::string& name) const {
  const auto found = status.find(process);
  return found == status.end() ? 0.0 : bus::CounterOf(found->second, name);
}

bool Heard::IsMapOf(pid_t pid) const {
  const auto found = status.find("mapping");
  return found != status.end() && found->second.pid == pid && SourceId(found->second.header.source) == map_source;
}

RunWatcher::RunWatcher() : bus_(On(port_.Url()), "watcher") {
  Listen();
  thread_ = std::thread([this] { bus_.Run(); });
}

RunWatcher::~RunWatcher() {
  bus_.Stop();
  thread_.join();
}

template <class Change>
void RunWatcher::Add(const Change& change) {
  {
    const std::scoped_lock lock(mutex_);
    change(heard_);
  }
  changed_.notify_all();
}

void RunWatcher::Listen() {
  bus_.Subscribe<pose_t>(bus::kPose, [this](const pose_t& m) {
    Add([&](Heard& heard) {
      heard.frames.insert(m.frame_id);
      heard.newest_frame = std::max(heard.newest_frame, m.frame_id);
      const auto [said, first] = heard.poses[m.header.session].try_emplace(m.frame_id, Content(m));
      if (!first) {
        ++heard.poses_said_again;
        if (said->second != Content(m)) ++heard.poses_said_otherwise;
        return;
      }
      heard.pose_at_s.try_emplace(m.frame_id, bus::NowS());
      if (m.state == kLost) ++heard.lost_frames;
    });
  });
  bus_.Subscribe<status_t>(bus::kStatus, [this](const status_t& m) {
    Add([&](Heard& heard) {
      heard.status[m.process] = m;
      const std::pair process(m.process, m.pid);
      heard.alive_at_s.try_emplace(process, bus::NowS());
      if (m.state == "running") heard.running_at_s.try_emplace(process, bus::NowS());
      if (m.state == "ready" || m.state == "running") heard.ready.emplace(m.process, m.pid);
    });
  });
  keyframes_ = std::make_unique<bus::KeyframeSubscriber>(bus_, [this](const Keyframe& keyframe) {
    Add([&](Heard& heard) { heard.keyframes[keyframe.name.session].insert(keyframe.name.number); });
  });
  map_ = std::make_unique<bus::MapSubscriber>(bus_, [this](const MapUpdate&) {
    auto keyframes = KeyframesOf(map_->follower().map());
    Add([&](Heard& heard) {
      heard.mapped = std::move(keyframes);
      heard.map_source = map_->follower().version()->numbering;
    });
  });
}

bool RunWatcher::WaitFor(const std::function<bool(const Heard&)>& done, int limit_s) const {
  std::unique_lock lock(mutex_);
  return changed_.wait_for(lock, Patience(std::chrono::seconds(limit_s)), [&] { return done(heard_); });
}

bool RunWatcher::WaitForFrame(int64_t frame_id, int limit_s) const {
  return WaitFor([frame_id](const Heard& heard) { return heard.newest_frame >= frame_id; }, limit_s);
}

bool RunWatcher::WaitUntilReady(const std::string& process, pid_t pid, int limit_s) const {
  return WaitFor([&](const Heard& heard) { return heard.ready.contains({process, pid}); }, limit_s);
}

Heard RunWatcher::Get() const {
  const std::scoped_lock lock(mutex_);
  return heard_;
}

}  // namespace plslam::test
