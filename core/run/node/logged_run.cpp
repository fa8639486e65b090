// SPDX-License-Identifier: BSD-3-Clause
#include "core/run/node/logged_run.h"

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
#include "core/io/maps/map_camera.h"
#include "core/map/map_update.h"
#include "core/run/node/recorded_messages.h"
#include "core/run/run_writer.h"
#include "plslam/camera_t.hpp"
#include "plslam/ground_truth_t.hpp"
#include "plslam/image_strip_t.hpp"
#include "plslam/map_update_t.hpp"
#include "plslam/pose_t.hpp"
#include "plslam/stream_t.hpp"

namespace plslam {
namespace {

/// Position of a message in the log.
struct Place {
  int64_t offset = 0;
  int64_t bytes = 0;
};

/// Returns nullopt if the message is malformed.
template <class Message>
std::optional<Message> Decode(const bus::LogReader& log, const Place& place) {
  const auto data = log.Data(place.offset, std::min<int64_t>(place.bytes, bus::kMaxMessageBytes));
  if (!data || !bus::MessageLength(*FindMessageLayout(Message::getTypeName()), *data)) return std::nullopt;
  return bus::Decoded<Message>(*data);
}

/// Messages of one channel without duplicates: by publisher, in the order of their first messages, and by number. In
/// the log, a repaired message comes after later ones.
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

  /// Calls `take` for the well-formed messages, in order.
  template <class Message, class Take>
  void ForEach(const bus::LogReader& log, Take take) const {
    for (const auto& [key, place] : places_) {
      if (const auto message = Decode<Message>(log, place)) take(*message);
    }
  }

 private:
  std::vector<int64_t> sources_;
  std::map<std::pair<size_t, int64_t>, Place> places_;
};

/// The messages of a log under one prefix.
struct LoggedRobot {
  LoggedMessages cameras, poses, truths, bodies, map_updates;
  bool has_frames = false;
  /// Channels with messages of another version of plslam.
  std::set<std::string_view> of_other_versions;
  std::set<int64_t> streams;

  /// A stream that begins replaces the previous one (ViewerNode::OnStream).
  void Take(const stream_t& message) {
    const int64_t stream = message.header.session != 0 ? message.header.session : message.header.source;
    const bool begins = message.event == "begin" || message.event == "resume";
    if (begins && streams.insert(stream).second && message.event == "begin") poses = truths = bodies = {};
  }
};
using LoggedRobots = std::map<std::string, LoggedRobot>;  // by prefix

/// A channel that is read, with the fingerprint of its messages in this version.
struct ReadChannel {
  bus::Channel channel;
  int64_t fingerprint;
  LoggedMessages LoggedRobot::*messages;  ///< null: they are not kept
};
const std::vector<ReadChannel>& ReadChannels() {
  static const std::vector<ReadChannel> kChannels{
      {bus::kCamera, camera_t::getHash(), &LoggedRobot::cameras},
      {bus::kPose, pose_t::getHash(), &LoggedRobot::poses},
      {bus::kGroundTruth, ground_truth_t::getHash(), &LoggedRobot::truths},
      {bus::kBodies, bodies_t::getHash(), &LoggedRobot::bodies},
      {bus::kMapUpdate, map_update_t::getHash(), &LoggedRobot::map_updates},
      {bus::kStream, stream_t::getHash(), nullptr},
      {bus::kStereoFrame, image_strip_t::getHash(), nullptr},
      {bus::kStereoFrameLive, image_strip_t::getHash(), nullptr}};
  return kChannels;
}

void Take(const bus::LogReader& log, const bus::LogReader::Event& event, const ReadChannel& read,
          LoggedRobot& robot) {
  if (bus::ReadInt64(event.head.data()) != read.fingerprint) {
    robot.of_other_versions.insert(read.channel.name);
  } else if (read.messages != nullptr) {
    (robot.*read.messages).Add(event);
  } else if (read.channel.name != bus::kStream.name) {
    robot.has_frames = true;
  } else if (const auto message = Decode<stream_t>(log, {event.data_offset, event.data_bytes})) {
    robot.Take(*message);
  }
}

LoggedRobots ReadRobots(bus::LogReader& log) {
  LoggedRobots robots;
  while (const auto event = log.Next()) {
    for (const ReadChannel& read : ReadChannels()) {
      const std::string_view name = read.channel.name;
      if (!event->channel.ends_with(name) || event->head.size() < bus::kWireHeaderBytes) continue;
      Take(log, *event, read, robots[event->channel.substr(0, event->channel.size() - name.size())]);
    }
  }
  return robots;
}

[[noreturn]] void FailWithoutPoses(const std::string& path, const LoggedRobots& robots) {
  const auto any = [&](auto is_so) {
    return std::any_of(robots.begin(), robots.end(), [&](const auto& robot) { return is_so(robot.second); });
  };
  std::string text = "an LCM log without poses of a run (channel POSE)";
  if (any([](const LoggedRobot& robot) { return robot.of_other_versions.contains(bus::kPose.name); })) {
    text = "an LCM log from another version of plslam, whose poses cannot be read";
  }
  const bool has_frames = any([](const LoggedRobot& robot) { return robot.has_frames; });
  throw std::runtime_error(fmt::format("{}: is {}{}", path, text,
                                       has_frames ? fmt::format(": `plslam replay {} --out DIR` recomputes the run "
                                                                "from its frames, and `plslam export DIR` exports it",
                                                                path)
                                                  : " and without frames to replay"));
}

/// Returns the rectifying rotation of the last valid rig.
Eigen::Quaterniond RectifiedFrom(const LoggedRobot& robot, const bus::LogReader& log, const std::string& path) {
  std::vector<RigCalibration> rigs;
  robot.cameras.ForEach<camera_t>(log, [&](const camera_t& message) {
    if (auto rig = bus::FromMessage(message)) rigs.push_back(*std::move(rig));
  });
  std::string why = robot.of_other_versions.contains(bus::kCamera.name)
                        ? "its rig (channel CAMERA) is from another version of plslam: export it with that version"
                        : "no rig (channel CAMERA), which is needed to convert them to the left camera";
  for (auto rig = rigs.rbegin(); rig != rigs.rend(); ++rig) {
    try {
      return Rectify(*rig).q_l_c;
    } catch (const std::exception& error) {
      why = fmt::format("its rig '{}' cannot be used: {}", rig->name, error.what());
    }
  }
  throw std::runtime_error(fmt::format("{}: has poses, but {}", path, why));
}

/// Returns the map after the last update that continues the previous one.
Map MapOf(const LoggedMessages& updates, const bus::LogReader& log, Notes* notes) {
  bus::MapUpdateAssembler assembler;
  MapReplica replica;
  replica.RememberRemoved();
  bool is_last = true;
  updates.ForEach<map_update_t>(log, [&](const map_update_t& page) {
    is_last = assembler.Add(page) == bus::PageOutcome::kComplete &&
              replica.Apply(assembler.Take()) != MapVersion::Step::kGap;
  });
  if (!is_last) notes->warnings.emplace_back("changes of the map are missing in the log, and so is its final state");
  return replica.map();
}

/// Returns the updates of the robot's own map, or of the only map: robots may share it. Null if there is none.
const LoggedMessages* FindMap(const LoggedRobot& robot, const LoggedRobots& robots, Notes* notes) {
  if (robot.map_updates.size() > 0) return &robot.map_updates;
  std::vector<const LoggedMessages*> maps;
  for (const auto& [prefix, other] : robots) {
    if (other.map_updates.size() > 0) maps.push_back(&other.map_updates);
  }
  if (maps.size() > 1)
    notes->Warn(fmt::format("none of the {} maps in the log has the prefix of the run", maps.size()));
  return maps.size() == 1 ? maps.front() : nullptr;
}

/// Adds a sentence about messages of other versions, of the robot and of maps, which may have another prefix.
void AddOtherVersions(const LoggedRobot& robot, const LoggedRobots& robots, Notes* notes) {
  std::set<std::string_view> names = robot.of_other_versions;
  for (const auto& [prefix, other] : robots) {
    if (other.of_other_versions.contains(bus::kMapUpdate.name)) names.insert(bus::kMapUpdate.name);
  }
  if (names.empty()) return;
  notes->Warn(fmt::format("messages from another version of plslam are skipped, on {}{}", fmt::join(names, ", "),
                          robot.has_frames ? ": `plslam replay` recomputes them" : ""));
}

Recorder RecorderOf(const LoggedRobot& robot, const bus::LogReader& log) {
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
  return recorder;
}

}  // namespace

LoggedRun ReadLoggedRun(const std::string& path) {
  bus::LogReader log(path);
  const LoggedRobots robots = ReadRobots(log);
  const auto most = std::max_element(robots.begin(), robots.end(), [](const auto& a, const auto& b) {
    return a.second.poses.size() < b.second.poses.size();
  });
  if (most == robots.end() || most->second.poses.size() == 0) FailWithoutPoses(path, robots);
  const auto& [prefix, robot] = *most;
  LoggedRun run{prefix, RecorderOf(robot, log), RectifiedFrom(robot, log, path), {}, robot.has_frames, {}};
  if (const LoggedMessages* updates = FindMap(robot, robots, &run.notes)) run.map = MapOf(*updates, log, &run.notes);
  AddOtherVersions(robot, robots, &run.notes);
  if (log.skipped_bytes() > 0) {
    run.notes.Warn(fmt::format("{} of its bytes are truncated or damaged", log.skipped_bytes()));
  }
  return run;
}

Run RunOf(const LoggedRun& logged) {
  Run run = RunOf(logged.recorder, logged.map, logged.q_l_c);
  run.frames = FrameTableOf(logged.recorder);
  run.notes = logged.notes;
  if (logged.map.keyframes().empty() || !logged.map.camera()) return run;
  run.map.emplace();
  run.map->map = logged.map;
  run.map->rig = CameraBytes(*logged.map.camera());
  return run;
}

void WriteLoggedRun(const LoggedRun& run, const std::string& folder) {
  PrepareOutputFolder(folder);
  const std::vector<std::string> failures = WriteOutputs(folder, run.recorder, run.map, run.q_l_c);
  if (!failures.empty()) throw std::runtime_error(failures.front());
}

}  // namespace plslam
