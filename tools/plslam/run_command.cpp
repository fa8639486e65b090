// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <signal.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdio>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "core/bus/options.h"
#include "core/config/config.h"
#include "core/datasets/camera_file.h"
#include "core/datasets/open_dataset.h"
#include "core/errors/error_text.h"
#include "core/files/atomic_file.h"
#include "core/process/process_signals.h"
#include "core/run/result_files.h"
#include "core/run/run.h"
#include "tools/command_line/number_checks.h"
#include "tools/command_line/version.h"
#include "tools/launch/run_bus.h"
#include "tools/plslam/commands.h"
#include "tools/plslam/offline_commands.h"
#include "tools/plslam/run_checks.h"
#include "tools/plslam/run_files.h"
#include "tools/plslam/run_session.h"

namespace plslam::launcher {
namespace {

/// Hands signals on to the session while there is one.
class SessionDoor {
 public:
  void Open(RunSession* session) {
    const std::scoped_lock lock(mutex_);
    session_ = session;
    if (session_ != nullptr && interrupted_) session_->Interrupt();
  }
  void Interrupt() {
    const std::scoped_lock lock(mutex_);
    interrupted_ = true;
    if (session_ != nullptr) session_->Interrupt();
  }
  void KillAll() {
    const std::scoped_lock lock(mutex_);
    if (session_ != nullptr) session_->KillAll();
  }

 private:
  std::mutex mutex_;
  RunSession* session_ = nullptr;
  bool interrupted_ = false;
};

constexpr int kWarned = 2;

/// The terminal, or the reader of a pipe, may have been closed: the run and its files do not need them.
void Print(std::FILE* to, const std::string& text) { std::fputs(text.c_str(), to); }

/// Returns the paths of the results, one line each.
std::string WhereToLook(const RunOptions& options, const RunSession& session) {
  const std::filesystem::path report = options.out / result_file::kReport;
  std::string text = std::filesystem::exists(report) ? fmt::format("  {:<10} {}\n", "report", report.string())
                                                     : fmt::format("  {:<10} {}\n", "outputs", options.out.string());
  if (session.saved_map()) {
    text += fmt::format("  {:<10} {}\n", "saved map", options.save_map.string());
  }
  return text;
}

/// If no frame was played, the results of an earlier run are kept in the folder, with their summary. Otherwise the
/// folder belongs to this run; a failed start leaves only the logs that its sentence points to.
void TakeFolder(const RunOptions& options, const RunSession& session, const RunSummary& summary,
                OutputFolder* folder) {
  const bool points_at_logs = summary.reason.find((options.out / "logs").string()) != std::string::npos;
  if (session.accepted() || session.ended_well() || points_at_logs) folder->Keep();
}

int Report(const RunOptions& options, const RunSession& session, OutputFolder* folder) {
  RunSummary summary = session.Summary();
  summary.version = VersionText();
  const bool keeps_old = !session.accepted() && folder->has_results();
  TakeFolder(options, session, summary, folder);
  if (session.accepted()) {
    const Run run = ReadRun(options.out, run_content::kTrajectory | run_content::kLive | run_content::kKeyframes |
                                             run_content::kTruth | run_content::kCovariances);
    summary.accuracy = AccuracyOf(run, summary.frames.all());
    summary.live_ate_m = LiveError_m(run);
    summary.path_m = PathLength_m(run);
  }
  const nlohmann::json json = SummaryToJson(summary);
  std::string reason = summary.reason;
  bool written = true;
  try {
    if (!keeps_old && folder->is_kept()) WriteSummary(options.out, json);
    if (session.accepted()) PutWarningsIntoReport(options.out, json["warnings"]);
  } catch (const std::exception& error) {
    // The run may have ended because of the same full disk.
    written = false;
    reason = Joined(reason, error.what());
  }
  const nlohmann::json& warnings = json["warnings"];
  // The last ones are those of the processes, which the session has printed.
  for (size_t i = 0; i + summary.warnings.size() < warnings.size(); ++i) {
    Print(stderr, fmt::format("plslam: warning: {}\n", warnings[i]["sentence"].get<std::string>()));
  }
  if (options.json) {
    Print(stdout, JsonText(json) + "\n");
  } else if (!options.quiet && summary.frames.answered() > 0) {
    Print(stdout, SummaryToText(json, options.verbose) + WhereToLook(options, session));
  }
  // A run that the user ends is as good as one that ends by itself: with `--loop` there is hardly another way.
  if (session.ended_well() && !keeps_old && written) {
    if (!options.quiet && !summary.completed && summary.frames.answered() == 0) {
      Print(stderr, fmt::format("plslam: {} before the first frame\n", summary.reason));
    }
    return options.strict && !warnings.empty() ? kWarned : 0;
  }
  Print(stderr,
        fmt::format("plslam: error: {}{}\n", reason,
                    keeps_old ? fmt::format(" ({} is still that of the previous run)", options.out.string()) : ""));
  return 1;
}

/// Returns the options of the own bus, as the other processes will read them.
bus::BusOptions BusOptionsOf(const RunOptions& options, const std::string& url) {
  Config config = options.config_file.empty() ? Config() : Config::FromFile(options.config_file);
  for (const std::string& assignment : options.overrides) config.Override(assignment);
  bus::BusOptions result;
  config.Read(kBusSection, result);
  result.url = url;
  if (!options.prefix.empty()) result.prefix = options.prefix;
  if (!options.map_prefix.empty()) result.map_prefix = options.map_prefix;
  // The configured loss applies to the processes under test.
  result.drop_fraction = 0.0;
  return result;
}

int RunProcesses(RunOptions options, OutputFolder* folder) {
  signal(SIGPIPE, SIG_IGN);
  SessionDoor door;
  // Before anything that starts threads, which must inherit the blocked signals.
  const bus::SignalWatcher signals([&](const std::string&) { door.Interrupt(); }, 0, [&] { door.KillAll(); });
  options.own_bus = options.url.empty();
  const RunBus run_bus(options.url);
  options.url = run_bus.url();
  bus::Bus bus(BusOptionsOf(options, run_bus.url()), "plslam");
  RunSession session(options, bus);
  door.Open(&session);
  session.Run();
  door.Open(nullptr);
  return Report(options, session, folder);
}

int Refine(const RunOptions& options) {
  std::fflush(stdout);
  const std::filesystem::path refined = options.out / "refined";
  std::vector<std::string> arguments{"refine", options.out, "--out", refined, "--camera", options.refine};
  if (options.quiet || options.json) arguments.emplace_back("--quiet");
  const int code = WaitForOfflineCommand(arguments);
  if (code == 0) PutRefinementIntoReport(options.out, refined / result_file::kSummary);
  return code;
}

int RunProcesses(RunOptions options) {
  options.from_ros2 = options.dataset.starts_with(kRos2Prefix);
  options.from_cameras = !options.from_ros2 && NamesSource(options.dataset);
  CheckLive(options);
  CheckSurfaces(options);
  ReadConfiguration(&options);
  options.dataset = WithTopics(options.dataset, options.kind, options.topics);
  if (options.out.empty()) options.out = DefaultOut(options.dataset);
  CheckOverrides(options);
  CheckMapToContinue(options);
  OutputFolder folder(options.out);
  CheckRefinement(&options);
  CheckFilesToWrite(options);
  const int code = RunProcesses(options, &folder);
  if (options.refine.empty() || code == 1) return code;
  return Refine(options) == 0 ? code : 1;
}

void AddOptions(CLI::App* sub, RunOptions* o) {
  sub->add_option("--out", o->out, "folder for trajectories, summary, pictures and logs [out/DATASET]")
      ->type_name("DIR");
  sub->add_option("--pace", o->pace,
                  "lockstep (every frame, as fast as possible; default for datasets), realtime (default for "
                  "cameras), realtimexN")
      ->type_name("TEXT:{lockstep,realtime}");
  sub->add_option("--features", o->features, "points, lines or both")
      ->check(CLI::IsMember({"points", "lines", "both"}))
      ->default_str("both");
  sub->add_flag("--no-mapping", o->no_mapping, "odometry only: no map is built or tracked against");
  sub->add_flag("--no-loops", o->no_loops, "no loop closing and no relocalisation");
  sub->add_flag("--dense", o->dense, "also surfaces, an OctoMap and a grid for planning (dense_process)")
      ->excludes("--no-mapping");
  sub->add_option("--map", o->map, "a saved map to continue")
      ->type_name("FILE")
      ->check(CLI::ExistingFile)
      ->excludes("--no-mapping");
  sub->add_flag("--localise-only", o->localise_only, "localise in the map given by --map without changing it")
      ->needs("--map");
  sub->add_option(
         "--refine", o->refine,
         "afterwards adjust the map as a whole, with the camera fixed, its intrinsics, or all; the results are "
         "in OUT/refined (plslam refine)")
      ->check(CLI::IsMember({"fixed", "intrinsics", "all"}))
      ->excludes("--no-mapping");
  sub->add_option("--save-map", o->save_map, "file for the map, saved at the end or when the run is interrupted")
      ->type_name("FILE")
      ->excludes("--no-mapping");
  sub->add_option("--config", o->config_file, "YAML file with options of all processes (docs/configuration.md)")
      ->type_name("FILE");
  sub->add_option("--set", o->overrides,
                  "one option, overrides the file: vo.features.orb.max_points=800 (repeatable)")
      ->type_name("KEY=VALUE")
      ->allow_extra_args(false);
  sub->add_option("--start", o->start, "first frame")->check(WholeNumberFrom(0))->default_str("0");
  sub->add_option("--stop", o->stop, "frame before which to stop [the end]")->check(WholeNumberFrom(0));
  sub->add_option("--stride", o->stride, "play every n-th frame")->check(WholeNumberFrom(1))->default_str("1");
  sub->add_option("--loop", o->loop, "number of times to play it")->check(WholeNumberFrom(1))->default_str("1");
  sub->add_flag("--bounce", o->bounce, "play it forth and back each time");
  sub->add_flag("--skip-bad", o->skip_bad, "skip unreadable frames, and count them");
  sub->add_option("--overlay-every", o->overlay_every, "a picture of the tracked features every N frames; 0: none")
      ->check(WholeNumberFrom(0))
      ->default_str("0");
  sub->add_option("--serve", o->serve, "show the run live at http://127.0.0.1:PORT/ (this machine only)")
      ->check(CLI::Range(1, 65535))
      ->type_name("PORT");
  sub->add_option("--video", o->video, "film of the run: an MP4 file, or a folder of pictures")->type_name("FILE");
  sub->add_option("--url", o->url, "LCM URL [a private port of this machine]");
  sub->add_option("--prefix", o->prefix, "prefix of each channel name");
  sub->add_option(
         "--map-prefix", o->map_prefix,
         "prefix of the mapping_process and loop_process that several robots share; this run then starts none")
      ->needs("--url")
      ->excludes("--map")
      ->excludes("--save-map");
  sub->add_option("--max-restarts", o->max_restarts, "how often a crashed process is restarted")
      ->check(WholeNumberFrom(0))
      ->capture_default_str();
  sub->add_flag("--quiet", o->quiet, "no progress and no summary on the terminal, only warnings and errors");
  sub->add_flag("--verbose", o->verbose,
                "also the contents of the map, all errors, and tables of times and processes");
  sub->add_flag("--strict", o->strict, "exit code 2 if the finished run has warnings");
  sub->add_flag("--force", o->force, "replace the file of --record or --save-map if it exists");
  sub->add_flag("--json", o->json, "the summary as JSON on standard output");
}

}  // namespace

void AddRunCommand(CLI::App* app, Command* command) {
  auto options = std::make_shared<RunOptions>();
  auto* sub = app->add_subcommand("run", "plays a dataset, or live cameras, through all processes");
  sub->add_option("dataset", options->dataset, DatasetHelp() + ", or rig file of live cameras")->required();
  sub->add_option("--kind", options->kind, fmt::format("format: {} [recognised from its files]", DatasetKindHelp()));
  sub->add_option("--topics", options->topics, "LEFT RIGHT: image topics of a ROS recording [recognised by name]")
      ->type_name("TOPIC")
      ->expected(2);
  sub->add_option("--record", options->record, "LCM event log of all traffic to write")->type_name("FILE");
  AddOptions(sub, options.get());
  sub->footer(
      "Examples:\n"
      "  plslam run synthetic:room --out out/room\n"
      "  plslam run /data/kitti/03 --features points --set vo.keyframes.max_frames=20\n"
      "  plslam run walk.mcap --topics /front/left/image_raw /front/right/image_raw\n"
      "  plslam run rig.yaml --record out/walk.lcm\n"
      "  plslam run /data/euroc/MH_01 --config config/plslam.yaml --record out/mh01.lcm\n"
      "Exit code 0 if the stream was processed to its end, or ended by SIGINT, SIGTERM or SIGHUP (and the map "
      "saved,\n"
      "with --save-map); 1 if not, with one sentence on standard error; 2 with --strict if it was, but "
      "there\n"
      "are warnings, which are on standard error, in summary.json and in the report. A second signal ends everything "
      "at once.");
  sub->callback([=] { *command = [options] { return RunProcesses(*options); }; });
}

void AddReplayCommand(CLI::App* app, Command* command) {
  auto options = std::make_shared<RunOptions>();
  options->kind = "log";
  auto* sub = app->add_subcommand("replay", "plays the frames of an LCM log and recomputes everything else");
  sub->add_option("log", options->dataset, "LCM log made by `plslam record`, `plslam run --record` or lcm-logger")
      ->required();
  AddOptions(sub, options.get());
  sub->footer("Example:\n  plslam replay out/mh01.lcm --out out/mh01_again");
  sub->callback([=] { *command = [options] { return RunProcesses(*options); }; });
}

}  // namespace plslam::launcher
