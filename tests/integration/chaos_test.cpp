// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <iostream>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <random>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "core/io/maps/map_file.h"
#include "tests/integration/whole_run.h"
#include "tests/support/data_folder.h"
#include "tests/support/long_tests.h"
#include "tests/support/sanitized.h"
#include "tests/support/text_file.h"
#include "tools/launch/child_process.h"

// Faults at random moments of a run over the results of an earlier one. In all cases the run ends with the complete and
// correct result, or with a non-zero exit code and a sentence, and the previous map is not lost.
//
// Coverage: each fault of `AllTroubles` in turn, one for each run, at moments that are spread evenly from the start of
// `plslam` to just after its end,
//  * in lockstep, over 120 frames: a completed run is bit-identical to an undisturbed one (11 moments, 200 in the
//    soak);
//  * live, over a minute (1200 frames, 20 a second): a completed run has all frames, and follows the truth (200
//    moments, in the soak alone);
//  * and a disk that gets full, in lockstep (2 moments, 50 in the soak).
// Several runs are executed in parallel, each in its own folder and on its own port: those of a minute take 200 x 40 s
// / 6 = 22 minutes. Repeated kills in one run are tested in kill_test.cpp.
//
// PLSLAM_CHAOS_SEED and PLSLAM_CHAOS_EVENTS replace the defaults, PLSLAM_CHAOS_ONLY=N plays only the Nth of them.

namespace plslam::launcher {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

constexpr std::array<const char*, 5> kPrograms{"player", "vo_process", "mapping_process", "loop_process",
                                               "viewer_headless"};
constexpr const char* kResults[] = {"trajectory.tum", "keyframes.tum", "map.ply", "covariance.txt"};
/// After which a run must have ended, whatever happened to it: on a machine with thirty processes for each core a
/// minute takes six.
constexpr std::chrono::seconds kEndLimit{1200};
constexpr const char* kEarlierPath = "0 0 0 0 0 0 0 1\n";

int FromEnvironment(const char* name, int otherwise) {
  const char* const text = std::getenv(name);
  return text != nullptr ? std::atoi(text) : otherwise;
}

/// The dataset, and the number of parallel runs: runs in lockstep use all processors, live ones a tenth of one each.
struct World {
  std::string dataset;
  std::string pace;
  int frames = 0;
  int side_by_side = 1;
};

World LockstepWorld() { return {"synthetic:room?size=160x120&frames=120", "lockstep", 120, 2}; }
World MinuteWorld() { return {"synthetic:room?size=160x120&frames=1200", "realtime", 1200, 6}; }

/// Sentences about violated promises.
using Wrong = std::vector<std::string>;

void Expect(bool good, const std::string& what, Wrong* wrong) {
  if (!good) wrong->push_back(what);
}

/// Everything that belongs to one world of trouble: the folder of the run, the map it saves, and its log.
class ChaosRun {
 public:
  explicit ChaosRun(const World& world) : world_(world) {
    std::string pattern = testing::TempDir() + "chaos XXXXXX";
    folder_ = mkdtemp(pattern.data());
  }
  ~ChaosRun() {
    if (child_) {
      for (const pid_t pid : Children()) kill(pid, SIGKILL);
    }
    child_.reset();
    std::error_code ignored;
    if (std::getenv("PLSLAM_KEEP_RUNS") == nullptr) fs::remove_all(folder_, ignored);
  }
  ChaosRun(const ChaosRun&) = delete;
  ChaosRun& operator=(const ChaosRun&) = delete;

  fs::path out() const { return folder_ / "out"; }
  fs::path map() const { return folder_ / "room.plmap"; }
  fs::path log() const { return folder_ / "plslam.log"; }

  std::vector<std::string> Arguments() const {
    return {"run",          world_.dataset, "--pace",       world_.pace,      "--out",
            out().string(), "--save-map",   map().string(), "--max-restarts", "3"};
  }
  void Start() { child_ = std::make_unique<ChildProcess>(test::BinaryFolder() / "plslam", Arguments(), log()); }
  const ChildProcess& child() const { return *child_; }

  /// Exit code; nullopt where the run does not end.
  std::optional<int> Wait() {
    std::optional<ChildExit> end;
    const auto limit = Clock::now() + test::Patience(kEndLimit);
    while (!(end = child_->Poll()) && Clock::now() < limit) std::this_thread::sleep_for(std::chrono::milliseconds(5));
    if (end) return end->code;
    child_->Signal(SIGKILL);
    return std::nullopt;
  }

  /// Returns the processes of this run without the launcher, found by their command lines.
  std::vector<pid_t> Children(std::string_view program = "") const {
    std::vector<pid_t> pids;
    for (const auto& entry : fs::directory_iterator("/proc")) {
      const pid_t pid = std::atoi(entry.path().filename().c_str());
      if (pid <= 0 || pid == child_->pid()) continue;
      const std::string command = ReadText(entry.path() / "cmdline");
      const std::string parent = fmt::format("--parent{}{}{}", '\0', child_->pid(), '\0');
      if (command.find(parent) == std::string::npos) continue;
      std::error_code gone;
      const std::string executable = fs::read_symlink(entry.path() / "exe", gone).filename();
      if (program.empty() || executable == program) pids.push_back(pid);
    }
    return pids;
  }

  std::string Log() const { return ReadText(log()); }

 private:
  World world_;
  fs::path folder_;
  std::unique_ptr<ChildProcess> child_;
};

/// A fault, and the permitted reactions of the run.
struct Trouble {
  const char* name;
  std::function<void(ChaosRun&, std::mt19937&, Wrong*)> strike;
  /// The launcher itself was killed, or ended at once by a second signal: no sentence is required.
  bool may_be_silent = false;
};

void SignalAll(ChaosRun& run, int signal) {
  run.child().Signal(signal);
  for (const pid_t pid : run.Children()) kill(pid, signal);
}

void KillOne(ChaosRun& run, std::mt19937& random) {
  for (const pid_t pid : run.Children(kPrograms[random() % kPrograms.size()])) kill(pid, SIGKILL);
}

void StopOneForAWhile(ChaosRun& run, std::mt19937& random) {
  const std::vector<pid_t> pids = run.Children(kPrograms[random() % kPrograms.size()]);
  for (const pid_t pid : pids) kill(pid, SIGSTOP);
  std::this_thread::sleep_for(std::chrono::milliseconds(200 + random() % 800));
  for (const pid_t pid : pids) kill(pid, SIGCONT);
}

void StartASecondRun(ChaosRun& run, Wrong* wrong) {
  const fs::path log = run.log().string() + ".second";
  ChildProcess second(test::BinaryFolder() / "plslam", run.Arguments(), log);
  std::optional<ChildExit> end;
  const auto limit = Clock::now() + test::Patience(kEndLimit);
  while (!(end = second.Poll()) && Clock::now() < limit) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  // The first may have ended just before; then the second is a run like any other.
  const bool has_reason = end && (end->code == 0 || ReadText(log).find("plslam: error: ") != std::string::npos);
  Expect(has_reason, "the second run does not end, or without a sentence: " + ReadText(log), wrong);
}

std::vector<Trouble> AllTroubles() {
  return {
      {"SIGINT to plslam", [](ChaosRun& run, std::mt19937&, Wrong*) { run.child().Signal(SIGINT); }},
      {"SIGTERM to plslam", [](ChaosRun& run, std::mt19937&, Wrong*) { run.child().Signal(SIGTERM); }},
      {"SIGHUP to plslam", [](ChaosRun& run, std::mt19937&, Wrong*) { run.child().Signal(SIGHUP); }},
      {"SIGTERM to all", [](ChaosRun& run, std::mt19937&, Wrong*) { SignalAll(run, SIGTERM); }},
      {"SIGINT to all", [](ChaosRun& run, std::mt19937&, Wrong*) { SignalAll(run, SIGINT); }},
      {"one killed", [](ChaosRun& run, std::mt19937& random, Wrong*) { KillOne(run, random); }},
      {"two killed",
       [](ChaosRun& run, std::mt19937& random, Wrong*) {
         KillOne(run, random);
         KillOne(run, random);
       }},
      {"one stopped for a while", [](ChaosRun& run, std::mt19937& random, Wrong*) { StopOneForAWhile(run, random); }},
      {"a second run into the same folder",
       [](ChaosRun& run, std::mt19937&, Wrong* wrong) { StartASecondRun(run, wrong); }},
      {"SIGINT twice",
       [](ChaosRun& run, std::mt19937& random, Wrong*) {
         run.child().Signal(SIGINT);
         std::this_thread::sleep_for(std::chrono::milliseconds(random() % 300));
         run.child().Signal(SIGINT);
       },
       true},
      {"plslam killed", [](ChaosRun& run, std::mt19937&, Wrong*) { run.child().Signal(SIGKILL); }, true},
  };
}

/// Duration in seconds of an undisturbed run, and its results.
struct Reference {
  double wall_s = 0.0;
  std::array<std::string, std::size(kResults)> results;
  std::string map;
  bool has_report = false;  ///< not where this was built without node
};

std::array<std::string, std::size(kResults)> ResultsIn(const fs::path& out) {
  std::array<std::string, std::size(kResults)> results;
  for (size_t i = 0; i < std::size(kResults); ++i) results[i] = ReadText(out / kResults[i]);
  return results;
}

/// Calls `task(0)` to `task(n - 1)`, so many at a time.
void SideBySide(int n, int at_a_time, const std::function<void(int)>& task) {
  std::atomic<int> next = 0;
  std::vector<std::thread> threads;
  for (int i = 0; i < at_a_time; ++i) {
    threads.emplace_back([&] {
      for (int k = next++; k < n; k = next++) task(k);
    });
  }
  for (std::thread& thread : threads) thread.join();
}

/// As slow as it is among others, so that moments of it are moments of those that follow.
Reference PlayUndisturbed(const World& world) {
  std::vector<Reference> references(static_cast<size_t>(world.side_by_side));
  SideBySide(world.side_by_side, world.side_by_side, [&](int i) {
    ChaosRun run(world);
    const auto began = Clock::now();
    run.Start();
    EXPECT_EQ(run.Wait(), 0) << run.Log();
    references[static_cast<size_t>(i)] = {std::chrono::duration<double>(Clock::now() - began).count(),
                                          ResultsIn(run.out()), ReadText(run.map()),
                                          fs::exists(run.out() / "report.html")};
  });
  std::ranges::sort(references, {}, &Reference::wall_s);
  return references[references.size() / 2];
}

/// The results and the map of an earlier run, which this one may only replace by its own.
struct Before {
  std::string summary = R"({"earlier": true, "version": "earlier"})";
  std::string map;
  fs::file_time_type map_time;
};

Before PutEarlierResults(const ChaosRun& run, const std::string& map) {
  fs::create_directories(run.out());
  Before before;
  before.map = map;
  std::ofstream(run.out() / "summary.json") << before.summary;
  std::ofstream(run.out() / "trajectory.tum") << kEarlierPath;
  std::ofstream(run.map(), std::ios::binary) << map;
  before.map_time = fs::last_write_time(run.map());
  return before;
}

void ExpectNothingHalfWritten(const fs::path& folder, Wrong* wrong) {
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    Expect(entry.path().extension() != ".part", entry.path().string() + " is left", wrong);
    const bool result = entry.is_regular_file() && entry.path().extension() != ".log";
    if (result && entry.path().filename().string().front() != '.') {
      Expect(entry.file_size() > 0U, entry.path().string() + " is empty", wrong);
    }
  }
}

void ExpectAllEnded(const ChaosRun& run, Wrong* wrong) {
  const auto limit = Clock::now() + test::Patience(std::chrono::seconds(70));
  while (!run.Children().empty() && Clock::now() < limit) std::this_thread::sleep_for(std::chrono::milliseconds(20));
  Expect(run.Children().empty(), "processes are left", wrong);
}

/// Returns the reason why it is no complete map with keyframes; empty if it is.
std::string LackOfMap(const fs::path& map) {
  try {
    return ReadMapFile(map.string()).map.keyframes().empty() ? "the map has no keyframes" : "";
  } catch (const std::exception& error) {
    return fmt::format("the map is lost: {}", error.what());
  }
}

/// Checks a completed run; in a live one, some frames may have been dropped.
void ExpectRightResult(const ChaosRun& run, const World& world, const nlohmann::json& summary,
                       const Reference& reference, Wrong* wrong) {
  if (world.pace == "lockstep") {
    return Expect(ResultsIn(run.out()) == reference.results, "not the bits of an undisturbed run", wrong);
  }
  for (const std::string& result : ResultsIn(run.out())) Expect(!result.empty(), "a result is missing", wrong);
  const auto all = summary.value("all_frames", 0), frames = summary.value("frames", 0);
  Expect(all == world.frames, fmt::format("{} frames in all", all), wrong);
  // A busy machine drops many, and a restart some.
  Expect(2 * frames >= world.frames, fmt::format("only {} frames were handled", frames), wrong);
  const nlohmann::json ate_m = summary["accuracy"].is_object() ? summary["accuracy"]["ate_m"] : nlohmann::json();
  Expect(ate_m.is_number() && ate_m < 0.05, "an ATE of " + ate_m.dump(), wrong);
}

void ExpectRightEnd(ChaosRun& run, int code, const Trouble& trouble, const Before& before, const World& world,
                    const Reference& reference, Wrong* wrong) {
  ExpectAllEnded(run, wrong);
  const bool same_map = ReadText(run.map()) == before.map;
  if (!same_map) Expect(LackOfMap(run.map()).empty(), LackOfMap(run.map()), wrong);
  if (trouble.may_be_silent && code >= 128) return;
  ExpectNothingHalfWritten(run.out(), wrong);
  const std::string summary_text = ReadText(run.out() / "summary.json");
  // A signal before the program has begun ends it like any program, without any change of files.
  if (code >= 128) {
    return Expect(run.Log().empty() && summary_text == before.summary && same_map,
                  "ended by a signal after it had begun", wrong);
  }
  const nlohmann::json summary = nlohmann::json::parse(summary_text, nullptr, false);
  if (summary.is_discarded()) return Expect(false, "no whole summary.json", wrong);
  if (code != 0) {
    return Expect(run.Log().find("plslam: error: ") != std::string::npos, "no sentence", wrong);
  }
  if (summary.contains("earlier")) return Expect(false, "exit code 0, and the results are of the run before", wrong);
  Expect(fs::last_write_time(run.map()) != before.map_time, "exit code 0 without the map that was asked for", wrong);
  Expect(ReadText(run.out() / "trajectory.tum") != kEarlierPath, "exit code 0 without a path", wrong);
  Expect(fs::exists(run.out() / "report.html") == reference.has_report, "exit code 0 without the report", wrong);
  const bool completed = summary["completed"] == true;
  if (completed) ExpectRightResult(run, world, summary, reference, wrong);
  Expect(completed || summary["reason"] == "interrupted", "not completed: " + summary["reason"].dump(), wrong);
}

/// Returns the sentence with which a run ended; empty if there is none.
std::string ErrorIn(const std::string& log) {
  const size_t at = log.rfind("plslam: error: ");
  return at == std::string::npos ? "" : log.substr(at, log.find('\n', at) - at);
}

/// Plays one run with one fault; returns the violated promises and describes the fault in `description`.
Wrong PlayWithTrouble(const World& world, const Reference& reference, int seed, int event, std::string* description) {
  const std::vector<Trouble> troubles = AllTroubles();
  std::seed_seq seeds{seed, event};
  std::mt19937 random(seeds);
  const Trouble& trouble = troubles[static_cast<size_t>(event) % troubles.size()];
  const double at_s = std::uniform_real_distribution<double>(0.0, 1.05 * reference.wall_s)(random);
  Wrong wrong;
  ChaosRun run(world);
  const Before before = PutEarlierResults(run, reference.map);
  run.Start();
  // Only the moment is random here; the test does not wait for an event.
  std::this_thread::sleep_for(std::chrono::duration<double>(at_s));
  trouble.strike(run, random, &wrong);
  const std::optional<int> code = run.Wait();
  Expect(code.has_value(), "does not end", &wrong);
  if (code) ExpectRightEnd(run, *code, trouble, before, world, reference, &wrong);
  *description = fmt::format("{:3} {:36} after {:6.3f} s: exit code {} {}", event, trouble.name, at_s,
                             code.value_or(-1), ErrorIn(run.Log()));
  if (!wrong.empty()) *description += fmt::format(": {}\n{}", fmt::join(wrong, "; "), run.Log());
  return wrong;
}

/// All events are played, also after one that failed.
void PlayAll(const World& world, int events) {
  const int seed = FromEnvironment("PLSLAM_CHAOS_SEED", 1);
  const int only = FromEnvironment("PLSLAM_CHAOS_ONLY", -1);
  events = FromEnvironment("PLSLAM_CHAOS_EVENTS", events);
  const Reference reference = PlayUndisturbed(world);
  ASSERT_FALSE(testing::Test::HasFailure());
  std::cout << fmt::format("undisturbed {:.3f} s, seed {}\n", reference.wall_s, seed);
  std::mutex mutex;
  int failed = 0;
  SideBySide(events, world.side_by_side, [&](int event) {
    if (only >= 0 && event != only) return;
    std::string description;
    const Wrong wrong = PlayWithTrouble(world, reference, seed, event, &description);
    const std::scoped_lock lock(mutex);
    failed += wrong.empty() ? 0 : 1;
    std::cout << description << std::endl;
  });
  EXPECT_EQ(failed, 0) << "of " << events << " went wrong; they stand above";
}

TEST(Chaos, RandomFaultsInLockstep) { PlayAll(LockstepWorld(), test::LongTests() ? 200 : 11); }

TEST(Chaos, RandomFaultsInALiveMinute) {
  PLSLAM_REQUIRE_LONG_TESTS();
  PlayAll(MinuteWorld(), 200);
}

// The disk under the outputs, the map and the logs gets full at a random moment.
TEST(Chaos, DiskFullAtRandomMoments) {
  std::mt19937 random(static_cast<unsigned>(FromEnvironment("PLSLAM_CHAOS_SEED", 1)));
  const int events = FromEnvironment("PLSLAM_CHAOS_EVENTS", test::LongTests() ? 50 : 2);
  const World world = LockstepWorld();
  const Reference reference = PlayUndisturbed(world);
  for (int i = 0; i < events; ++i) {
    const double at_s = std::uniform_real_distribution<double>(0.0, reference.wall_s)(random);
    SCOPED_TRACE(fmt::format("event {}: full after {:.3f} of {:.3f} s", i, at_s, reference.wall_s));
    const ChaosRun run(world);
    const fs::path disk = run.out().parent_path() / "disk", found = run.out().parent_path() / "found";
    const std::optional<int> code = test::OnASmallDisk(
        disk, 20'000,
        fmt::format(
            "(sleep {0:.3f}; dd if=/dev/zero of='{1}/full' bs=4k 2>/dev/null) & {2} run '{3}' --out '{1}/out' "
            "--save-map '{1}/room.plmap'; code=\\$?; wait; rm -f '{1}/full'; cp -r '{1}' '{4}'; exit \\$code",
            at_s, disk.string(), (test::BinaryFolder() / "plslam").string(), world.dataset, found.string()));
    if (!code) GTEST_SKIP() << "no file system of its own may be mounted here";
    const std::string log = ReadText(disk.string() + ".sh.log");
    Wrong wrong;
    // On a disk that was full before, the folder cannot be made.
    if (*code == 0 || fs::exists(found / "out")) ExpectNothingHalfWritten(found / "out", &wrong);
    EXPECT_THAT(wrong, testing::IsEmpty());
    if (*code == 0) {
      EXPECT_TRUE(ResultsIn(found / "out") == reference.results) << log;
    } else {
      EXPECT_THAT(log, testing::HasSubstr("plslam: error: "));
    }
    if (*code == 0 || fs::exists(found / "room.plmap")) {
      EXPECT_EQ(LackOfMap(found / "room.plmap"), "");
    }
    std::cout << fmt::format("{:3} full after {:6.3f} s: exit code {}\n", i, at_s, *code);
    if (testing::Test::HasFailure()) {
      std::cout << log << '\n';
      break;
    }
  }
}

}  // namespace
}  // namespace plslam::launcher
