// SPDX-License-Identifier: BSD-3-Clause
#include "loop_process/node/loop_node.h"

#include <algorithm>
#include <chrono>
#include <string>
#include <utility>

#include "core/bus/messages/convert.h"
#include "core/bus/run_loop.h"
#include "core/errors/log.h"
#include "core/map/keyframe_in_camera.h"
#include "core/process/process_usage.h"
#include "core/run/number_ranges.h"
#include "core/run/process_names.h"
#include "loop_process/loop_service.h"
#include "plslam/command_t.hpp"
#include "plslam/status_t.hpp"

namespace plslam::loop {
namespace {

// Period of checks whether a wait is over.
constexpr std::chrono::milliseconds kTick(200);

}  // namespace

LoopNode::LoopNode(bus::Process& process, const LoopOptions& options)
    : process_(process),
      options_(options),
      places_(LoadPlaces(options.vocabularies, options.places)),
      publisher_(process.bus()),
      report_(process),
      arrivals_(process),
      keyframes_(process.bus(), [this](const Keyframe& keyframe) { arrivals_.Add(keyframe); }),
      requests_(
          process.bus(), [this](const Keyframe& frame) { arrivals_.Add(RelocalisationRequest{frame}); },
          bus::kRelocalisationRequest),
      map_(process.bus(), [this](MapUpdate update) { OnUpdate(std::move(update)); }) {
  process_.bus().Subscribe<status_t>(bus::kStatus, [this](const status_t& message) { OnStatus(message); });
  process_.SetConfiguration(ToYaml("loop", options_));
  checker_ = std::thread([this] { bus::RunGuarded(process_.bus(), [this] { CheckUntilStopped(); }); });
  adjuster_ = std::thread([this] { bus::RunGuarded(process_.bus(), [this] { AdjustUntilStopped(); }); });
}

LoopNode::~LoopNode() {
  arrivals_.Stop();
  adjustments_.Stop();
  checker_.join();
  adjuster_.join();
}

void LoopNode::OnUpdate(MapUpdate update) {
  if (update.camera) arrivals_.Open(*update.camera);
  arrivals_.Add(std::move(update));
}

void LoopNode::OnStatus(const status_t& message) {
  // Without a map everything waits.
  if (arrivals_.is_open()) arrivals_.Add(SignOfLife{SourceId(message.header.source)});
}

void LoopNode::CheckUntilStopped() {
  for (;;) {
    const std::optional<Arrival> arrival = arrivals_.Take(kTick);
    if (arrivals_.stopped()) return;
    if (arrival) {
      if (!service_) Begin(arrivals_.camera());
      Send(Handle(*arrival));
    } else if (service_) {
      Send(service_->OnTick());
    }
  }
}

/// Stored features are expressed in the camera of the map: a map with another camera starts without any.
LoopService::Output LoopNode::Follow(const MapUpdate& update) {
  if (update.camera && *update.camera != map_camera_) Begin(*update.camera);
  return service_->OnUpdate(update);
}

void LoopNode::Begin(const StereoCamera& camera) {
  map_camera_ = camera;
  service_.emplace(LoopCloser(camera, places_, options_), bus::NowMs);
}

LoopService::Output LoopNode::Handle(const Arrival& arrival) {
  if (const auto* keyframe = std::get_if<Keyframe>(&arrival)) {
    const std::optional<Keyframe> local = KeyframeInCamera(map_camera_, *keyframe);
    if (!local) return {};
    LoopService::Output output = service_->OnKeyframe(*local);
    if (keyframe->name.number % kFilesEvery == 0) MoveOldToFiles();
    return output;
  }
  if (const auto* update = std::get_if<MapUpdate>(&arrival)) return Follow(*update);
  if (const auto* sign = std::get_if<SignOfLife>(&arrival)) {
    service_->OnSignOfLife(sign->source);
    return service_->OnTick();
  }
  if (const auto* adjustment = std::get_if<LoopClosure>(&arrival)) {
    service_->OnAdjusted(*adjustment);
    return {};
  }
  const std::optional<Keyframe> local = KeyframeInCamera(map_camera_, std::get<RelocalisationRequest>(arrival).frame);
  return local ? service_->OnRequest(*local) : LoopService::Output();
}

void LoopNode::MoveOldToFiles() {
  if (service_->MoveOldToFiles() || std::exchange(files_failed_, true)) return;
  LogWarning("{}", CannotLeaveMemory());
}

/// A running adjustment would undo the loop that is being published, or one that is already in the map.
void LoopNode::Send(LoopService::Output output) {
  const auto is_loop = [](const LoopClosure& closure) { return closure.kind == LoopClosure::Kind::kLoop; };
  if (output.ends_adjustment || std::any_of(output.closures.begin(), output.closures.end(), is_loop))
    adjustments_.Drop(output.ends_adjustment);
  for (const LoopClosure& closure : output.closures) {
    publisher_.Publish(closure);
    Count(closure);
  }
  for (const Relocalisation& answer : output.answers) {
    process_.bus().Publish(bus::kRelocalisation, bus::ToMessage(answer));
    report_.CountAnswer(answer.found);
  }
  if (!output.missing_keyframes.empty()) {
    command_t command{};
    command.target = process_name::kMapping;
    command.verb = command_verb::kSendKeyframes;
    command.argument = NumberRanges(Values(output.missing_keyframes));
    process_.bus().Publish(bus::kCommand, command);
  }
  if (!output.adjustment) return;
  MoveOldToFiles();
  adjustments_.Put(std::move(*output.adjustment));
}

void LoopNode::Count(const LoopClosure& closure) {
  if (closure.keyframe.number == 0) process_.SetState(process_state::kRunning);
  process_.SetCounter("loop.keyframes", static_cast<double>(service_->follower().map().keyframes().size()));
  process_.SetCounter("loop.detect_ms", closure.detect_ms);
  if (closure.kind != LoopClosure::Kind::kLoop) return;
  report_.CountLoop();
  const LoopEdge& edge = closure.edges.front();
  LogInfo("loop: keyframe {} shows the place of keyframe {} ({} points, {} lines)", edge.keyframe_id,
          edge.old_keyframe_id, edge.n_points, edge.n_lines);
}

void LoopNode::AdjustUntilStopped() {
  AdjustmentProgress progress;
  while (std::optional<AdjustmentSlot::Job> job = adjustments_.Take()) {
    if (job->forgets_progress) progress = {};
    progress.Apply(job->problem);
    const double began_ms = bus::NowMs();
    std::string failure;
    LoopClosure closure = AdjustGlobally(job->problem, options_.adjustment, &adjustments_.interrupts(), &failure);
    closure.correct_ms = bus::NowMs() - began_ms;
    if (!failure.empty()) report_.CountFailedAdjustment(failure);
    const AdjustmentSlot::Outcome outcome = adjustments_.OutcomeOf(*job);
    if (outcome == AdjustmentSlot::Outcome::kStopped) return;
    if (outcome == AdjustmentSlot::Outcome::kOutdated) {
      progress.Add(job->problem, closure.poses);
      continue;
    }
    progress = {};
    publisher_.Publish(closure);
    closure.poses.clear();
    arrivals_.Add(std::move(closure));
    job.reset();
    bus::GiveBackFreedMemory();
  }
}

bus::ProcessSpec LoopSpec() {
  bus::ProcessSpec spec;
  spec.name = process_name::kLoop;
  spec.description = "Recognises places with points and lines, corrects the map, and finds lost trackers again.";
  spec.examples =
      "  loop_process\n"
      "  loop_process --config config/plslam.yaml --set loop.vocabularies.points=my.vocabulary";
  spec.make_node = bus::NodeWithOptions<LoopNode, LoopOptions>(spec.name);
  spec.waits_for = "keyframes of vo_process and the map of mapping_process";
  spec.results = {
      {"loop.keyframes", "keyframes checked"}, {"loops", "loops"}, {"relocalisation.found", "trackers found again"}};
  return spec;
}

}  // namespace plslam::loop
