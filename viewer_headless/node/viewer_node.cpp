// SPDX-License-Identifier: BSD-3-Clause
#include "viewer_headless/node/viewer_node.h"

#include <fmt/format.h>

#include <exception>
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
#include "viewer_headless/node/message_values.h"

namespace plslam::viewer {
namespace {}  // namespace

ViewerNode::ViewerNode(bus::Process& process, const ViewerOptions& options, Earlier earlier)
    : process_(process),
      options_(options),
      folder_(options.out, earlier),
      recorder_(options.out),
      end_(process.has_launcher()),
      terminal_(options.quiet) {
  if (options_.overlay_every > 0) PrepareOutputFolder(options_.out + "/overlays");
  Subscribe();
}

ViewerNode::~ViewerNode() {
  try {
    // A run that ends before any frame was answered does not write over the one before, and leaves no empty
    // trajectories.
    if (HasUnwritten() && HasPlayed() && !StopsBeforeTheRig()) Write(false);
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
  if (!folder_.replaces_earlier() || q_l_c_) return false;
  if (!streams_.empty() && bus::NowS() - began_s_ > kRigAfter_s) return false;
  LogWarning("stopped before the rig was received: the earlier results in {} stay", options_.out);
  return true;
}

void ViewerNode::Subscribe() {
  bus::Bus& bus = process_.bus();
  camera_.emplace(
      bus, [this](const RigCalibration& rig) { OnCamera(rig); }, [this] { Reject(); });
  bus.Subscribe<run_t>(bus::kRun, [this](const run_t& m) {
    if (!end_.OnRun(m)) Reject();
  });
  bus.Subscribe<stream_t>(bus::kStream, [this](const stream_t& m) { OnStream(m); });
  bus.Subscribe<pose_t>(bus::kPose, [this](const pose_t& m) { OnPose(m); });
  bus.Subscribe<status_t>(bus::kStatus, [this](const status_t& m) { OnStatus(m); });
  bus.Subscribe<command_t>(bus::kCommand, [this](const command_t& m) { OnCommand(m); });
  bus.Subscribe<ground_truth_t>(bus::kGroundTruth, [this](const ground_truth_t& m) {
    const std::optional<SE3> T_w_l = bus::FromMessage(m.T_w_l);
    if (!T_w_l || !recorder_.AddTruth(FrameId(m.frame_id), {m.header.t_ns, *T_w_l})) return Reject();
    OnNews();
  });
  bus.Subscribe<bodies_t>(bus::kBodies, [this](const bodies_t& m) {
    const std::optional<BodiesOfFrame> seen = ToBodiesOfFrame(m);
    if (!seen || !recorder_.AddBodies(FrameId(m.frame_id), *seen)) return Reject();
    OnNews();
  });
  map_ = std::make_unique<bus::MapSubscriber>(bus, [this](const MapUpdate& update) { OnMap(update); });
  map_->RememberRemoved();
  const Map& map = map_->follower().map();
  report_ = std::make_unique<ReportNode>(
      bus, options_, ReportNode::Sources{&recorder_, &map, [this] { return q_l_c(); }, [this] { OnNews(); }});
  pictures_ = std::make_unique<PictureNode>(
      bus, options_, PictureNode::Sources{&map, report_->pictures()}, [this] { Reject(); }, [this] { OnNews(); });
  bus.Every(RunEnd::kTick, [this] { OnTick(); });
}

void ViewerNode::OnCamera(const RigCalibration& rig) {
  try {
    const Rectification rectification = Rectify(rig);
    pictures_->SetCamera(rig, rectification);
    report_->SetCamera(rectification.camera);
    q_l_c_ = rectification.q_l_c;
    folder_.RemoveEarlier();
    if (HasWritten()) files_ = Files::kOutdated;
    end_.OnMessage();
  } catch (const std::exception& e) {
    LogWarning("the rig '{}' cannot be used: {}", rig.name, e.what());
    Reject();
  }
}

void ViewerNode::OnNews() {
  files_ = HasWritten() ? Files::kOutdated : Files::kUnwritten;
  end_.OnMessage();
}

void ViewerNode::OnStream(const stream_t& message) {
  if (message.event == stream_event::kEnd) {
    recorder_.SetEnd(message.n_frames, message.n_bad);
    end_.OnStream(true);
  } else if (message.event == stream_event::kBegin || message.event == stream_event::kResume) {
    if (!streams_.Add(message)) return;
    camera_->Follow(SourceId(message.header.session));
    // Written files are kept: after "resume" no earlier part of the stream may be available, and after "begin" all
    // files are written again.
    if (HasWritten() && message.event == stream_event::kResume) return;
    if (HasWritten()) StartNewRun();
    report_->OnStream(message);
  } else {
    Reject();
  }
}

/// Earlier results are removed with the first frame and the rig.
void ViewerNode::BeginRun() {
  process_.SetState(process_state::kRunning);
  folder_.BeginRun();
  if (q_l_c_) folder_.RemoveEarlier();
}

void ViewerNode::StartNewRun() {
  LogInfo("a new stream begins: it replaces the results in {}", options_.out);
  folder_.ReplaceOwn();
  if (!failure_.empty()) failure_before_ = std::exchange(failure_, "");
  recorder_ = Recorder(options_.out);
  files_ = Files::kNone;
  end_.OnNewStream();
  terminal_.Restart();
  report_->StartNewRun();
  pictures_->StartNewRun(report_->pictures());
}

void ViewerNode::OnPose(const pose_t& message) {
  const std::optional<FramePose> pose = ToFramePose(message);
  const size_t frames = recorder_.frames().size();
  if (!pose || !recorder_.AddPose(*pose)) return Reject();
  if (recorder_.frames().size() == 1) BeginRun();
  OnNews();
  if (recorder_.frames().size() > frames) pictures_->AddPose(*pose);
}

void ViewerNode::OnStatus(const status_t& message) {
  if (message.process == process_name::kMapping) end_.OnMapper();
  if (process_name::SendsFrames(message.process)) {
    recorder_.SetSent(bus::CountOf(message, "frames.sent"), bus::CountOf(message, "frames.bad"));
  }
  report_->OnStatus(message);
}

void ViewerNode::OnMap(const MapUpdate& update) {
  end_.OnMapper();
  report_->OnMap(update);
  OnNews();
}

void ViewerNode::OnCommand(const command_t& message) {
  const bool ours = message.target == process_.name() || message.target == "*";
  if (!ours || message.verb != command_verb::kFinish) return;
  if (HasUnwritten()) Write(false);
  process_.Finish();
}

void ViewerNode::OnTick() {
  ShowProgress(false);
  end_.OnTick();
  if (HasUnwritten() && RunIsOver()) {
    Write(true);
    if (failure_.empty()) process_.SetState(process_state::kFinished, "files in " + options_.out);
  }
}

bool ViewerNode::HasPlayed() const { return !recorder_.frames().empty(); }

bool ViewerNode::RunIsOver() const {
  if (!recorder_.n_frames()) return false;
  const auto n_poses = static_cast<int64_t>(recorder_.frames().size());
  const bool is_tracked = recorder_.HasLastPose() && !(streams_.lockstep() && pictures_->MayCome());
  return end_.IsOver({q_l_c_.has_value(), n_poses, recorder_.LastKeyframe(), is_tracked, report_->SurfacesMayCome()},
                     map_->follower().newest());
}

void ViewerNode::Write(bool ended) {
  files_ = Files::kWritten;
  // Finished first, because the report lists its missing pictures.
  const PictureNode::Result pictures = pictures_->Finish(recorder_, streams_.lockstep(), ended);
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

void ViewerNode::ShowProgress(bool last) {
  // Without a camera no frame can be written: a launcher that stops this process waits until the count is positive.
  process_.SetCounter("frames", q_l_c_ ? static_cast<double>(recorder_.frames().size()) : 0.0);
  process_.SetCounter("keyframes", static_cast<double>(recorder_.keyframes()));
  process_.SetCounter("frames.lost", static_cast<double>(recorder_.Tally(false).lost));
  if (!recorder_.failure().empty()) {
    process_.Warn("frames_in_memory", recorder_.failure() + "; frames stay in memory, half a kilobyte each");
  }
  const bus::BusCounters counters = process_.bus().counters();
  terminal_.Show(recorder_, {streams_.announced_frames(), 0.0, counters.lost, counters.repaired}, bus::NowS(), last);
}

}  // namespace plslam::viewer
