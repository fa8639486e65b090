// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "core/process/order_sender.h"
#include "tools/launch/supervisor.h"
#include "tools/plslam/end_of_run.h"
#include "tools/plslam/node/history_node.h"
#include "tools/plslam/node/monitor_node.h"
#include "tools/plslam/run_console.h"
#include "tools/plslam/run_options.h"
#include "tools/plslam/stall_watch.h"

namespace plslam::launcher {

/// One run of the whole system: starts the processes of the table, the player when the others are ready, publishes the
/// end of the run (RUN), waits until the writers have handled it, has the map saved if requested, and stops all
/// processes (`Phase`). A process that fails ends the run early: frames that the player has sent before an unreadable
/// image are handled to the end, and the map is saved.
class RunSession {
 public:
  /// `options.url` and `options.out` are set.
  RunSession(const RunOptions& options, bus::Bus& bus);

  /// Returns when all processes have ended. Throws std::runtime_error if a program cannot be started.
  void Run();
  /// Ends the run early and cleanly, after saving the map if requested; safe from any thread.
  void Interrupt();
  /// Kills all processes at once; safe from any thread.
  void KillAll() { supervisor_.KillAll(); }

  /// Returns all values except for the accuracy.
  RunSummary Summary() const;
  /// Returns whether all processes have accepted dataset and configuration, and the outputs of earlier runs have been
  /// removed.
  bool accepted() const { return accepted_; }
  /// Returns whether the run reached the end of the stream, or was interrupted; with the map saved if requested, and
  /// all processes without failure.
  bool ended_well() const { return HasResult() && supervisor_.failed().empty(); }
  /// Returns whether the requested map was saved by this run.
  bool saved_map() const { return !options_.save_map.empty() && !lacks_map_; }

 private:
  using Clock = std::chrono::steady_clock;
  Supervisor::Options SupervisorOptions();
  enum class Phase {
    kStarting,    ///< until all processes but the source of frames are ready
    kPlaying,     ///< until the run is over (`EndOfRun`)
    kWriting,     ///< until viewer_headless and dense_process have written their files
    kCatchingUp,  ///< after an interrupt, until the viewer has every answered frame
    kSaving,      ///< until mapping_process has saved the map, if requested
    kStopping,    ///< until all processes have exited
  };

  void RemoveStates() const;
  void StartRows(bool last);
  void Tick();
  void ReportReadiness(Clock::time_point now);
  /// All processes but that of this name.
  bool AllReadyBut(const std::string& name) const;
  bool HearsSharedMap() const;
  void CheckAccepted();
  void CheckFailed(Clock::time_point now);
  void EndPlaying(Phase next, Clock::time_point now);
  void CheckStarted(Clock::time_point now);
  void CheckPlayed(Clock::time_point now);
  void CheckWritten(Clock::time_point now);
  void CheckStalled(Clock::time_point now);
  void CheckCaughtUp(Clock::time_point now);
  bool IsSaved() const;
  void CheckSaved(Clock::time_point now);
  bool WritersAreDone() const;
  bool ViewerHasCaughtUp() const;
  bool HasMap() const;
  /// Returns the reason why an interrupted run has no map to save.
  std::string LackOfMap() const;
  bool MapperHasMap() const;
  bool HasResult() const { return completed_ || (interrupted_ && !lacks_map_); }
  void PrintWaiting();
  void BeginStop(const std::string& reason);
  void EndStop();
  void ShowProgress(Clock::time_point now);

  RunOptions options_;
  bus::Bus& bus_;
  MonitorNode monitor_;
  HistoryKeeper keeper_;
  bus::OrderSender save_;
  Supervisor supervisor_;
  RunConsole console_;
  Phase phase_ = Phase::kStarting;
  Clock::time_point phase_began_ = Clock::now();
  Clock::time_point playing_since_;
  EndOfRun end_;
  StallWatch stall_watch_;
  std::string reason_;
  bool completed_ = false;
  bool interrupted_ = false;
  bool lacks_map_ = false;  ///< it was to be saved, and is not yet
  std::optional<Clock::time_point> failed_at_;
  bool accepted_ = false;
  const std::filesystem::file_time_type files_began_;
  double wall_s_ = 0.0;
};

}  // namespace plslam::launcher
