#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>

#include <array>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <iostream>
#include <memory>
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
#include "tools/plslam/child_process.h"

// Trouble at random moments of a run over the results of an earlier one. Whatever happens, the run ends with the complete and
// right result, or with a non-zero exit code and a sentence, and the map that was there before is not lost.
//
// PLSLAM_CHAOS_SEED and PLSLAM_CHAOS_EVENTS choose others than the default.

namespace plslam {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

constexpr std::array<const char*, 5> kPrograms{"player", "vo_process", "mapping_process", "loop_process",
                                               "viewer_headless"};
constexpr const char* kResults[] = {"trajectory.tum", "keyframes.tum", "map.ply", "covariance.txt"};
/// After which a run must have ended, whatever happened to it.
constexpr std::chrono::seconds kEndLimit{180};

int FromEnvironment(const char* name, int otherwise) {
  const char* const text = std::getenv(name);
  return text != nullptr ? std::atoi(text) : otherwise;
}

/// Everything that belongs to one world of trouble: the folder of the run, the map it saves, and its log.
class ChaosRun {
 public:
  ChaosRun() {
    std::string pattern = testing::TempDir() + "chaos XXXXXX";
    folder_ = mkdtemp(pattern.data());
  }
  ~ChaosRun() {
    child_.reset();
    if (std::getenv("PLSLAM_KEEP_RUNS") == nullptr) fs::remove_all(folder_);
  }
  ChaosRun(const ChaosRun&) = delete;
  ChaosRun& operator=(const ChaosRun&) = delete;

  static std::string World() {
    return fmt::format("synthetic:room?size=160x120&frames={}", test::LongTests() ? 1500 : 120);
  }

  fs::path out() const { return folder_ / "out"; }
  fs::path map() const { return folder_ / "room.plmap"; }
  fs::path log() const { return folder_ / "plslam.log"; }

  std::vector<std::string> Arguments() const {
    return {"run", World(), "--out", out().string(), "--save-map", map().string(), "--max-restarts", "3"};
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

  /// Processes of this run, the launcher left out: by what stands in their command line.
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
  fs::path folder_;
  std::unique_ptr<ChildProcess> child_;
};

/// What happens, and what the run may answer.
struct Trouble {
  const char* name;
  std::function<void(ChaosRun&, std::mt19937&)> strike;
  /// The launcher itself was killed, or ended at once by a second signal: no sentence is owed.
  bool may_be_silent = false;
};

void SignalAll(ChaosRun& run, int signal) {
  run.child().Signal(signal);
  for (const pid_t pid : run.Children()) kill(pid, signal);
}

void KillOne(ChaosRun& run, std::mt19937& random) {
  for (const pid_t pid : run.Children(kPrograms[random() % kPrograms.size()])) kill(pid, SIGKILL);
}

std::vector<Trouble> AllTroubles() {
  return {
      {"SIGINT to plslam", [](ChaosRun& run, std::mt19937&) { run.child().Signal(SIGINT); }},
      {"SIGTERM to plslam", [](ChaosRun& run, std::mt19937&) { run.child().Signal(SIGTERM); }},
      {"SIGHUP to plslam", [](ChaosRun& run, std::mt19937&) { run.child().Signal(SIGHUP); }},
      {"SIGTERM to all", [](ChaosRun& run, std::mt19937&) { SignalAll(run, SIGTERM); }},
      {"SIGINT to all", [](ChaosRun& run, std::mt19937&) { SignalAll(run, SIGINT); }},
      {"one killed", KillOne},
      {"two killed",
       [](ChaosRun& run, std::mt19937& random) {
         KillOne(run, random);
         KillOne(run, random);
       }},
      {"one stopped for a while",
       [](ChaosRun& run, std::mt19937& random) {
         const std::vector<pid_t> pids = run.Children(kPrograms[random() % kPrograms.size()]);
         for (const pid_t pid : pids) kill(pid, SIGSTOP);
         std::this_thread::sleep_for(std::chrono::milliseconds(200 + random() % 800));
         for (const pid_t pid : pids) kill(pid, SIGCONT);
       }},
      {"a second run into the same folder",
       [](ChaosRun& run, std::mt19937&) {
         const fs::path log = run.log().string() + ".second";
         ChildProcess second(test::BinaryFolder() / "plslam", run.Arguments(), log);
         std::optional<ChildExit> end;
         const auto limit = Clock::now() + test::Patience(kEndLimit);
         while (!(end = second.Poll()) && Clock::now() < limit) {
           std::this_thread::sleep_for(std::chrono::milliseconds(5));
         }
         ASSERT_TRUE(end);
         // The first may have ended just before; then the second is a run like any other.
         if (end->code != 0) {
           EXPECT_THAT(ReadText(log), testing::HasSubstr("plslam: error: "));
         }
       }},
      {"SIGINT twice",
       [](ChaosRun& run, std::mt19937& random) {
         run.child().Signal(SIGINT);
         std::this_thread::sleep_for(std::chrono::milliseconds(random() % 300));
         run.child().Signal(SIGINT);
       },
       true},
      {"plslam killed", [](ChaosRun& run, std::mt19937&) { run.child().Signal(SIGKILL); }, true},
  };
}

/// Seconds that an undisturbed run takes, and what it leaves behind.
struct Reference {
  double wall_s = 0.0;
  std::array<std::string, std::size(kResults)> results;
};

std::array<std::string, std::size(kResults)> ResultsIn(const fs::path& out) {
  std::array<std::string, std::size(kResults)> results;
  for (size_t i = 0; i < std::size(kResults); ++i) results[i] = ReadText(out / kResults[i]);
  return results;
}

Reference PlayUndisturbed() {
  ChaosRun run;
  const auto began = Clock::now();
  run.Start();
  EXPECT_EQ(run.Wait(), 0) << run.Log();
  return {std::chrono::duration<double>(Clock::now() - began).count(), ResultsIn(run.out())};
}

/// The results and the map of an earlier run, which this one may only replace by its own.
struct Before {
  std::string summary = R"({"earlier": true, "version": "earlier"})";
  std::string map;
};

Before PutEarlierResults(const ChaosRun& run, const std::string& map) {
  fs::create_directories(run.out());
  Before before;
  before.map = map;
  std::ofstream(run.out() / "summary.json") << before.summary;
  std::ofstream(run.out() / "trajectory.tum") << "0 0 0 0 0 0 0 1\n";
  std::ofstream(run.map(), std::ios::binary) << map;
  return before;
}

void ExpectNothingHalfWritten(const fs::path& folder) {
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    EXPECT_NE(entry.path().extension(), ".part") << entry.path();
    const bool result = entry.is_regular_file() && entry.path().extension() != ".log";
    if (result && entry.path().filename().string().front() != '.') {
      EXPECT_GT(entry.file_size(), 0U) << entry.path();
    }
  }
}

void ExpectNobodyLeft(const ChaosRun& run) {
  const auto limit = Clock::now() + test::Patience(std::chrono::seconds(20));
  while (!run.Children().empty() && Clock::now() < limit) std::this_thread::sleep_for(std::chrono::milliseconds(20));
  EXPECT_TRUE(run.Children().empty());
}

/// The map of before, to the last bit, or a whole one with keyframes.
void ExpectGoodMap(const ChaosRun& run, const Before& before) {
  if (ReadText(run.map()) == before.map) return;
  try {
    EXPECT_FALSE(ReadMapFile(run.map().string()).map.keyframes().empty());
  } catch (const std::exception& error) {
    ADD_FAILURE() << "the map is lost: " << error.what();
  }
}

void ExpectRightEnd(ChaosRun& run, const Trouble& trouble, const Before& before, const Reference& reference) {
  const std::optional<int> code = run.Wait();
  ASSERT_TRUE(code) << "does not end";
  ExpectNobodyLeft(run);
  ExpectGoodMap(run, before);
  if (trouble.may_be_silent && *code >= 128) return;
  ExpectNothingHalfWritten(run.out());
  // A signal that comes before the program has begun ends it as it ends any program; nothing has been touched then.
  if (*code >= 128) {
    EXPECT_EQ(run.Log(), "");
    EXPECT_EQ(ReadText(run.out() / "summary.json"), before.summary);
    EXPECT_TRUE(ReadText(run.map()) == before.map);
    return;
  }
  const nlohmann::json summary = nlohmann::json::parse(ReadText(run.out() / "summary.json"), nullptr, false);
  ASSERT_FALSE(summary.is_discarded());
  if (*code != 0) {
    EXPECT_THAT(run.Log(), testing::HasSubstr("plslam: error: "));
    return;
  }
  ASSERT_FALSE(summary.contains("earlier")) << "exit code 0, and the results are of the run before";
  EXPECT_NE(ReadText(run.map()), before.map) << "exit code 0 without the map that was asked for";
  if (summary["completed"] == true) {
    EXPECT_TRUE(ResultsIn(run.out()) == reference.results) << "not the bits of an undisturbed run";
  }
  EXPECT_TRUE(summary["completed"] == true || summary["reason"] == "interrupted") << summary["reason"];
}

TEST(Chaos, AtAnyMomentTheResultIsCompleteOrItsLackIsTold) {
  const int seed = FromEnvironment("PLSLAM_CHAOS_SEED", 1);
  const int events = FromEnvironment("PLSLAM_CHAOS_EVENTS", test::LongTests() ? 200 : 11);
  std::mt19937 random(static_cast<unsigned>(seed));
  const Reference reference = PlayUndisturbed();
  std::string earlier_map;
  {
    ChaosRun run;
    run.Start();
    ASSERT_EQ(run.Wait(), 0) << run.Log();
    earlier_map = ReadText(run.map());
  }
  const std::vector<Trouble> troubles = AllTroubles();
  for (int i = 0; i < events; ++i) {
    const Trouble& trouble = troubles[static_cast<size_t>(i) % troubles.size()];
    const double at_s = std::uniform_real_distribution<double>(0.0, 1.05 * reference.wall_s)(random);
    SCOPED_TRACE(fmt::format("event {}: {} after {:.3f} of {:.3f} s", i, trouble.name, at_s, reference.wall_s));
    ChaosRun run;
    const Before before = PutEarlierResults(run, earlier_map);
    run.Start();
    // The moment is what is random here; nothing is waited for.
    std::this_thread::sleep_for(std::chrono::duration<double>(at_s));
    trouble.strike(run, random);
    ExpectRightEnd(run, trouble, before, reference);
    std::cout << fmt::format("{:3} {:36} after {:6.3f} s\n", i, trouble.name, at_s);
    if (testing::Test::HasFailure()) {
      std::cout << run.Log() << '\n';
      break;
    }
  }
}

// The disk under the outputs, the map and the logs gets full at a random moment.
TEST(Chaos, WhenTheDiskGetsFullTheResultIsCompleteOrItsLackIsTold) {
  std::mt19937 random(static_cast<unsigned>(FromEnvironment("PLSLAM_CHAOS_SEED", 1)));
  const int events = FromEnvironment("PLSLAM_CHAOS_EVENTS", test::LongTests() ? 50 : 2);
  const Reference reference = PlayUndisturbed();
  for (int i = 0; i < events; ++i) {
    const double at_s = std::uniform_real_distribution<double>(0.0, reference.wall_s)(random);
    SCOPED_TRACE(fmt::format("event {}: full after {:.3f} of {:.3f} s", i, at_s, reference.wall_s));
    const ChaosRun run;
    const fs::path disk = run.out().parent_path() / "disk", found = run.out().parent_path() / "found";
    const std::optional<int> code = test::OnASmallDisk(
        disk, 20'000,
        fmt::format(
            "(sleep {0:.3f}; dd if=/dev/zero of='{1}/full' bs=4k 2>/dev/null) & {2} run '{3}' --out '{1}/out' "
            "--save-map '{1}/room.plmap'; code=\\$?; wait; rm -f '{1}/full'; cp -r '{1}' '{4}'; exit \\$code",
            at_s, disk.string(), (test::BinaryFolder() / "plslam").string(), ChaosRun::World(), found.string()));
    if (!code) GTEST_SKIP() << "no file system of its own may be mounted here";
    const std::string log = ReadText(disk.string() + ".sh.log");
    ExpectNothingHalfWritten(found / "out");
    if (*code == 0) {
      EXPECT_TRUE(ResultsIn(found / "out") == reference.results) << log;
      EXPECT_FALSE(ReadMapFile((found / "room.plmap").string()).map.keyframes().empty());
    } else {
      EXPECT_THAT(log, testing::HasSubstr("plslam: error: "));
      if (fs::exists(found / "room.plmap")) {
        EXPECT_FALSE(ReadMapFile((found / "room.plmap").string()).map.keyframes().empty());
      }
    }
    std::cout << fmt::format("{:3} full after {:6.3f} s: exit code {}\n", i, at_s, *code);
    if (testing::Test::HasFailure()) {
      std::cout << log << '\n';
      break;
    }
  }
}

}  // namespace
}  // namespace plslam
