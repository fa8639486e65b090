// SPDX-License-Identifier: BSD-3-Clause
#include "mapping_process/node/mapping_node.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <map>
#include <stdexcept>
#include <utility>

#include "core/bus/messages/convert.h"
#include "core/bus/run_loop.h"
#include "core/errors/log.h"
#include "core/geometry/rectification.h"
#include "core/io/maps/map_camera.h"
#include "core/map/keyframe_in_camera.h"
#include "core/process/order.h"
#include "core/process/process_usage.h"
#include "core/run/number_ranges.h"
#include "core/run/process_names.h"
#include "mapping_process/corrections/closure_check.h"
#include "mapping_process/node/keyframe_queue.h"
#include "plslam/command_t.hpp"
#include "plslam/status_t.hpp"

namespace plslam::mapping {
namespace {

constexpr std::chrono::milliseconds kTick(200);
// After a restart, history counts as complete after this time without a message, at most after the second.
constexpr double kHistoryQuiet_ms = 400.0;
constexpr double kLongestHistory_ms = 5000.0;

constexpr int kClosureKinds = 3;

/// Throws std::runtime_error if the file exists and is not an older state of the same map.
void CheckIsOlderState(const std::string& path, const Mapper& mapper) {
  if (!std::filesystem::exists(path)) return;
  const char* const remedy = "give another name, or --force to replace it";
  std::map<SessionId, StoredSession> sessions;
  try {
    sessions = ReadMapFile(path).sessions;
  } catch (const std::exception&) {
    throw std::runtime_error(fmt::format("{}: exists, and is not a map; {}", path, remedy));
  }
  const bool is_older = std::ranges::all_of(sessions, [&](const auto& s) { return mapper.HasSession(s.first); });
  if (!is_older) throw std::runtime_error(fmt::format("{}: exists, and is another map; {}", path, remedy));
}

/// Returns the newest keyframe number of each session.
std::map<SessionId, int64_t> NewestBySession(const StoredMap& stored) {
  std::map<SessionId, int64_t> newest;
  for (const auto& [id, session] : stored.sessions) newest[id] = session.session_keyframe_id;
  return newest;
}

}  // namespace

MappingNode::MappingNode(bus::Process& process, const MappingOptions& options)
    : process_(process),
      options_(options),
      publisher_(process.bus(), [this] { Queue([this] { queue_.AskForWhole(); }); }),
      queue_(options.loops.enabled, process.bus().options().partner_wait_s,
             options.state_file.empty() ? 0 : options.state_every),
      arrived_ms_(bus::NowMs()),
      counters_(process),
      disk_(process, options.state_file),
      camera_channel_(process.bus(), [this](const RigCalibration& rig) { OnCamera(rig); }),
      keyframes_(process.bus(), [this](const Keyframe& keyframe) { OnKeyframe(keyframe); }),
      closures_(process.bus(), [this](const LoopClosure& closure) { OnClosure(closure); }) {
  process_.bus().Subscribe<command_t>(bus::kCommand, [this](const command_t& message) { OnCommand(message); });
  process_.bus().Subscribe<status_t>(bus::kStatus, [this](const status_t& message) { OnStatus(message); });
  process_.bus().Every(kTick, [this] { OnTick(); });
  process_.SetConfiguration(ToYaml("mapping", options_));
  ReadState();
  if (!std::holds_alternative<MapperState>(beginning_) && !options_.map_file.empty()) {
    const StoredMap& stored = beginning_.emplace<StoredMap>(ReadMapFile(options_.map_file));
    camera_ = MapCamera(stored, options_.map_file);
    AdoptStored(stored);
  }
  worker_ = std::thread([this] { bus::RunGuarded(process_.bus(), [this] { WorkUntilStopped(); }); });
}

MappingNode::~MappingNode() {
  Queue([this] { stopping_ = true; });
  stop_solve_ = true;
  worker_.join();
}

/// Changes data shared with the worker, and wakes it.
template <class Change>
void MappingNode::Queue(const Change& change) {
  {
    const std::lock_guard lock(mutex_);
    change();
  }
  changed_.notify_one();
}

/// The map cannot begin without a camera; the first keyframe replaces it.
void MappingNode::OnCamera(const RigCalibration& rig) {
  if (!camera_) Queue([&] { camera_ = Rectify(rig).camera; });
}

void MappingNode::OnKeyframe(const Keyframe& keyframe) {
  if (keyframe.source == process_.bus().source()) return;  // our own, of a loaded map
  Queue([&] {
    const double now_ms = bus::NowMs();
    switch (membership_.RelationOf(keyframe)) {
      case MapMembership::Relation::kOfOtherMap:
        return Refuse(keyframe.name.session);
      case MapMembership::Relation::kOfNextMap:
        queue_.AddOfNextMap(keyframe, now_ms);
        break;
      case MapMembership::Relation::kOfThisMap:
        if (!queue_.Add(keyframe, now_ms)) return;
    }
    arrived_ms_ = now_ms;
    process_.SetCounter("queue.keyframes", static_cast<double>(queue_.n_keyframes()));
    // Under the lock: after it, this could end the solve of this very keyframe.
    if (!keyframe.lockstep) stop_solve_ = true;
  });
}

void MappingNode::Refuse(SessionId session) {
  const bool is_first = membership_.Refuse(session);
  process_.SetCounter("keyframes.other_map", static_cast<double>(membership_.n_refused()));
  if (!is_first) return;
  queue_.Drop(session);
  // Its tracker does not know yet that there is another map.
  queue_.AskForWhole();
}

void MappingNode::OnClosure(const LoopClosure& closure) {
  Queue([&] {
    queue_.OnSignOfLife(bus::NowS());
    queue_.Add(closure);
    arrived_ms_ = bus::NowMs();
  });
}

void MappingNode::OnStatus(const status_t& message) {
  if (message.process != process_name::kLoop) return;
  const std::lock_guard lock(mutex_);
  queue_.OnSignOfLife(bus::NowS());
}

/// Wakes the worker, too, so that it checks its timeouts.
void MappingNode::OnTick() {
  bool given_up = false;
  Queue([&] { given_up = queue_.GiveUp(bus::NowS()); });
  if (given_up) LogWarning("no loop_process is found: continuing without loops");
}

void MappingNode::OnCommand(const command_t& message) {
  const std::optional<bus::Order> order = bus::OrderTo(process_, message);
  static constexpr std::array kAccepted = {command_verb::kSave, command_verb::kReset, command_verb::kLoad,
                                           command_verb::kLocalise, command_verb::kSendKeyframes};
  if (!order || std::find(kAccepted.begin(), kAccepted.end(), order->verb) == kAccepted.end()) return;
  if (!camera_ && order->verb == command_verb::kSendKeyframes) return;
  // The worker does not run before a camera arrives; the sender of the command should not wait for that.
  if (!camera_) return bus::Answer(process_, *order, "no camera has been received, so there is no map");
  Queue([&] { queue_.Add(*order); });
}

void MappingNode::WorkUntilStopped() {
  {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return stopping_ || camera_; });
    if (stopping_) return;
  }
  const bool may_replace_another = MayReplaceAnother();
  BeginMap();
  if (may_replace_another) AwaitHistories();
  while (const std::optional<Work> work = NextWork()) Do(*work);
  WorkBeforeStop();
}

/// Inserts the keyframes of live sessions that have arrived, without adjusting them to the end, and writes the state.
/// In lockstep a keyframe that is not in the map is resent by its tracker.
void MappingNode::WorkBeforeStop() {
  for (;;) {
    std::optional<Work> work;
    {
      const std::lock_guard lock(mutex_);
      const double now_s = bus::NowS();
      if (!queue_.IsLockstep(now_s)) work = queue_.Take(now_s);
    }
    if (!work) break;
    stop_solve_ = true;
    Do(*work);
  }
  KeepState();
}

/// Makes it the map of this process, which assigns the ids from now on.
void MappingNode::Own(Mapper mapper) {
  mapper_.emplace(std::move(mapper));
  mapper_->SetNumbering(process_.bus().source());
}

/// Called when a camera is known.
void MappingNode::BeginMap() {
  auto beginning = std::exchange(beginning_, {});
  if (auto* state = std::get_if<MapperState>(&beginning)) return RestoreState(std::move(*state));
  auto* stored = std::get_if<StoredMap>(&beginning);
  Own(stored == nullptr ? Mapper(*camera_, options_) : Mapper(*camera_, options_, std::move(*stored)));
  mapper_->SetMapId(MapIdNow());
  if (stored == nullptr) {
    if (disk_.keeps_state()) LogInfo("beginning a new map: there is no {}", options_.state_file);
    return KeepState();
  }
  mapper_->Commit();
  PublishWhole();
  PublishKeyframes();
  process_.SetState(process_state::kRunning);
  LogStoredMap(options_.map_file);
  disk_.MoveOldFeatures(*mapper_);
}

/// Publishes the map before the keyframes: trackers wait for it, and most other processes have the features.
void MappingNode::RestoreState(MapperState state) {
  answer_ = state.answer;
  Own(Mapper(*camera_, options_, std::move(state)));
  if (mapper_->version() > 0) PublishWhole();
  process_.SetState(process_state::kRunning);
  PublishKeyframes();
  LogStoredMap(options_.state_file);
  disk_.MoveOldFeatures(*mapper_);
}

/// Publishes the keyframes of the map, or those with the given ids, as trackers do, for listeners that need their
/// features.
void MappingNode::PublishKeyframes(const std::optional<std::set<KeyframeId>>& ids) {
  bus::KeyframePublisher publisher(process_.bus());
  for (const auto& [id, entry] : mapper_->map().keyframes()) {
    if (ids && !ids->contains(id)) continue;
    const auto features = mapper_->features().find(id);
    if (features == mapper_->features().end()) continue;
    Keyframe keyframe = KeyframeOf(entry, features->second, mapper_->camera(), mapper_->map());
    keyframe.map_id = mapper_->map_id();
    publisher.Publish(keyframe);
  }
}

void MappingNode::LogStoredMap(const std::string& file) {
  if (mapper_->map().keyframes().empty()) return LogInfo("beginning a new map: that in {} is empty", file);
  LogInfo("continuing the map in {}: {} keyframes, {} points, {} lines", file, mapper_->map().keyframes().size(),
          mapper_->map().points().size(), mapper_->map().lines().size());
  counters_.Count(*mapper_);
}

/// Whether there may have been a mapping_process of this run before. It has written its state when it began its map.
bool MappingNode::MayReplaceAnother() const {
  return !disk_.keeps_state() || std::filesystem::exists(options_.state_file) ||
         std::filesystem::exists(UnreadableState());
}

/// After a restart several publishers resend their history: waits until nothing has arrived for a while, or for a
/// maximum time. Closures of the previous loop_process have then arrived before a keyframe is checked again.
void MappingNode::AwaitHistories() {
  std::unique_lock lock(mutex_);
  const double until_ms = bus::NowMs() + kLongestHistory_ms;
  const auto quiet_at_ms = [&] { return std::min(arrived_ms_ + kHistoryQuiet_ms, until_ms); };
  for (double now_ms = bus::NowMs(); !stopping_ && now_ms < quiet_at_ms(); now_ms = bus::NowMs()) {
    changed_.wait_for(lock, std::chrono::duration<double, std::milli>(quiet_at_ms() - now_ms));
  }
}

std::optional<WorkQueue::Work> MappingNode::NextWork() {
  std::unique_lock lock(mutex_);
  std::optional<Work> work;
  changed_.wait(lock, [&] {
    if (!stopping_) work = queue_.Take(bus::NowS());
    return stopping_ || work;
  });
  if (stopping_) return std::nullopt;
  stop_solve_ = false;
  process_.SetCounter("queue.keyframes", static_cast<double>(queue_.n_keyframes()));
  return work;
}

void MappingNode::Do(const Work& work) {
  switch (work.kind) {
    case Work::Kind::kInsert:
      return Insert(work.keyframes);
    case Work::Kind::kCorrect:
      return Correct(work);
    case Work::Kind::kCommit:
      mapper_->Commit();
      return Publish({});
    case Work::Kind::kAnswer:
      // A closure resent from a history may have its answer already.
      if (IsAnswerTo(answer_, work.closure)) return;
      Answer(work.closure, work.accepted);
      return Publish({});
    case Work::Kind::kPublishWhole:
      if (mapper_->version() > 0) return PublishWhole();
      // Before the first update there is nothing to publish, unless trackers still belong to an earlier map.
      if (!HasRefused()) return;
      mapper_->Commit();
      return Publish({});
    case Work::Kind::kOrder:
      return Execute(work.order);
    case Work::Kind::kKeepState:
      return KeepState();
    case Work::Kind::kBeginMap:
      LogInfo("beginning the map that replaced this one before a restart");
      return Replace({}, mapper_->camera(), work.map_id);
  }
}

void MappingNode::Insert(const std::vector<WorkQueue::Arrived>& batch) {
  const double began_ms = bus::NowMs();
  const Keyframe* newest = nullptr;
  int count = 0;
  for (const WorkQueue::Arrived& arrived : batch) {
    WarnOfMissing(arrived);
    std::string reason;
    if (InsertOne(arrived.keyframe, &reason)) {
      newest = &arrived.keyframe;
      ++count;
      continue;
    }
    if (!mapper_->localise_only()) LogWarning("left out: {}", reason);
    counters_.CountIgnored();
  }
  if (newest == nullptr) return;
  const double inserted_ms = bus::NowMs();
  mapper_->Adjust(&stop_solve_);
  const double adjusted_ms = bus::NowMs();
  mapper_->Cull();
  {
    const std::lock_guard lock(mutex_);
    queue_.Inserted(*newest, count, bus::NowS());
  }
  const double done_ms = bus::NowMs();
  Publish({{"insert", inserted_ms - began_ms},
           {stage_name::kAdjust, adjusted_ms - inserted_ms},
           {"cull", done_ms - adjusted_ms},
           {stage_name::kUpdate, done_ms - batch.front().received_ms}});
  disk_.Inserted(count, *mapper_);
}

/// Re-expresses the keyframe in the camera of the map, which is that of its first keyframe.
bool MappingNode::InsertOne(const Keyframe& keyframe, std::string* reason) {
  if (mapper_->map().keyframes().empty()) mapper_->SetCamera(keyframe.camera);
  if (const std::optional<Keyframe> local = KeyframeInCamera(mapper_->camera(), keyframe))
    return mapper_->Insert(*local, reason);
  *reason = fmt::format(
      "keyframe {} of session {}: its camera ({} px, {} m) differs too much from that of the map ({} px, {} m)",
      keyframe.name.number, keyframe.name.session, keyframe.camera.f_px, keyframe.camera.baseline_m,
      mapper_->camera().f_px, mapper_->camera().baseline_m);
  return false;
}

void MappingNode::WarnOfMissing(const WorkQueue::Arrived& arrived) {
  if (arrived.missing == 0) return;
  LogWarning("session {}: {} keyframes before number {} are missing; continuing without them",
             arrived.keyframe.name.session, arrived.missing, arrived.keyframe.name.number);
  counters_.CountMissing(arrived.missing);
}

void MappingNode::Correct(const Work& work) {
  const double began_ms = bus::NowMs();
  std::string reason;
  const bool corrects = work.closure.kind != LoopClosure::Kind::kNone;
  const bool corrected = corrects && mapper_->Correct(InOwnIds(work), &reason);
  bool commits = work.commits;
  if (work.closure.kind == LoopClosure::Kind::kLoop) Answer(work.closure, corrected);
  if (corrects && !corrected) {
    LogWarning("a correction of the map is rejected: {}", reason);
    const std::lock_guard lock(mutex_);
    if (work.closure.kind == LoopClosure::Kind::kLoop) commits |= queue_.Refused();
  }
  if (commits) mapper_->Commit();
  Publish(corrected ? Stages{{"correct", bus::NowMs() - began_ms}} : Stages{});
  if (corrected) disk_.MoveOldFeatures(*mapper_);
}

/// Re-expresses a closure that was computed with the ids of another mapping_process. A map rebuilt in lockstep has the
/// same ids; a live one, in which timing decides what is inserted together, has other landmark ids.
LoopClosure MappingNode::InOwnIds(const Work& work) const {
  const std::optional<MapVersion>& version = work.closure.map_version;
  if (version && version->numbering == process_.bus().source()) return work.closure;
  return InIdsOf(mapper_->map(), work.closure, work.lockstep ? MapIds::kPerhapsSame : MapIds::kOthers);
}

/// Publishes the answer with the next update, and with each one after it.
void MappingNode::Answer(const LoopClosure& loop, bool accepted) {
  answer_ = {loop.keyframe, loop.map_version, accepted};
}

void MappingNode::PublishWhole() {
  MapUpdate update = mapper_->Whole();
  update.answer = answer_;
  publisher_.Publish(update);
}

/// Writes the state first where it is due: after a crash, listeners must not know more of the map than its owner.
void MappingNode::Publish(Stages stage_ms) {
  MapUpdate update = mapper_->TakeUpdate();
  disk_.Note(update);
  if (disk_.keeps_state() && IsStateDue()) KeepState();
  update.answer = answer_;
  update.stage_ms = std::move(stage_ms);
  publisher_.Publish(update);
  if (update.version == 1) process_.SetState(process_state::kRunning);
  counters_.Count(*mapper_);
}

bool MappingNode::IsStateDue() {
  const std::lock_guard lock(mutex_);
  return queue_.TakeState(bus::NowS());
}

/// An order that fails changes nothing.
void MappingNode::Execute(const bus::Order& order) {
  if (order.verb == command_verb::kSendKeyframes) {
    std::set<KeyframeId> ids;
    for (const int64_t number : NumbersInRanges(order.argument)) ids.insert(KeyframeId(number));
    return PublishKeyframes(ids);
  }
  try {
    if (order.verb == command_verb::kSave) Save(order.argument);
    if (order.verb == command_verb::kLocalise) SetLocaliseOnly(order.argument);
    if (order.verb == command_verb::kReset) Replace({}, mapper_->camera());
    if (order.verb == command_verb::kLoad) {
      MapperState next;
      next.stored = ReadMapFile(order.argument);
      const StereoCamera camera = MapCamera(next.stored, order.argument);
      Replace(std::move(next), camera);
      LogStoredMap(order.argument);
    }
    bus::Answer(process_, order);
    disk_.MoveOldFeatures(*mapper_);
  } catch (const std::exception& error) {
    std::string failure = error.what();
    // Set by systemd; a service may write nowhere else.
    const char* const folder = std::getenv("STATE_DIRECTORY");
    if (order.verb == command_verb::kSave && folder != nullptr) {
      failure += fmt::format("; this service can write in {}", folder);
    }
    LogError("the command '{}' failed: {}", order.verb, failure);
    bus::Answer(process_, order, failure);
  }
}

void MappingNode::Save(const std::string& argument) {
  const bus::SaveRequest request = bus::ToSaveRequest(argument);
  if (!request.forced) CheckIsOlderState(request.file, *mapper_);
  mapper_->LendStored([&](StoredMap& stored) {
    stored.rig = CameraBytes(mapper_->camera());
    WriteMapFile(request.file, stored);
  });
  LogInfo("the map is saved in {}", request.file);
}

void MappingNode::SetLocaliseOnly(const std::string& argument) {
  const bool fixes = argument == localise_mode::kOn;
  if (!fixes && argument != localise_mode::kOff)
    throw std::runtime_error(fmt::format("localise \"{}\": must be on or off", argument));
  mapper_->SetLocaliseOnly(fixes);
  LogInfo("the map {}", mapper_->localise_only() ? "is fixed" : "can grow");
  Publish({});
  // A process killed later restarts in this mode; the newest keyframe is committed here (`WorkQueue::Take`).
  KeepState();
}

/// The map has the id `id`, or the next one.
void MappingNode::Replace(MapperState next, const StereoCamera& camera, const std::optional<MapId>& id) {
  mapper_->Precede(next);
  if (id) next.map_id = *id;
  {
    const std::lock_guard lock(mutex_);
    membership_.SetMapId(next.map_id);
    queue_.Reset(next.map_id, NewestBySession(next.stored), next.stored.newest_session);
  }
  answer_ = {};
  Own(Mapper(camera, options_, std::move(next)));
  disk_.BeginMap();
  PublishWhole();
  // Listeners keep few features of unknown sessions, so they must receive the map first.
  PublishKeyframes();
  counters_.Count(*mapper_);
  KeepState();
}

/// Called before anything arrives: keyframes in the state need not be resent. An unreadable state is ignored.
void MappingNode::ReadState() {
  if (options_.state_file.empty()) return;
  if (!std::filesystem::exists(options_.state_file)) {
    membership_.SetMapId({process_.bus().source(), 0});
    return;
  }
  try {
    MapperState state = ReadStateFile(options_.state_file);
    // Do not wait for the camera message, which comes once a second: it would be the longest part of a restart.
    camera_ = MapCamera(state.stored, options_.state_file);
    AdoptState(beginning_.emplace<MapperState>(std::move(state)));
  } catch (const std::exception& error) {
    // It may be of a later version of the program.
    const std::string kept = UnreadableState();
    std::error_code ignored;
    std::filesystem::rename(options_.state_file, kept, ignored);
    process_.Warn("state",
                  fmt::format("rebuilding the map from the history: {}; the file is kept as {}", error.what(), kept));
  }
}

void MappingNode::AdoptState(const MapperState& state) {
  const std::lock_guard lock(mutex_);
  membership_.SetMapId(state.map_id);
  const StoredMap& stored = state.stored;
  WorkQueue::Newest newest{{.session = stored.newest_session}, state.lockstep != 0, state.committed != 0, {}};
  const auto session = stored.sessions.find(stored.newest_session);
  if (session == stored.sessions.end()) newest.committed = true;
  if (session != stored.sessions.end()) newest.keyframe.number = session->second.session_keyframe_id;
  for (int kind = 0; kind < kClosureKinds; ++kind) {
    if ((state.closures >> kind & 1) != 0) newest.taken.insert(static_cast<LoopClosure::Kind>(kind));
  }
  queue_.Restore(NewestBySession(stored), newest, bus::NowS());
}

/// Marks the keyframes of the map as inserted. The history keeper republishes them, except for culled ones.
void MappingNode::AdoptStored(const StoredMap& stored) {
  const std::lock_guard lock(mutex_);
  queue_.Restore(NewestBySession(stored), stored.newest_session);
}

void MappingNode::KeepState() {
  const auto newest = [this] {
    const std::lock_guard lock(mutex_);
    return queue_.newest();
  };
  disk_.KeepState(*mapper_, answer_, newest());
}

MapId MappingNode::MapIdNow() {
  const std::lock_guard lock(mutex_);
  return membership_.map_id();
}

/// Whether keyframes of another map have arrived.
bool MappingNode::HasRefused() {
  const std::lock_guard lock(mutex_);
  return membership_.n_refused() > 0;
}

bus::ProcessSpec MappingSpec() {
  bus::ProcessSpec spec;
  spec.name = process_name::kMapping;
  spec.description = "The map of points and lines: keyframes in, updates of the map out.";
  spec.examples =
      "  mapping_process\n"
      "  mapping_process --config config/plslam.yaml --set mapping.map_file=house.plmap\n"
      "  mapping_process --prefix team/";
  spec.make_node = bus::NodeWithOptions<MappingNode, MappingOptions>(spec.name);
  spec.waits_for = "keyframes of vo_process";
  spec.results = {{"map.keyframes", "keyframes in the map"},
                  {"map.points", "points"},
                  {"map.lines", "lines"},
                  {"map.loops", "loops"}};
  return spec;
}

}  // namespace plslam::mapping
