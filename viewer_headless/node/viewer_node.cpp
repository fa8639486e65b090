// SPDX-License-Identifier: BSD-3-Clause
#include "viewer_headless/node/viewer_node.h"

#include <fmt/format.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <utility>

#include "core/bus/messages/convert.h"
#include "core/bus/run_loop.h"
#include "core/errors/log.h"
#include "core/errors/standard_streams.h"
#include "core/process/process_status.h"
#include "core/run/node/recorded_messages.h"
#include "core/run/process_names.h"
#include "core/run/run_counters.h"
#include "core/run/run_writer.h"
#include "plslam/ground_truth_t.hpp"
#include "viewer_headless/captions.h"
#include "viewer_headless/node/message_values.h"

namespace plslam::viewer {
namespace {

constexpr std::chrono::milliseconds kTick(250);
// Ticks after the end of a stream until the run counts as over: after the tracker has finished, and at most, if the
// tracker is silent: it may wait 15 s for the map.
constexpr int kQuietTicksAfterFinish = 4;
constexpr int kQuietTicksAtMost = 80;
// Ticks since the last message until the map is accepted as it is: a killed mapping_process restarts sooner, and global
// bundle adjustment takes less.
constexpr int kQuietTicksForTheMap = 240;
// Pictures whose messages have to be resent arrive sooner.
constexpr int kQuietTicksForPictures = 20;
constexpr size_t kRateTicks = 12;

}  // namespace

ViewerNode::ViewerNode(bus::Process& process, const ViewerOptions& options, Earlier earlier)
    : process_(process),
      options_(options),
      earlier_(earlier),
      on_terminal_(!options.quiet && isatty(STDOUT_FILENO) != 0) {
  PrepareOutputFolder(options_.out);
  lock_.emplace(options_.out);
  recorder_ = Recorder(options_.out);
  if (earlier_ == Earlier::kRefuse) CheckHasNoResults(options_.out);
  if (options_.overlay_every > 0) PrepareOutputFolder(options_.out + "/overlays");
  Subscribe();
}

ViewerNode::~ViewerNode() {
  try {
    // A run that ends before any frame was answered does not write over the one before, and leaves no empty
    // trajectories.
    if (dirty_ && HasPlayed() && !StopsBeforeTheRig()) Write(false);
    ShowProgress(true);
  } catch (const std::exception& e) {
    SetFailures({e.what()});
  }
  const std::string& failure = failure_.empty() ? failure_before_ : failure_;
  if (failure.empty()) return;
  PrintError(fmt::format("{}: error: {}", process_.name(), failure));
  process_.Finish(1);
}

/// A viewer that was restarted and stopped again may have poses of the history, but not yet the rig, which is repeated
/// every second of a stream. What the previous viewer wrote stays.
bool ViewerNode::StopsBeforeTheRig() const {
  static constexpr double kRigAfter_s = 2.0;
  if (earlier_ != Earlier::kReplace || q_l_c_) return false;
  if (!streams_.empty() && bus::NowS() - began_s_ > kRigAfter_s) return false;
  LogWarning("stopped before the rig was received: the earlier results in {} stay", options_.out);
  return true;
}

void ViewerNode::Subscribe() {
  bus::Bus& bus = process_.bus();
  camera_.emplace(
      bus, [this](const RigCalibration& rig) { OnCamera(rig); }, [this] { Reject(); });
  bus.Subscribe<stream_t>(bus::kStream, [this](const stream_t& m) { OnStream(m); });
  bus.Subscribe<pose_t>(bus::kPose, [this](const pose_t& m) { OnPose(m); });
  bus.Subscribe<status_t>(bus::kStatus, [this](const status_t& m) { OnStatus(m); });
  bus.Subscribe<command_t>(bus::kCommand, [this](const command_t& m) { OnCommand(m); });
  bus.Subscribe<ground_truth_t>(bus::kGroundTruth, [this](const ground_truth_t& m) {
    const std::optional<SE3> T_w_l = bus::FromMessage(m.T_w_l);
    if (!T_w_l || !recorder_.AddTruth(FrameId(m.frame_id), {m.header.t_ns, *T_w_l})) return Reject();
    dirty_ = true;
    quiet_ticks_ = 0;
  });
  bus.Subscribe<bodies_t>(bus::kBodies, [this](const bodies_t& m) {
    const std::optional<BodiesOfFrame> seen = ToBodiesOfFrame(m);
    if (!seen || !recorder_.AddBodies(FrameId(m.frame_id), *seen)) return Reject();
    dirty_ = true;
    quiet_ticks_ = 0;
  });
  map_ = std::make_unique<bus::MapSubscriber>(bus, [this](const MapUpdate& update) { OnMap(update); });
  map_->RememberRemoved();
  const Map& map = map_->follower().map();
  report_ =
      std::make_unique<ReportNode>(bus, options_, ReportNode::Sources{&recorder_, &map, [this] { return q_l_c(); }});
  pictures_ = std::make_unique<PictureNode>(
      bus, options_, PictureNode::Sources{&map, report_->pictures()}, [this] { Reject(); },
      [this] {
        dirty_ = true;
        quiet_ticks_ = 0;
      });
  bus.Every(kTick, [this] { OnTick(); });
}

void ViewerNode::OnCamera(const RigCalibration& rig) {
  try {
    const Rectification rectification = Rectify(rig);
    pictures_->SetCamera(rig, rectification);
    report_->SetCamera(rectification.camera);
    q_l_c_ = rectification.q_l_c;
    RemoveEarlier();
    dirty_ = dirty_ || written_;
    quiet_ticks_ = 0;
  } catch (const std::exception& e) {
    LogWarning("the rig '{}' cannot be used: {}", rig.name, e.what());
    Reject();
  }
}

void ViewerNode::OnStream(const stream_t& message) {
  if (message.event == stream_event::kEnd) {
    recorder_.SetEnd(message.n_frames, message.n_bad);
    quiet_ticks_ = 0;
  } else if (message.event == stream_event::kBegin || message.event == stream_event::kResume) {
    // The history keeper may republish STREAM messages of a player that has exited, even after another one has resumed.
    const int64_t stream = message.header.session != 0 ? message.header.session : message.header.source;
    if (!streams_.insert(stream).second) return;
    // Written files are kept: after "resume" no earlier part of the stream may be available, and after "begin" all
    // files are written again.
    if (written_ && message.event == stream_event::kResume) return;
    if (written_) StartNewRun();
    lockstep_ = message.pace == stream_pace::kLockstep;
    announced_frames_ = message.n_frames;
    report_->OnStream(message);
  } else {
    Reject();
  }
}

void ViewerNode::BeginRun() {
  process_.SetState(process_state::kRunning);
  replaces_ = earlier_ == Earlier::kReplace;
  RemoveEarlier();
}

/// With the first frame and the rig, because results of an earlier run are kept until there can be others.
void ViewerNode::RemoveEarlier() {
  if (q_l_c_ && std::exchange(replaces_, false)) RemoveResults(options_.out);
}

void ViewerNode::StartNewRun() {
  LogInfo("a new stream begins: it replaces the results in {}", options_.out);
  if (earlier_ == Earlier::kRefuse) earlier_ = Earlier::kReplace;
  if (!failure_.empty()) failure_before_ = std::exchange(failure_, "");
  recorder_ = Recorder(options_.out);
  written_ = dirty_ = vo_finished_ = false;
  history_.clear();
  report_->StartNewRun();
  pictures_->StartNewRun(report_->pictures());
}

void ViewerNode::OnPose(const pose_t& message) {
  const std::optional<FramePose> pose = ToFramePose(message);
  const size_t frames = recorder_.frames().size();
  if (!pose || !recorder_.AddPose(*pose)) return Reject();
  if (recorder_.frames().size() == 1) BeginRun();
  dirty_ = true;
  quiet_ticks_ = 0;
  if (recorder_.frames().size() > frames) pictures_->AddPose(*pose);
}

void ViewerNode::OnStatus(const status_t& message) {
  if (message.process == process_name::kVo) vo_finished_ = message.state == process_state::kFinished;
  if (message.process == process_name::kMapping) mapping_heard_ = true;
  if (process_name::SendsFrames(message.process)) {
    recorder_.SetSent(bus::CountOf(message, "frames.sent"), bus::CountOf(message, "frames.bad"));
  }
  report_->OnStatus(message);
}

void ViewerNode::OnMap(const MapUpdate& update) {
  mapping_heard_ = true;
  report_->OnMap(update);
  dirty_ = true;
  quiet_ticks_ = 0;
}

void ViewerNode::OnCommand(const command_t& message) {
  const bool ours = message.target == process_.name() || message.target == "*";
  if (!ours || message.verb != command_verb::kFinish) return;
  if (dirty_) Write(false);
  process_.Finish();
}

void ViewerNode::OnTick() {
  ShowProgress(false);
  // Wait for one quiet tick: the true poses of the last frames may arrive after their estimates.
  if (dirty_ && ++quiet_ticks_ > 1 && RunIsOver()) {
    Write(true);
    if (failure_.empty()) process_.SetState(process_state::kFinished, "files in " + options_.out);
  }
}

bool ViewerNode::HasPlayed() const { return !recorder_.frames().empty(); }

bool ViewerNode::RunIsOver() const {
  if (!recorder_.n_frames()) return false;
  if (!MapIsComplete() && quiet_ticks_ <= kQuietTicksForTheMap) return false;
  if (!q_l_c_ && quiet_ticks_ <= kQuietTicksAtMost) return false;
  if (ExpectsPictures() && quiet_ticks_ <= kQuietTicksForPictures) return false;
  if (recorder_.IsComplete()) return true;
  return quiet_ticks_ > (vo_finished_ ? kQuietTicksAfterFinish : kQuietTicksAtMost);
}

/// Returns whether the map has the last keyframe and all updates about it, or no mapping_process was heard.
bool ViewerNode::MapIsComplete() const {
  if (!mapping_heard_) return true;
  const auto last = recorder_.LastKeyframe();
  return !last || map_->follower().newest().HasCommitted(*last);
}

bool ViewerNode::ExpectsPictures() const { return lockstep_ && pictures_->MayCome(); }

void ViewerNode::Write(bool ended) {
  written_ = true;
  dirty_ = false;
  // Finished first, because the report lists its missing pictures.
  const PictureNode::Result pictures = pictures_->Finish(recorder_, lockstep_, ended);
  process_.SetCounter(kPicturesMissing, static_cast<double>(pictures.missing));
  if (!pictures.film_note.empty()) process_.Warn("film_as_pictures", pictures.film_note);
  std::vector<std::string> failures = WriteFiles();
  failures.insert(failures.end(), pictures.failures.begin(), pictures.failures.end());
  SetFailures(failures);
}

std::vector<std::string> ViewerNode::WriteFiles() {
  if (!q_l_c_ && !recorder_.frames().empty()) {
    return {fmt::format(
        "nothing is written to {}: poses were received, but no rig (channel CAMERA, which the player repeats every "
        "second); without it poses of the rectified camera cannot be converted to the left camera",
        options_.out)};
  }
  std::vector<std::string> failures = WriteOutputs(options_.out, recorder_, map_->follower().map(), q_l_c());
  try {
    report_->Write();
  } catch (const std::exception& e) {
    failures.emplace_back(e.what());
  }
  return failures;
}

void ViewerNode::SetFailures(const std::vector<std::string>& failures) {
  for (const std::string& failure : failures) LogError("{}", failure);
  failure_ = failures.empty() ? "" : failures.front();
  if (failures.size() > 1) failure_ += fmt::format(" (and {} more, in the log)", failures.size() - 1);
  if (!failure_.empty()) process_.SetState(process_state::kFailed, failure_);
}

void ViewerNode::Reject() { process_.SetCounter("viewer.rejected", static_cast<double>(++rejected_)); }

Eigen::Quaterniond ViewerNode::q_l_c() const { return q_l_c_.value_or(Eigen::Quaterniond::Identity()); }

double ViewerNode::FramesPerSecond() {
  history_.emplace_back(bus::NowS(), static_cast<int64_t>(recorder_.frames().size()));
  if (history_.size() > kRateTicks) history_.pop_front();
  const double seconds = history_.back().first - history_.front().first;
  const int64_t frames = history_.back().second - history_.front().second;
  return seconds > 0.0 ? static_cast<double>(frames) / seconds : 0.0;
}

void ViewerNode::ShowProgress(bool last) {
  const bus::BusCounters counters = process_.bus().counters();
  const double rate = FramesPerSecond();
  // Without a camera no frame can be written: a launcher that stops this process waits until the count is positive.
  process_.SetCounter("frames", q_l_c_ ? static_cast<double>(recorder_.frames().size()) : 0.0);
  process_.SetCounter("keyframes", static_cast<double>(recorder_.keyframes()));
  process_.SetCounter("frames.lost", static_cast<double>(recorder_.Tally(false).lost));
  if (!recorder_.failure().empty()) {
    process_.Warn("frames_in_memory", recorder_.failure() + "; frames stay in memory, half a kilobyte each");
  }
  if (!on_terminal_) return;
  const std::string line = ProgressLine(recorder_, {announced_frames_, rate, counters.lost, counters.repaired});
  // Overwrite the previous line and clear its rest.
  std::fputs(fmt::format("\r{}\x1b[K{}", line, last ? "\n" : "").c_str(), stdout);
  std::fflush(stdout);
}

}  // namespace plslam::viewer
