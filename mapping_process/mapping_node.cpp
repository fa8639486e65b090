#include "mapping_process/mapping_node.h"

#include <spdlog/spdlog.h>

#include <chrono>
#include <exception>
#include <utility>

#include "core/bus/convert.h"
#include "core/geometry/rectification.h"
#include "plslam/camera_t.hpp"

namespace plslam {
namespace {

double NowMs() {
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

}  // namespace

MappingNode::MappingNode(bus::Process& process, const MappingOptions& options)
    : process_(process),
      options_(options),
      publisher_(process.bus(), [this] { OnAsked(); }),
      keyframes_(process.bus(), [this](const Keyframe& keyframe) { OnKeyframe(keyframe); }) {
  process_.bus().Subscribe<camera_t>(bus::kCamera, [this](const camera_t& message) { OnCamera(message); });
  process_.SetConfiguration(ToYaml("mapping", options_));
  worker_ = std::thread([this] { Work(); });
}

MappingNode::~MappingNode() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  stop_solve_ = true;
  changed_.notify_one();
  worker_.join();
}

void MappingNode::OnCamera(const camera_t& message) {
  std::vector<uint8_t> bytes = bus::RigBytes(message);
  if (bytes == camera_bytes_) return;
  const bool first = camera_bytes_.empty();
  const std::optional<RigCalibration> rig = bus::FromMessage(message);
  if (!rig) {
    spdlog::error("the camera '{}' has values that cannot be: it is not used", message.rig_name);
    return;
  }
  if (!first) {
    if (!std::exchange(other_camera_, true)) {
      spdlog::error("another camera '{}': its keyframes do not go into this map", message.rig_name);
    }
    return;
  }
  camera_bytes_ = std::move(bytes);
  const StereoCamera camera = Rectify(*rig).camera;
  {
    const std::lock_guard lock(mutex_);
    camera_ = camera;
  }
  changed_.notify_one();
}

void MappingNode::OnKeyframe(const Keyframe& keyframe) {
  if (other_camera_ && !known_sessions_.contains(keyframe.session)) {
    process_.SetCounter("keyframes.other_camera", static_cast<double>(++n_other_camera_));
    return;
  }
  known_sessions_.insert(keyframe.session);
  {
    const std::lock_guard lock(mutex_);
    queue_.push_back({keyframe, NowMs()});
    process_.SetCounter("queue.keyframes", static_cast<double>(queue_.size()));
  }
  if (!keyframe.lockstep) stop_solve_ = true;
  changed_.notify_one();
}

void MappingNode::OnAsked() {
  {
    const std::lock_guard lock(mutex_);
    asked_ = true;
  }
  changed_.notify_one();
}

// What goes wrong on the worker ends the process where the run loop sees it.
void MappingNode::Work() {
  try {
    WorkUntilStopped();
  } catch (...) {
    process_.bus().Post([failure = std::current_exception()] { std::rethrow_exception(failure); });
  }
}

void MappingNode::WorkUntilStopped() {
  for (;;) {
    bool publish_whole = false;
    std::vector<Queued> batch;
    {
      std::unique_lock lock(mutex_);
      changed_.wait(lock, [this] { return stopping_ || asked_ || (camera_ && !queue_.empty()); });
      if (stopping_) return;
      if (camera_ && !mapper_) mapper_.emplace(*camera_, options_);
      publish_whole = mapper_ && std::exchange(asked_, false);
      if (mapper_) batch = TakeQueued();
      if (!mapper_) asked_ = false;  // nothing is there yet: the first update will be all there is
    }
    if (publish_whole && mapper_->version() > 0) publisher_.Publish(mapper_->Whole());
    if (!batch.empty()) Map(batch);
  }
}

std::vector<MappingNode::Queued> MappingNode::TakeQueued() {
  std::vector<Queued> batch;
  while (!queue_.empty()) {
    const bool lockstep = queue_.front().keyframe.lockstep;
    if (lockstep && !batch.empty()) break;
    batch.push_back(std::move(queue_.front()));
    queue_.pop_front();
    if (lockstep) break;
  }
  stop_solve_ = false;
  process_.SetCounter("queue.keyframes", static_cast<double>(queue_.size()));
  return batch;
}

void MappingNode::Map(const std::vector<Queued>& batch) {
  const double began_ms = NowMs();
  bool inserted = false;
  for (const Queued& queued : batch) {
    std::string reason;
    if (mapper_->Insert(queued.keyframe, &reason)) {
      inserted = true;
      continue;
    }
    spdlog::warn("left out: {}", reason);
    process_.SetCounter("keyframes.ignored", static_cast<double>(++n_ignored_));
  }
  if (!inserted) return;
  const double inserted_ms = NowMs();
  mapper_->Adjust(&stop_solve_);
  const double adjusted_ms = NowMs();
  mapper_->Cull();
  MapUpdate update = mapper_->TakeUpdate();
  const double done_ms = NowMs();
  update.stage_ms = {{"insert", inserted_ms - began_ms},
                     {"adjust", adjusted_ms - inserted_ms},
                     {"cull", done_ms - adjusted_ms},
                     {"update", done_ms - batch.front().received_ms}};
  publisher_.Publish(update);
  Report(update);
}

void MappingNode::Report(const MapUpdate& update) {
  if (update.version == 1) process_.SetState("running");
  process_.SetCounter("map.version", static_cast<double>(update.version));
  process_.SetCounter("map.keyframes", static_cast<double>(mapper_->map().keyframes().size()));
  process_.SetCounter("map.points", static_cast<double>(mapper_->map().points().size()));
  process_.SetCounter("map.lines", static_cast<double>(mapper_->map().lines().size()));
}

bus::ProcessSpec MappingSpec() {
  bus::ProcessSpec spec;
  spec.name = "mapping";
  spec.description = "The map of points and lines: keyframes in, updates of the map out.";
  spec.make_node = [](bus::Process& process, const Config& config) -> std::shared_ptr<void> {
    MappingOptions options;
    config.Read("mapping", options);
    return std::make_shared<MappingNode>(process, options);
  };
  return spec;
}

}  // namespace plslam
