#include "tools/plslam/run_session.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "core/bus/worker.h"
#include "core/io/shared_file.h"
#include "tools/plslam/process_table.h"
#include "tools/plslam/run_checks.h"

namespace plslam {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr seconds kStartLimit{60};
/// For the last messages of the launcher itself, once the viewer has everything.
constexpr milliseconds kSettleLimit{2000};
constexpr seconds kRunSaveLimit{60};

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
      progress_line_(!options.quiet && !options.json),
      phase_began_(began_),
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
    return ArgumentsOfRestart(options_, {name, restart, monitor_.statistics().newest_frame()}, std::move(arguments));
  };
  options.on_exit = [this](pid_t pid) { keeper_.OnExit(pid); };
  return options;
}

void RunSession::Run() {
  RemoveStates();
  StartRows(false);
  bus_.Run();
  RemoveStates();
  progress_line_.Clear();
}

void RunSession::RemoveStates() const {
  for (const std::string process : {"vo", "mapping"}) {
    const std::filesystem::path file = StateFileOf(options_, process);
    std::filesystem::remove(file);
    // Of one that was killed while it wrote.
    std::filesystem::remove(file.string() + ".part");
  }
}

void RunSession::Interrupt() {
  bus_.Post([this] {
    if (phase_ == Phase::kStopping) return;
    interrupted_ = true;
    if (!lacks_map_) return BeginStop("interrupted");
    if (phase_ == Phase::kStarting) {
      return BeginStop(fmt::format("interrupted before there was a map to save as {}", options_.save_map.string()));
    }
    if (phase_ == Phase::kSaving) return;
    supervisor_.Interrupt("player");
    phase_ = Phase::kSaving;
    phase_began_ = Clock::now();
    wall_s_ = SecondsSince(playing_since_);
  });
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
  TellReadiness(now);
  supervisor_.Tick(now);
  if (phase_ != Phase::kStopping && !supervisor_.failure().empty()) BeginStop(supervisor_.failure());
  if (!accepted_) CheckAccepted();
  if (phase_ == Phase::kStarting) CheckStarted(now);
  if (phase_ == Phase::kPlaying) CheckPlayed(now);
  if (phase_ == Phase::kSettling) CheckSettled(now);
  if (phase_ == Phase::kSaving) CheckSaved(now);
  if (phase_ == Phase::kStopping && supervisor_.stopped()) EndStop();
  ShowProgress(now);
}

void RunSession::TellReadiness(Clock::time_point now) {
  for (const ProcessReport& report : supervisor_.reports()) {
    const std::string state = monitor_.StateOf(supervisor_.pid(report.name));
    if (state == "ready" || state == "running") supervisor_.SetReady(report.name, now);
  }
}

bool RunSession::AllReady() const {
  const auto reports = supervisor_.reports();
  return std::all_of(reports.begin(), reports.end(), [&](const ProcessReport& report) {
    const std::string state = monitor_.StateOf(supervisor_.pid(report.name));
    return state == "ready" || state == "running";
  });
}

/// The player, which is the last to be started, has opened its dataset: from here on this run is the one in the folder.
void RunSession::CheckAccepted() {
  const std::string player = monitor_.StateOf(supervisor_.pid("player"));
  const bool plays = player == "ready" || player == "running" || player == "finished";
  if (!plays && monitor_.statistics().frames().answered() == 0) return;
  accepted_ = true;
  RemoveOldOutputs(options_, files_began_);
}

void RunSession::CheckStarted(Clock::time_point now) {
  if (AllReady()) {
    phase_ = Phase::kPlaying;
    phase_began_ = playing_since_ = now;
    stall_watch_.Begin(now);
    // The viewer is ready: somebody answers there.
    const bool tells = options_.serve > 0 && !options_.quiet;
    if (tells) fmt::print(stderr, "live: http://127.0.0.1:{}/\n", options_.serve);
    StartRows(true);
  } else if (now - phase_began_ > kStartLimit) {
    BeginStop(fmt::format("not all processes were ready after {} s; see {}", kStartLimit.count(),
                          (options_.out / "logs").string()));
  }
}

void RunSession::CheckPlayed(Clock::time_point now) {
  const pid_t viewer = supervisor_.pid("viewer");
  if (monitor_.StateOf(viewer) == "finished") {
    phase_ = Phase::kSettling;
    phase_began_ = now;
    wall_s_ = SecondsSince(playing_since_);
    return;
  }
  const std::string stall = stall_watch_.Look(monitor_.Signs(viewer, bus::NowS()), now);
  if (!stall.empty()) BeginStop(fmt::format("{}; see {}", stall, (options_.out / "logs").string()));
}

void RunSession::CheckSettled(Clock::time_point now) {
  if (!monitor_.has_all() && now - phase_began_ < kSettleLimit) return;
  phase_ = Phase::kSaving;
  phase_began_ = now;
}

void RunSession::CheckSaved(Clock::time_point now) {
  if (lacks_map_ && save_.result() != SaveNode::Result::kSaved) {
    save_.Send(std::filesystem::absolute(options_.save_map));
    const bool failed = save_.result() == SaveNode::Result::kFailed;
    if (!failed && now - phase_began_ < kRunSaveLimit) return;
    return BeginStop(fmt::format("the map could not be saved as {}; see {}", options_.save_map.string(),
                                 (options_.out / "logs").string()));
  }
  lacks_map_ = false;
  completed_ = !interrupted_;
  BeginStop(interrupted_ ? "interrupted" : "");
}

void RunSession::BeginStop(const std::string& reason) {
  if (wall_s_ == 0.0 && phase_ != Phase::kStarting) wall_s_ = SecondsSince(playing_since_);
  phase_ = Phase::kStopping;
  reason_ = reason;
  keeper_.Stop();
  supervisor_.Stop(Clock::now());
}

/// What went wrong while the processes stopped spoils a run that had gone well; otherwise why it stopped says more.
void RunSession::EndStop() {
  if (HasResult() && !supervisor_.failure().empty()) {
    reason_ += (reason_.empty() ? "" : "; ") + supervisor_.failure();
    completed_ = false;
  }
  bus_.Stop();
}

void RunSession::ShowProgress(Clock::time_point now) {
  if (phase_ != Phase::kPlaying) return;
  const RunStatistics& s = monitor_.statistics();
  const double played_s = std::max(std::chrono::duration<double>(now - playing_since_).count(), 1e-3);
  // Those passed over are done with, too.
  const int64_t frames = s.frames().answered() + s.frames().skipped;
  progress_line_.Show({frames, monitor_.total_frames(), static_cast<double>(frames) / played_s,
                       s.last().tracked_points, s.last().tracked_lines, s.keyframes(),
                       TrackingStateName(s.last().state), monitor_.messages().lost, s.frames().skipped,
                       supervisor_.restarts(), monitor_.LagAt(bus::NowS()).text});
}

RunSummary RunSession::Summary() const {
  RunSummary summary;
  summary.dataset = options_.dataset;
  summary.completed = completed_;
  summary.reason = reason_;
  summary.wall_s = wall_s_;
  summary.frames = monitor_.frames();
  summary.counters = monitor_.counters();
  summary.statistics = &monitor_.statistics();
  summary.map = &monitor_.map();
  summary.loops = &monitor_.loops();
  summary.messages = monitor_.messages();
  summary.processes = supervisor_.reports();
  const Lag lag = monitor_.LagAt(bus::NowS());
  for (ProcessReport& report : summary.processes) {
    for (int i = 0; report.name == "recorder" && i <= report.restarts; ++i) {
      summary.recordings.push_back(RecordingOf(options_, i).string());
    }
    const auto longest = lag.longest_queue.find(report.name);
    if (longest != lag.longest_queue.end()) report.longest_queue = longest->second;
  }
  for (const auto& [process, status] : monitor_.processes())
    summary.configurations[status.process] = status.configuration;
  return summary;
}

}  // namespace plslam
