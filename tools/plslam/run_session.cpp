// SPDX-License-Identifier: BSD-3-Clause
#include "tools/plslam/run_session.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <utility>

#include "core/bus/run_loop.h"
#include "core/errors/error_text.h"
#include "core/errors/standard_streams.h"
#include "core/files/shared_file.h"
#include "core/run/process_names.h"
#include "tools/plslam/node/run_publisher.h"
#include "tools/plslam/process_table.h"
#include "tools/plslam/run_checks.h"

namespace plslam::launcher {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr seconds kStartLimit{60};
// A recording without an index is read completely before its first frame.
constexpr seconds kOpenLimit{3600};
/// For the first status of the mapping_process that several robots share, which publishes one every second.
constexpr seconds kSharedMapLimit{10};
/// For the end of the stream of a player that cannot read an image.
constexpr milliseconds kEndLimit{2000};
constexpr seconds kRunSaveLimit{60};
/// For a viewer that has not received all messages yet when the run is interrupted, for example after a restart.
constexpr seconds kCatchUpLimit{20};

double SecondsSince(std::chrono::steady_clock::time_point from) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - from).count();
}

}  // namespace

RunSession::RunSession(const RunOptions& options, bus::Bus& bus)
    : options_(options),
      bus_(bus),
      monitor_(bus),
      keeper_(bus, options.out),
      save_(bus),
      supervisor_(SupervisorOptions()),
      console_(options),
      lacks_map_(!options.save_map.empty()),
      files_began_(FileTimeNow(options)) {
  bus_.Every(milliseconds(50), [this] { Tick(); });
}

Supervisor::Options RunSession::SupervisorOptions() {
  Supervisor::Options options;
  options.bin = ProgramFolder();
  options.logs = options_.out / "logs";
  options.max_restarts = options_.max_restarts;
  options.arguments_of_restart = [this](const std::string& name, int restart, std::vector<std::string> arguments) {
    return ArgumentsOfRestart(options_, {name, restart, monitor_.statistics().newest_frame(), monitor_.is_paused()},
                              std::move(arguments));
  };
  options.last_word = [this](pid_t pid) { return monitor_.FailureOf(pid); };
  options.on_exit = [this](pid_t pid) { keeper_.OnExit(pid); };
  options.on_restart = [this](const std::string& name, const std::string& how, int restart) {
    console_.PrintRestart(name, how, restart);
  };
  return options;
}

void RunSession::Run() {
  RemoveStates();
  StartRows(false);
  bus_.Run();
  console_.PrintNew(monitor_.warnings());
  RemoveStates();
  console_.Clear();
}

void RunSession::RemoveStates() const {
  for (const std::string process : {process_name::kVo, process_name::kMapping, process_name::kDense}) {
    const std::filesystem::path file = StateFileOf(options_, process);
    std::filesystem::remove(file);
    // A partial file of a process that was killed while it wrote.
    std::filesystem::remove(file.string() + ".part");
  }
}

void RunSession::Interrupt() {
  bus_.Post([this] {
    if (phase_ == Phase::kStopping) return;
    interrupted_ = true;
    const bool saves = lacks_map_ && HasMap();
    console_.PrintStop(saves ? fmt::format("stopping, and saving the map as {}", options_.save_map.string())
                             : "stopping");
    if (phase_ == Phase::kStarting) return BeginStop(lacks_map_ ? LackOfMap() : kInterrupted);
    if (phase_ != Phase::kPlaying && phase_ != Phase::kWriting) return;
    supervisor_.Interrupt(SourceOfFrames(options_));
    EndPlaying(Phase::kCatchingUp, Clock::now());
  });
}

bool RunSession::HasMap() const { return monitor_.map().version() > 0 || monitor_.statistics().keyframes() > 0; }

std::string RunSession::LackOfMap() const {
  return fmt::format("interrupted before there was a map to save as {}", options_.save_map.string());
}

void RunSession::EndPlaying(Phase next, Clock::time_point now) {
  phase_ = next;
  phase_began_ = now;
  wall_s_ = SecondsSince(playing_since_);
}

void RunSession::StartRows(bool last) {
  for (const ProcessRow& row : ProcessTable()) {
    if (row.starts_last != last || !row.wanted(options_)) continue;
    supervisor_.Start(std::string(row.name), std::string(row.executable), ArgumentsOf(row, options_), row.ending,
                      NicenessOf(row, options_));
  }
}

void RunSession::Tick() {
  const auto now = Clock::now();
  ReportReadiness(now);
  console_.PrintNew(monitor_.warnings());
  PrintWaiting();
  supervisor_.Tick(now);
  if (phase_ != Phase::kStopping && !supervisor_.failed().empty()) CheckFailed(now);
  if (!accepted_) CheckAccepted();
  if (phase_ == Phase::kStarting) CheckStarted(now);
  if (phase_ == Phase::kPlaying) CheckPlayed(now);
  if (phase_ == Phase::kWriting) CheckWritten(now);
  if (phase_ == Phase::kCatchingUp) CheckCaughtUp(now);
  if (phase_ == Phase::kSaving) CheckSaved(now);
  if (phase_ == Phase::kStopping && supervisor_.stopped()) EndStop();
  ShowProgress(now);
}

void RunSession::ReportReadiness(Clock::time_point now) {
  for (const ProcessReport& report : supervisor_.reports()) {
    const std::string state = monitor_.StateOf(supervisor_.pid(report.name));
    if (state == process_state::kReady || state == process_state::kRunning) supervisor_.SetReady(report.name, now);
  }
}

bool RunSession::AllReadyBut(const std::string& name) const {
  const auto reports = supervisor_.reports();
  return std::all_of(reports.begin(), reports.end(), [&](const ProcessReport& report) {
    const std::string state = monitor_.StateOf(supervisor_.pid(report.name));
    return state == process_state::kReady || state == process_state::kRunning || report.name == name;
  });
}

bool RunSession::HearsSharedMap() const {
  const bool shared = !options_.map_prefix.empty() && !options_.no_mapping;
  return !shared || monitor_.Hears(process_name::kMapping);
}

/// The player has opened its dataset: from here on this run is the one in the folder. Poses on the bus are no sign of
/// it, since they may be those of another run on the same bus.
void RunSession::CheckAccepted() {
  const std::string player = monitor_.StateOf(supervisor_.pid(SourceOfFrames(options_)));
  const bool plays =
      player == process_state::kReady || player == process_state::kRunning || player == process_state::kFinished;
  if (!plays) return;
  accepted_ = true;
  RemoveOldOutputs(options_, files_began_);
}

/// There is nothing to save before the first frame.
void RunSession::CheckFailed(Clock::time_point now) {
  if (!failed_at_) failed_at_ = now;
  if (!accepted_ || phase_ == Phase::kStarting) return BeginStop("");
  // A player that cannot read an image ends the stream there: earlier frames are handled as always.
  const bool may_drain = monitor_.stream_ended() || now - *failed_at_ < kEndLimit;
  if (supervisor_.failed() == SourceOfFrames(options_) && monitor_.statistics().frames().answered() > 0 && may_drain)
    return;
  if (!lacks_map_ || supervisor_.failed() == process_name::kMapping) return BeginStop("");
  if (phase_ == Phase::kSaving) return;
  // Save the current map, before the end of the stream.
  supervisor_.Interrupt(SourceOfFrames(options_));
  EndPlaying(Phase::kSaving, now);
}

void RunSession::CheckStarted(Clock::time_point now) {
  const bool all_ready = AllReadyBut("");
  const seconds limit = AllReadyBut(process_name::kPlayer) ? kOpenLimit : kStartLimit;
  if (all_ready && HearsSharedMap()) {
    phase_ = Phase::kPlaying;
    phase_began_ = playing_since_ = now;
    stall_watch_.Begin(now);
    PublishRunBegin(bus_);
    // The viewer is ready, so the page is served.
    if (options_.serve > 0 && !options_.quiet) PrintError(fmt::format("live: http://127.0.0.1:{}/", options_.serve));
    if (options_.own_bus && !options_.quiet) {
      PrintError(fmt::format("bus: --url '{}' for plslam top, pause, save, ...", options_.url));
    }
    StartRows(true);
  } else if (all_ready && now - phase_began_ > kSharedMapLimit) {
    BeginStop(fmt::format(
        "no mapping_process with the prefix {0} was found on {1}: start `mapping_process --prefix {0} --url {1}` and "
        "`loop_process --prefix {0} --url {1}` first, or omit --map-prefix",
        options_.map_prefix, options_.url));
  } else if (now - phase_began_ > limit) {
    BeginStop(fmt::format("not all processes were ready after {} s; see {}", limit.count(),
                          (options_.out / "logs").string()));
  }
}

void RunSession::CheckPlayed(Clock::time_point now) {
  const MonitorNode::Processes processes{supervisor_.pid(SourceOfFrames(options_)),
                                         supervisor_.pid(process_name::kVo), !options_.no_mapping};
  if (end_.Look(monitor_.SignsOfEnd(processes, bus::NowS()), now) != EndOfRun::Wait::kNothing) {
    return CheckStalled(now);
  }
  PublishRunEnd(
      bus_, {monitor_.published_frames(), monitor_.statistics().frames().answered(), monitor_.committed_keyframe()});
  phase_ = Phase::kWriting;
}

void RunSession::CheckWritten(Clock::time_point now) {
  WritersAreDone() ? EndPlaying(Phase::kSaving, now) : CheckStalled(now);
}

void RunSession::CheckStalled(Clock::time_point now) {
  const std::string stall =
      stall_watch_.Look(monitor_.Signs(supervisor_.pid(process_name::kViewer), bus::NowS()), now);
  if (!stall.empty()) BeginStop(fmt::format("{}; see {}", stall, (options_.out / "logs").string()));
}

/// Returns whether viewer_headless and dense_process have written their outputs as far as possible. If some could not be
/// written, the exit code reports that when they are stopped.
bool RunSession::WritersAreDone() const {
  const auto is_done = [this](const char* name) {
    const std::string state = monitor_.StateOf(supervisor_.pid(name));
    return state == process_state::kFinished || state == process_state::kFailed;
  };
  return is_done(process_name::kViewer) && (!options_.dense || is_done(process_name::kDense));
}

/// The outputs must contain all answered frames. A restarted viewer receives earlier messages again; any other may be
/// slow on a busy machine.
bool RunSession::ViewerHasCaughtUp() const {
  return monitor_.FramesOf(supervisor_.pid(process_name::kViewer)) >= monitor_.statistics().frames().answered();
}

/// A restarted mapper has no map before it has received the first keyframe again.
bool RunSession::MapperHasMap() const {
  return monitor_.statistics().keyframes() == 0 ||
         monitor_.StateOf(supervisor_.pid(process_name::kMapping)) == process_state::kRunning;
}

void RunSession::CheckCaughtUp(Clock::time_point now) {
  const bool has_all = ViewerHasCaughtUp();
  if (!has_all && now - phase_began_ < kCatchUpLimit) return;
  if (!has_all) {
    interrupted_ = false;  // the results of the run are incomplete
    return BeginStop(fmt::format("interrupted, and the viewer did not receive all poses within {} s; see {}",
                                 kCatchUpLimit.count(), (options_.out / "logs").string()));
  }
  // A keyframe may have arrived since the order.
  if (lacks_map_ && !HasMap()) return BeginStop(LackOfMap());
  phase_ = Phase::kSaving;
  phase_began_ = now;
}

/// Whether the map is saved, and the surfaces beside it.
bool RunSession::IsSaved() const {
  return save_.answer() == "" && (!options_.dense || failed_at_ || save_.HasAnswered(process_name::kDense));
}

void RunSession::CheckSaved(Clock::time_point now) {
  if (lacks_map_ && !IsSaved()) {
    if (MapperHasMap() && !save_.has_sent()) {
      save_.Send(*bus::FindOrder(command_verb::kSave), (options_.force ? command_verb::kForce : "") +
                                                           std::filesystem::absolute(options_.save_map).string());
    }
    const std::string interrupted = interrupted_ ? kInterrupted : "";
    if (save_.answer() && *save_.answer() != "")
      return BeginStop(Joined(interrupted, "the map could not be saved: " + *save_.answer()));
    if (now - phase_began_ < kRunSaveLimit) return;
    return BeginStop(Joined(
        interrupted, fmt::format("{} could not be saved as {} within {} s; see {}",
                                 save_.answer() ? "the surfaces of the map" : "the map", options_.save_map.string(),
                                 kRunSaveLimit.count(), (options_.out / "logs").string())));
  }
  const bool saved = std::exchange(lacks_map_, false);
  // One that has been killed meanwhile writes its files once more.
  if (!interrupted_ && !failed_at_ && !WritersAreDone()) {
    phase_ = Phase::kWriting;
    return;
  }
  completed_ = !interrupted_ && !failed_at_;
  // Localising only in the map of another place gives no result at all.
  if (completed_ && options_.localise_only && monitor_.frames().tracked == 0) {
    completed_ = false;
    return BeginStop(
        fmt::format("the camera was not recognised in {}: is it the map of this place?", options_.map.string()));
  }
  BeginStop(interrupted_          ? kInterrupted
            : failed_at_ && saved ? "the map made so far is saved as " + options_.save_map.string()
                                  : "");
}

/// Prints what the camera or robot waits for, as long as there has been no frame.
void RunSession::PrintWaiting() {
  const char* const source = SourceOfFrames(options_);
  const bool waits = phase_ == Phase::kPlaying && monitor_.statistics().frames().answered() == 0;
  if (waits && std::string_view(source) != process_name::kPlayer) {
    console_.PrintAwaited(monitor_.ReasonOf(supervisor_.pid(source)));
  }
}

void RunSession::BeginStop(const std::string& reason) {
  if (wall_s_ == 0.0 && phase_ != Phase::kStarting) wall_s_ = SecondsSince(playing_since_);
  phase_ = Phase::kStopping;
  reason_ = reason;
  keeper_.Stop();
  supervisor_.Stop(Clock::now());
}

/// An error while the processes stopped fails a run that had completed; otherwise the reason why it stopped is more
/// informative. All processes have had time to publish their failures.
void RunSession::EndStop() {
  if (failed_at_) {
    reason_ = Joined(supervisor_.failure(), reason_);
  } else if (HasResult() && !supervisor_.failed().empty()) {
    reason_ = Joined(reason_, supervisor_.failure());
    completed_ = false;
  }
  bus_.Stop();
}

void RunSession::ShowProgress(Clock::time_point now) {
  if (phase_ != Phase::kPlaying && phase_ != Phase::kWriting) return;
  const RunStatistics& s = monitor_.statistics();
  const double played_s = std::max(std::chrono::duration<double>(now - playing_since_).count(), 1e-3);
  // Skipped frames are done, too.
  const int64_t frames = s.frames().answered() + s.frames().skipped;
  console_.Show({frames, monitor_.total_frames(), static_cast<double>(frames) / played_s, s.last().tracked_points,
                 s.last().tracked_lines, s.keyframes(), TrackingStateName(s.last().state), monitor_.messages().lost,
                 s.frames().skipped, supervisor_.restarts(), monitor_.LagAt(bus::NowS()).text});
}

RunSummary RunSession::Summary() const {
  RunSummary summary;
  summary.dataset = options_.dataset;
  summary.map_file = options_.map.string();
  summary.completed = completed_;
  summary.reason = reason_;
  summary.wall_s = wall_s_;
  // Without a player of this run, frames and maps on the bus are those of another one.
  static const RunStatistics kNoFrames{};
  summary.statistics = accepted_ ? &monitor_.statistics() : &kNoFrames;
  if (accepted_) {
    summary.frames = monitor_.frames();
    summary.counters = monitor_.counters();
    summary.map = &monitor_.map();
    summary.loops = &monitor_.loops();
  }
  summary.warnings = monitor_.warnings();
  summary.messages = monitor_.messages();
  summary.processes = supervisor_.reports();
  const Lag lag = monitor_.LagAt(bus::NowS());
  for (ProcessReport& report : summary.processes) {
    for (int i = 0; report.name == process_name::kRecorder && i <= report.restarts; ++i) {
      summary.recordings.push_back(RecordingOf(options_, i).string());
    }
    const auto longest = lag.longest_queue.find(report.name);
    if (longest != lag.longest_queue.end()) report.longest_queue = longest->second;
  }
  for (const auto& [process, status] : monitor_.processes())
    summary.configurations[status.process] = status.configuration;
  return summary;
}

}  // namespace plslam::launcher
