// SPDX-License-Identifier: BSD-3-Clause
#include "viewer_headless/node/logged_run.h"

#include <algorithm>
#include <map>
#include <optional>
#include <set>
#include <stdexcept>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/bus/channels.h"
#include "core/bus/logs/log_reader.h"
#include "core/bus/messages/convert.h"
#include "core/bus/messages/map_pages.h"
#include "core/bus/transport/wire.h"
#include "core/geometry/rectification.h"
#include "core/map/map_update.h"
#include "plslam/camera_t.hpp"
#include "plslam/ground_truth_t.hpp"
#include "plslam/map_update_t.hpp"
#include "plslam/pose_t.hpp"
#include "viewer_headless/node/message_values.h"
#include "viewer_headless/outputs.h"
#include "viewer_headless/recorder.h"

namespace plslam::viewer {
namespace {

/// Where a message stands in the log.
struct Place {
  int64_t offset = 0;
  int64_t bytes = 0;
};

/// Messages of one channel without those that came twice: by publisher, in the order in which these were heard first,
/// and by number. A repaired message stands in the log behind those that came after it.
class LoggedMessages {
 public:
  void Add(const bus::LogReader::Event& event) {
    const bus::WireHeader header = bus::ReadHeader(event.head);
    const auto known = std::find(sources_.begin(), sources_.end(), header.source);
    const auto rank = static_cast<size_t>(known - sources_.begin());
    if (known == sources_.end()) sources_.push_back(header.source);
    places_.try_emplace({rank, header.seq}, Place{event.data_offset, event.data_bytes});
  }
  size_t size() const { return places_.size(); }

  /// Those that are whole, one after the other.
  template <class Message, class Take>
  void ForEach(const bus::LogReader& log, Take take) const {
    const MessageLayout* const layout = FindMessageLayout(Message::getTypeName());
    for (const auto& [key, place] : places_) {
      const auto data = log.Data(place.offset, std::min<int64_t>(place.bytes, bus::kMaxMessageBytes));
      if (!data || !bus::MessageLength(*layout, *data)) continue;
      if (const auto message = bus::Decoded<Message>(*data)) take(*message);
    }
  }

 private:
  std::vector<int64_t> sources_;
  std::map<std::pair<size_t, int64_t>, Place> places_;
};

/// What a log has of one robot.
struct LoggedRobot {
  LoggedMessages cameras, poses, truths, bodies, map_updates;
};

/// A channel that is read, with the fingerprint of its messages in this version.
struct ReadChannel {
  bus::Channel channel;
  int64_t fingerprint;
  LoggedMessages LoggedRobot::*messages;
};
const std::vector<ReadChannel>& ReadChannels() {
  static const std::vector<ReadChannel> kChannels{
      {bus::kCamera, camera_t::getHash(), &LoggedRobot::cameras},
      {bus::kPose, pose_t::getHash(), &LoggedRobot::poses},
      {bus::kGroundTruth, ground_truth_t::getHash(), &LoggedRobot::truths},
      {bus::kBodies, bodies_t::getHash(), &LoggedRobot::bodies},
      {bus::kMapUpdate, map_update_t::getHash(), &LoggedRobot::map_updates}};
  return kChannels;
}

struct LoggedRobots {
  std::map<std::string, LoggedRobot> by_prefix;
  bool has_frames = false;
  /// Channels with messages of another version of plslam.
  std::set<std::string_view> of_other_versions;
};

LoggedRobots ReadRobots(bus::LogReader& log) {
  LoggedRobots robots;
  while (const auto event = log.Next()) {
    for (const bus::Channel& channel : {bus::kStereoFrame, bus::kStereoFrameLive}) {
      robots.has_frames |= event->channel.ends_with(channel.name);
    }
    for (const ReadChannel& read : ReadChannels()) {
      const std::string_view name = read.channel.name;
      if (!event->channel.ends_with(name) || event->head.size() < bus::kWireHeaderBytes) continue;
      if (bus::ReadInt64(event->head.data()) != read.fingerprint) {
        robots.of_other_versions.insert(name);
        continue;
      }
      const std::string prefix = event->channel.substr(0, event->channel.size() - name.size());
      (robots.by_prefix[prefix].*read.messages).Add(*event);
    }
  }
  return robots;
}

[[noreturn]] void FailWithoutPoses(const std::string& path, const LoggedRobots& robots) {
  std::string text = "an LCM log without the poses of a run (channel POSE)";
  if (robots.of_other_versions.contains(bus::kPose.name)) {
    text = "an LCM log of another version of plslam, whose poses cannot be read";
  }
  throw std::runtime_error(fmt::format(
      "{}: is {}{}", path, text,
      robots.has_frames ? fmt::format(": `plslam replay {} --out DIR` computes the run from its frames, and "
                                      "`plslam export DIR` takes it from there",
                                      path)
                        : " and without frames that could be replayed"));
}

/// The map after the last update that goes on from the one before.
Map MapOf(const LoggedMessages& updates, const bus::LogReader& log, bool* is_last) {
  bus::MapUpdateAssembler assembler;
  MapReplica replica;
  updates.ForEach<map_update_t>(log, [&](const map_update_t& page) {
    if (assembler.Add(page) != bus::PageOutcome::kComplete) return;
    *is_last = replica.Apply(assembler.Take()) != MapVersion::Step::kGap;
  });
  return replica.map();
}

}  // namespace

LoggedRun WriteLoggedRun(const std::string& path, const std::string& folder) {
  bus::LogReader log(path);
  const LoggedRobots robots = ReadRobots(log);
  const auto most =
      std::max_element(robots.by_prefix.begin(), robots.by_prefix.end(),
                       [](const auto& a, const auto& b) { return a.second.poses.size() < b.second.poses.size(); });
  if (most == robots.by_prefix.end() || most->second.poses.size() == 0) FailWithoutPoses(path, robots);
  const LoggedRobot& robot = most->second;

  std::optional<Eigen::Quaterniond> q_l_c;
  robot.cameras.ForEach<camera_t>(log, [&](const camera_t& message) {
    if (const auto rig = bus::FromMessage(message)) q_l_c = Rectify(*rig).q_l_c;
  });
  if (!q_l_c) {
    throw std::runtime_error(
        fmt::format("{}: has poses, but no rig (channel CAMERA), without which they cannot be "
                    "turned into those of the left camera",
                    path));
  }
  Recorder recorder;
  robot.poses.ForEach<pose_t>(log, [&](const pose_t& message) {
    if (const auto pose = ToFramePose(message)) recorder.AddPose(*pose);
  });
  robot.truths.ForEach<ground_truth_t>(log, [&](const ground_truth_t& message) {
    if (const auto T_w_l = bus::FromMessage(message.T_w_l)) {
      recorder.AddTruth(message.frame_id, {message.header.t_ns, *T_w_l});
    }
  });
  robot.bodies.ForEach<bodies_t>(log, [&](const bodies_t& message) {
    if (const auto seen = ToBodiesOfFrame(message)) recorder.AddBodies(message.frame_id, *seen);
  });

  LoggedRun run;
  run.has_frames = robots.has_frames;
  bool is_last = true;
  run.map = MapOf(robot.map_updates, log, &is_last);
  if (!is_last) run.lack = "changes of the map are missing in the log, whose end is not in it";
  if (!robots.of_other_versions.empty()) {
    run.lack = fmt::format(
        "messages of another version of plslam are passed over, of {}: `plslam replay` computes "
        "them anew",
        fmt::join(robots.of_other_versions, ", "));
  }
  PrepareOutputFolder(folder);
  const std::vector<std::string> failures = WriteOutputs(folder, recorder, run.map, *q_l_c);
  if (!failures.empty()) throw std::runtime_error(failures.front());
  return run;
}

}  // namespace plslam::viewer
