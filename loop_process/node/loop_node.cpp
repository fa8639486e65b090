// SPDX-License-Identifier: BSD-3-Clause
#include "loop_process/node/loop_node.h"

#include <algorithm>
#include <chrono>
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
// Queue length above which `Queue` blocks, and the longest it blocks for one arrival, so that statuses still go out.
constexpr size_t kMostArrivals = 2000;
constexpr std::chrono::milliseconds kHold(200);

}  // namespace

LoopNode::LoopNode(bus::Process& process, const LoopOptions& options)
    : process_(process),
      options_(options),
      places_(LoadPlaces(options.vocabularies, options.places)),
      publisher_(process.bus()),
      keyframes_(process.bus(), [this](const Keyframe& keyframe) { Queue(keyframe); }),
      requests_(
          process.bus(), [this](const Keyframe& frame) { Queue(RelocalisationRequest{frame}); },
          bus::kRelocalisationRequest),
      map_(process.bus(), [this](MapUpdate update) { OnUpdate(std::move(update)); }) {
  process_.bus().Subscribe<status_t>(bus::kStatus, [this](const status_t& message) { OnStatus(message); });
  process_.SetConfiguration(ToYaml("loop", options_));
  checker_ = std::thread([this] { bus::RunGuarded(process_.bus(), [this] { CheckUntilStopped(); }); });
  adjuster_ = std::thread([this] { bus::RunGuarded(process_.bus(), [this] { AdjustUntilStopped(); }); });
}

LoopNode::~LoopNode() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  stop_adjustment_ = true;
  changed_.notify_all();
  checker_.join();
  adjuster_.join();
}

void LoopNode::OnUpdate(MapUpdate update) {
  if (!has_camera_ && update.camera) {
    has_camera_ = true;
    const std::lock_guard lock(mutex_);
    camera_ = update.camera;
  }
  Queue(std::move(update));
}

void LoopNode::OnStatus(const status_t& message) {
  // Without a map everything waits.
  if (has_camera_) Queue(SignOfLife{SourceId(message.header.source)});
}

/// If the worker is far behind, this blocks the thread of the bus, which then accepts no more: publishers keep their
/// messages.
void LoopNode::Queue(Arrival arrival) {
  {
    std::unique_lock lock(mutex_);
    // Do not block before the first map: the worker cannot start without it, and it arrives through this thread.
    changed_.wait_for(lock, kHold, [this] { return stopping_ || !camera_ || arrivals_.size() < kMostArrivals; });
    arrivals_.push_back(std::move(arrival));
    CountWaiting(arrivals_.back(), 1);
  }
  changed_.notify_all();
}

void LoopNode::CountWaiting(const Arrival& arrival, int more) {
  if (std::holds_alternative<Keyframe>(arrival)) n_waiting_keyframes_ += more;
  process_.SetCounter("queue.arrivals", static_cast<double>(arrivals_.size()));
  process_.SetCounter("queue.keyframes", static_cast<double>(n_waiting_keyframes_));
}

void LoopNode::CheckUntilStopped() {
  for (;;) {
    std::optional<Arrival> arrival;
    {
      std::unique_lock lock(mutex_);
      const bool has_come =
          changed_.wait_for(lock, kTick, [this] { return stopping_ || (camera_ && !arrivals_.empty()); });
      if (stopping_) return;
      if (has_come) {
        arrival = std::move(arrivals_.front());
        arrivals_.pop_front();
        if (arrivals_.size() + 1 >= kMostArrivals) changed_.notify_all();
        CountWaiting(*arrival, -1);
        if (!service_) Begin(*camera_);
      }
    }
    if (arrival) {
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
void LoopNode::DropAdjustment(bool with_progress) {
  const std::lock_guard lock(mutex_);
  forgets_progress_ |= with_progress;
  adjustment_.reset();
  stop_adjustment_ = true;
  ++n_dropped_;
}

void LoopNode::Send(LoopService::Output output) {
  const auto is_loop = [](const LoopClosure& closure) { return closure.kind == LoopClosure::Kind::kLoop; };
  if (output.ends_adjustment || std::any_of(output.closures.begin(), output.closures.end(), is_loop))
    DropAdjustment(output.ends_adjustment);
  for (const LoopClosure& closure : output.closures) {
    publisher_.Publish(closure);
    Count(closure);
  }
  for (const Relocalisation& answer : output.answers) {
    process_.bus().Publish(bus::kRelocalisation, bus::ToMessage(answer));
    process_.SetCounter("relocalisation.asked", static_cast<double>(++n_answers_));
    if (answer.found) process_.SetCounter("relocalisation.found", static_cast<double>(++n_found_));
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
  {
    const std::lock_guard lock(mutex_);
    adjustment_ = std::move(output.adjustment);
    stop_adjustment_ = true;
  }
  changed_.notify_all();
}

void LoopNode::Count(const LoopClosure& closure) {
  if (closure.keyframe.number == 0) process_.SetState(process_state::kRunning);
  process_.SetCounter("loop.keyframes", static_cast<double>(service_->follower().map().keyframes().size()));
  process_.SetCounter("loop.detect_ms", closure.detect_ms);
  if (closure.kind != LoopClosure::Kind::kLoop) return;
  process_.SetCounter("loops", static_cast<double>(++n_loops_));
  const LoopEdge& edge = closure.edges.front();
  LogInfo("loop: keyframe {} shows the place of keyframe {} ({} points, {} lines)", edge.keyframe_id,
          edge.old_keyframe_id, edge.n_points, edge.n_lines);
}

void LoopNode::AdjustUntilStopped() {
  AdjustmentProgress progress;
  for (;;) {
    std::optional<GlobalBundleProblem> problem;
    int64_t n_dropped = 0;
    {
      std::unique_lock lock(mutex_);
      changed_.wait(lock, [this] { return stopping_ || adjustment_; });
      if (stopping_) return;
      problem = std::exchange(adjustment_, std::nullopt);
      stop_adjustment_ = false;
      n_dropped = n_dropped_;
      if (std::exchange(forgets_progress_, false)) progress = {};
    }
    progress.Apply(*problem);
    const double began_ms = bus::NowMs();
    std::string failure;
    LoopClosure closure = AdjustGlobally(*problem, options_.adjustment, &stop_adjustment_, &failure);
    closure.correct_ms = bus::NowMs() - began_ms;
    if (!failure.empty()) CountFailure(failure);
    {
      const std::lock_guard lock(mutex_);
      if (stopping_) return;
      if (adjustment_ || n_dropped_ != n_dropped) {  // out of date
        progress.Add(*problem, closure.poses);
        continue;
      }
    }
    progress = {};
    publisher_.Publish(closure);
    closure.poses.clear();
    Queue(std::move(closure));
    problem.reset();
    bus::GiveBackFreedMemory();
  }
}

void LoopNode::CountFailure(const std::string& failure) {
  process_.SetCounter("adjustments.failed", static_cast<double>(++n_failed_));
  if (n_failed_ == 1) LogWarning("a global bundle adjustment failed (later ones are counted only): {}", failure);
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
