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
#include "core/bus/logs/log_index.h"
#include "core/bus/logs/log_reader.h"
#include "core/bus/messages/convert.h"
#include "core/bus/messages/map_pages.h"
#include "core/bus/transport/wire.h"
#include "core/geometry/rectification.h"
#include "core/io/maps/map_camera.h"
#include "core/map/map_follower.h"
#include "core/map/map_update.h"
#include "core/run/node/recorded_messages.h"
#include "core/run/process_names.h"
#include "core/run/run_writer.h"
#include "plslam/camera_t.hpp"
#include "plslam/ground_truth_t.hpp"
#include "plslam/image_strip_t.hpp"
#include "plslam/map_update_t.hpp"
#include "plslam/pose_t.hpp"
#include "plslam/stream_t.hpp"

namespace plslam {
namespace {

using bus::LoggedMessages;
using bus::LoggedRobot;
using LoggedRobots = std::map<std::string, LoggedRobot>;  // by prefix

bool HasFrames(const LoggedRobot& robot) {
  return robot.visited.contains(bus::kStereoFrame.name) || robot.visited.contains(bus::kStereoFrameLive.name);
}

/// A stream that begins replaces the previous one (ViewerNode::OnStream). `streams` are those of the robot so far.
void OnStream(const stream_t& message, std::set<int64_t>& streams, LoggedRobot& robot) {
  const int64_t stream = message.header.session != 0 ? message.header.session : message.header.source;
  const bool begins = message.event == stream_event::kBegin || message.event == stream_event::kResume;
  if (!begins || !streams.insert(stream).second || message.event != stream_event::kBegin) return;
  for (const bus::Channel& channel : {bus::kPose, bus::kGroundTruth, bus::kBodies})
    robot.messages.erase(channel.name);
}

LoggedRobots ReadRobots(bus::LogReader& log) {
  const std::vector<bus::IndexedChannel> channels{{bus::kCamera, camera_t::getHash()},
                                                  {bus::kPose, pose_t::getHash()},
                                                  {bus::kGroundTruth, ground_truth_t::getHash()},
                                                  {bus::kBodies, bodies_t::getHash()},
                                                  {bus::kMapUpdate, map_update_t::getHash()},
                                                  {bus::kStream, stream_t::getHash(), false},
                                                  {bus::kStereoFrame, image_strip_t::getHash(), false},
                                                  {bus::kStereoFrameLive, image_strip_t::getHash(), false}};
  std::map<std::string, std::set<int64_t>> streams;  // by prefix
  return bus::IndexLog(log, channels, [&](const auto& prefix, const auto& visited, const auto& event, auto& robot) {
    if (visited.channel.name != bus::kStream.name) return;
    const auto message = bus::DecodeAt<stream_t>(log, {event.data_offset, event.data_bytes});
    if (message) OnStream(*message, streams[prefix], robot);
  });
}

[[noreturn]] void FailWithoutPoses(const std::string& path, const LoggedRobots& robots) {
  const auto any = [&](auto is_so) {
    return std::any_of(robots.begin(), robots.end(), [&](const auto& robot) { return is_so(robot.second); });
  };
  std::string text = "an LCM log without poses of a run (channel POSE)";
  if (any([](const LoggedRobot& robot) { return robot.of_other_versions.contains(bus::kPose.name); })) {
    text = "an LCM log from another version of plslam, whose poses cannot be read";
  }
  const bool has_frames = any(HasFrames);
  throw std::runtime_error(fmt::format("{}: is {}{}", path, text,
                                       has_frames ? fmt::format(": `plslam replay {} --out DIR` recomputes the run "
                                                                "from its frames, and `plslam export DIR` exports it",
                                                                path)
                                                  : " and without frames to replay"));
}

/// Returns the rectifying rotation of the last valid rig.
Eigen::Quaterniond RectifiedFrom(const LoggedRobot& robot, const bus::LogReader& log, const std::string& path) {
  std::vector<RigCalibration> rigs;
  robot.On(bus::kCamera).ForEach<camera_t>(log, [&](const camera_t& message) {
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
  MapFollower replica;
  replica.RememberRemoved();
  bool is_last = true;
  updates.ForEach<map_update_t>(log, [&](const map_update_t& page) {
    is_last = assembler.Add(page) == bus::PageOutcome::kComplete && replica.Apply(assembler.Take()) != MapStep::kGap;
  });
  if (!is_last) notes->warnings.emplace_back("changes of the map are missing in the log, and so is its final state");
  return replica.map();
}

/// Returns the updates of the robot's own map, or of the only map: robots may share it. Null if there is none.
const LoggedMessages* FindMap(const LoggedRobot& robot, const LoggedRobots& robots, Notes* notes) {
  if (robot.On(bus::kMapUpdate).size() > 0) return &robot.On(bus::kMapUpdate);
  std::vector<const LoggedMessages*> maps;
  for (const auto& [prefix, other] : robots) {
    if (other.On(bus::kMapUpdate).size() > 0) maps.push_back(&other.On(bus::kMapUpdate));
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
                          HasFrames(robot) ? ": `plslam replay` recomputes them" : ""));
}

Recorder RecorderOf(const LoggedRobot& robot, const bus::LogReader& log) {
  Recorder recorder;
  robot.On(bus::kPose).ForEach<pose_t>(log, [&](const pose_t& message) {
    if (const auto pose = ToFramePose(message)) recorder.AddPose(*pose);
  });
  robot.On(bus::kGroundTruth).ForEach<ground_truth_t>(log, [&](const ground_truth_t& message) {
    if (const auto T_w_l = bus::FromMessage(message.T_w_l)) {
      recorder.AddTruth(FrameId(message.frame_id), {message.header.t_ns, *T_w_l});
    }
  });
  robot.On(bus::kBodies).ForEach<bodies_t>(log, [&](const bodies_t& message) {
    if (const auto seen = ToBodiesOfFrame(message)) recorder.AddBodies(FrameId(message.frame_id), *seen);
  });
  return recorder;
}

}  // namespace

LoggedRun ReadLoggedRun(const std::string& path) {
  bus::LogReader log(path);
  const LoggedRobots robots = ReadRobots(log);
  const auto most = std::max_element(robots.begin(), robots.end(), [](const auto& a, const auto& b) {
    return a.second.On(bus::kPose).size() < b.second.On(bus::kPose).size();
  });
  if (most == robots.end() || most->second.On(bus::kPose).size() == 0) FailWithoutPoses(path, robots);
  const auto& [prefix, robot] = *most;
  LoggedRun run{prefix, RecorderOf(robot, log), RectifiedFrom(robot, log, path), {}, HasFrames(robot), {}};
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
