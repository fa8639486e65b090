// SPDX-License-Identifier: BSD-3-Clause
#include "core/process/process.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <thread>

#include "core/process/process_signals.h"
#include "core/process/process_status.h"
#include "plslam/status_t.hpp"
#include "plslam_version.h"
#include "tests/support/text_file.h"
#include "tools/launch/child_process.h"
#include "tools/launch/run_bus.h"

namespace plslam::launcher {
namespace {

using testing::HasSubstr;
using Clock = std::chrono::steady_clock;

/// Starts process_test_program on a separate bus and listens to its status.
class ProcessTest : public testing::Test {
 protected:
  ProcessTest() : bus_(OptionsWith(port_.Url()), "test") {
    std::string pattern = testing::TempDir() + "process_XXXXXX";
    folder_ = mkdtemp(pattern.data());
    bus_.Subscribe<status_t>(bus::kStatus, [this](const status_t& status) {
      if (status.process != "player") return;
      statuses_.push_back(status);
      if (wanted_ && wanted_(status)) bus_.Stop();
    });
  }
  ~ProcessTest() override { std::filesystem::remove_all(folder_); }

  static bus::BusOptions OptionsWith(const std::string& url) {
    bus::BusOptions options;
    options.url = url;
    return options;
  }

  void Start(std::vector<std::string> arguments) {
    arguments.insert(arguments.end(), {"--url", port_.Url()});
    child_ = std::make_unique<ChildProcess>(PLSLAM_TEST_PROGRAM, arguments, folder_ / "log");
  }

  /// Returns its exit code; -1 if it still runs after ten seconds.
  int Wait() const {
    const auto limit = Clock::now() + std::chrono::seconds(10);
    while (Clock::now() < limit) {
      if (const auto end = child_->Poll()) return end->code;
      std::this_thread::yield();
    }
    return -1;
  }

  /// Exit code; signals of one moment count as one, so it is sent until it is another moment.
  int SignalUntilItEnds(int signal) const {
    for (int i = 0; i < 100 && !child_->Poll(); ++i) {
      child_->Signal(signal);
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
    }
    return child_->Poll() ? child_->Poll()->code : -1;
  }

  bool WaitForLine(const std::string& text) const {
    const auto limit = Clock::now() + std::chrono::seconds(10);
    while (Log().find(text) == std::string::npos && Clock::now() < limit) std::this_thread::yield();
    return Log().find(text) != std::string::npos;
  }

  /// Listens until a status fits; once in a test.
  void ListenUntil(std::function<bool(const status_t&)> fits) {
    wanted_ = std::move(fits);
    bus_.Run();
  }
  void ListenFor(const std::string& state) {
    ListenUntil([state](const status_t& status) { return status.state == state; });
  }

  std::string Log() const { return ReadText(folder_ / "log"); }

  PrivatePort port_;
  bus::Bus bus_;
  std::filesystem::path folder_;
  std::unique_ptr<ChildProcess> child_;
  std::function<bool(const status_t&)> wanted_;
  std::vector<status_t> statuses_;
};

TEST_F(ProcessTest, SignalsEndItCleanly) {
  for (const int signal : {SIGINT, SIGTERM}) {
    std::filesystem::remove(folder_ / "log");
    Start({});
    ASSERT_TRUE(WaitForLine("runs")) << Log();
    child_->Signal(signal);
    EXPECT_EQ(Wait(), 0) << Log();
    EXPECT_THAT(Log(), HasSubstr("node is gone"));
    EXPECT_THAT(Log(), HasSubstr(signal == SIGINT ? "SIGINT: stopping" : "SIGTERM: stopping"));
  }
}

TEST_F(ProcessTest, SecondSignalEndsAHangingProcess) {
  Start({"hang"});
  // "ready" is published before; a signal in between would still end it cleanly.
  ASSERT_TRUE(WaitForLine("hangs")) << Log();
  child_->Signal(SIGINT);
  ASSERT_TRUE(WaitForLine("SIGINT: stopping")) << Log();
  EXPECT_EQ(SignalUntilItEnds(SIGTERM), 128 + SIGTERM) << Log();
}

TEST_F(ProcessTest, ClosedTerminalIsNoSecondSignal) {
  Start({"hang"});
  ASSERT_TRUE(WaitForLine("hangs")) << Log();
  child_->Signal(SIGTERM);
  ASSERT_TRUE(WaitForLine("SIGTERM: stopping")) << Log();
  for (int i = 0; i < 3; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    child_->Signal(SIGHUP);
  }
  EXPECT_EQ(SignalUntilItEnds(SIGTERM), 128 + SIGTERM) << Log();
  Start({});
  ASSERT_TRUE(WaitForLine("runs")) << Log();
  child_->Signal(SIGHUP);
  EXPECT_EQ(Wait(), 0) << Log();
  EXPECT_THAT(Log(), HasSubstr("SIGHUP: stopping"));
}

TEST_F(ProcessTest, NohupIsRespected) {
  child_ = std::make_unique<ChildProcess>(
      "/usr/bin/nohup", std::vector<std::string>{PLSLAM_TEST_PROGRAM, "--url", port_.Url()}, folder_ / "log");
  ASSERT_TRUE(WaitForLine("runs")) << Log();
  child_->Signal(SIGHUP);
  child_->Signal(SIGINT);
  EXPECT_EQ(Wait(), 0) << Log();
  EXPECT_THAT(Log(), HasSubstr("SIGINT: stopping"));
  EXPECT_THAT(Log(), testing::Not(HasSubstr("SIGHUP")));
}

TEST_F(ProcessTest, SignalsOfOneMomentAreOneOrder) {
  Start({"slow-end"});
  ASSERT_TRUE(WaitForLine("runs")) << Log();
  for (int i = 0; i < 20; ++i) child_->Signal(i % 2 == 0 ? SIGINT : SIGTERM);
  EXPECT_EQ(Wait(), 0) << Log();
}

TEST_F(ProcessTest, EndsOnlyByTheOrderOfItsLauncher) {
  Start({"--parent", std::to_string(getpid())});
  ASSERT_TRUE(WaitForLine("runs")) << Log();
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    child_->Signal(signal);
    ASSERT_TRUE(WaitForLine(bus::SignalName(signal) + ": ignored")) << Log();
  }
  EXPECT_FALSE(child_->Poll());
  child_->Signal(bus::kStopOrder);
  EXPECT_EQ(Wait(), 0) << Log();
  EXPECT_THAT(Log(), HasSubstr("SIGUSR1: stopping"));
}

TEST_F(ProcessTest, SignalsOfTheSameMomentDoNotSpoilTheOrder) {
  Start({"slow-end", "--parent", std::to_string(getpid())});
  ASSERT_TRUE(WaitForLine("runs")) << Log();
  for (const int signal : {SIGTERM, SIGINT, bus::kStopOrder, SIGINT, SIGTERM, SIGHUP}) child_->Signal(signal);
  EXPECT_EQ(Wait(), 0) << Log();
}

TEST_F(ProcessTest, EndsWhenItsLauncherIsKilled) {
  const std::string line = std::string(PLSLAM_TEST_PROGRAM) + " --url " + port_.Url() + " --parent $$ & wait";
  child_ = std::make_unique<ChildProcess>("/bin/sh", std::vector<std::string>{"-c", line}, folder_ / "log");
  ASSERT_TRUE(WaitForLine("runs")) << Log();
  child_->Signal(SIGKILL);
  EXPECT_TRUE(WaitForLine("SIGTERM: stopping")) << Log();
  EXPECT_TRUE(WaitForLine("node is gone")) << Log();
}

TEST_F(ProcessTest, StandaloneProcessLogsItsProgress) {
  Start({"own-state", "--prefix", "ann/"});
  ASSERT_TRUE(WaitForLine("runs")) << Log();
  child_->Signal(SIGINT);
  EXPECT_EQ(Wait(), 0) << Log();
  EXPECT_THAT(Log(), HasSubstr("process_test_program: running, because\n"));
  EXPECT_THAT(Log(), HasSubstr("process_test_program: ready on " + port_.Url() +
                               " with the prefix ann/, waiting for an order\n"));
  EXPECT_THAT(Log(), HasSubstr("process_test_program: ended: 42 answers\n"));
}

TEST_F(ProcessTest, FinishGivesTheExitCode) {
  Start({"finish"});
  EXPECT_EQ(Wait(), 0) << Log();
  EXPECT_THAT(Log(), HasSubstr("node is gone"));
  Start({"finish-7"});
  EXPECT_EQ(Wait(), 7) << Log();
}

TEST_F(ProcessTest, ExceptionAtStartIsOneLineAndExitCodeOne) {
  Start({"throw-at-start"});
  EXPECT_EQ(Wait(), 1);
  EXPECT_EQ(Log(), "player: error: cannot start at all\n");
}

TEST_F(ProcessTest, ExceptionInAHandlerIsReported) {
  Start({"throw-in-handler"});
  ListenFor("failed");
  EXPECT_EQ(Wait(), 1);
  EXPECT_EQ(statuses_.back().reason, "a handler failed");
  EXPECT_THAT(Log(), HasSubstr("player: error: a handler failed\n"));
}

TEST_F(ProcessTest, ExceptionOfAnyTypeIsCaught) {
  Start({"throw-a-number"});
  EXPECT_EQ(Wait(), 1);
  EXPECT_THAT(Log(), HasSubstr("player: error: an exception of unknown type\n"));
}

TEST_F(ProcessTest, StatusHasVersionUsageAndConfiguration) {
  Start({"--set", "player.answer=7"});
  ListenFor("ready");
  const status_t status = statuses_.back();
  EXPECT_EQ(status.pid, child_->pid());
  EXPECT_EQ(status.version, PLSLAM_VERSION);
  EXPECT_FALSE(status.host.empty());
  EXPECT_GT(status.memory_mb, 1.0);
  EXPECT_LT(status.memory_mb, 1000.0);
  EXPECT_GT(status.cpu_s, 0.0);
  EXPECT_THAT(status.configuration, HasSubstr("bus:\n  url: \"" + port_.Url()));
  EXPECT_THAT(status.configuration, HasSubstr("player:\n  answer: 7\n"));
  std::map<std::string, double> counters;
  for (const auto& counter : status.counters) counters[counter.name] = counter.value;
  EXPECT_EQ(counters["answer"], 7.0);
  EXPECT_EQ(counters.count("bus.rejected"), 1U);
}

TEST_F(ProcessTest, StoppingIsPublished) {
  Start({});
  ListenUntil([this](const status_t& status) {
    if (status.state == "ready") child_->Signal(SIGINT);
    return status.state == "stopping";
  });
  EXPECT_EQ(Wait(), 0);
}

TEST_F(ProcessTest, StatusIsPublishedPeriodically) {
  Start({});
  ListenUntil([this](const status_t&) { return statuses_.size() >= 6; });
  EXPECT_GT(statuses_[5].uptime_s, statuses_[0].uptime_s + 0.5)
      << "the first ones are for processes of the same name";
  EXPECT_GT(statuses_[5].header.seq, statuses_[0].header.seq);
}

TEST_F(ProcessTest, StateOfTheNodeIsKept) {
  Start({"own-state"});
  ListenFor("running");
  EXPECT_EQ(statuses_.back().reason, "because");
  for (const status_t& status : statuses_) EXPECT_NE(status.state, "ready");
}

TEST_F(ProcessTest, LongConfigurationIsCutToTheMessageSize) {
  Start({"--set", "bus.max_message_bytes=1000"});
  ListenFor("ready");
  EXPECT_LT(statuses_.back().getEncodedSize(), 1000);
}

TEST_F(ProcessTest, BadConfigurationStopsBeforeTheStart) {
  std::ofstream(folder_ / "rig.yaml") << "player:\n  answr: 7\n";
  Start({"--config", (folder_ / "rig.yaml").string()});
  EXPECT_EQ(Wait(), 1);
  EXPECT_EQ(Log(), "player: error: " + (folder_ / "rig.yaml").string() +
                       ":2: unknown key 'player.answr'; the nearest known one is 'player.answer'\n");
}

TEST_F(ProcessTest, UnknownSectionStopsBeforeTheStart) {
  Start({"--set", "plyer.answer=7"});
  EXPECT_EQ(Wait(), 1);
  EXPECT_EQ(Log(),
            "player: error: override 'plyer.answer=7': unknown section 'plyer'; the nearest known one is "
            "'player'\n");
}

TEST_F(ProcessTest, BadCommandLineIsOneLine) {
  Start({"--nonsense"});
  EXPECT_EQ(Wait(), 1);
  EXPECT_THAT(Log(), testing::StartsWith("player: error: "));
  EXPECT_THAT(Log(), HasSubstr("--nonsense"));
  EXPECT_EQ(Log().find('\n'), Log().size() - 1) << Log();
}

TEST_F(ProcessTest, BadUrlIsOneLine) {
  child_ = std::make_unique<ChildProcess>(PLSLAM_TEST_PROGRAM, std::vector<std::string>{"--url", "nonsense://x"},
                                          folder_ / "log");
  EXPECT_EQ(Wait(), 1);
  EXPECT_THAT(Log(), HasSubstr("player: error: "));
  EXPECT_THAT(Log(), HasSubstr("nonsense://x"));
}

TEST(StatusPublisher, WarningsOfOneCodeHideNoOthers) {
  bus::BusOptions options;
  options.url = "memq://";
  bus::Bus bus(options, "ros2");
  bus::StatusPublisher status("ros2", options, bus);
  int n_reported = 0;
  for (int i = 0; i < 100; ++i) n_reported += status.Warn("no_frames", fmt::format("since {} s", i)) ? 1 : 0;
  EXPECT_EQ(n_reported, 10);
  EXPECT_TRUE(status.Warn("imu_missing", "no samples"));
  EXPECT_FALSE(status.Warn("imu_missing", "no samples"));
  EXPECT_TRUE(status.Warn("imu_missing", "older samples"));
}

TEST(CountOf, InvalidNumbersCountAsZero) {
  status_t status;
  for (const double value : {7.9, -3.0, 1e300, std::nan(""), std::numeric_limits<double>::infinity()}) {
    status.counters.push_back({fmt::format("{}", value), value});
  }
  const std::vector<std::string> names{"7.9", "-3", "1e+300", "nan", "inf", "none"};
  std::vector<int64_t> counts;
  for (const std::string& name : names) counts.push_back(bus::CountOf(status, name));
  constexpr int64_t kMost = int64_t{1} << 53;
  EXPECT_THAT(counts, testing::ElementsAre(7, 0, kMost, 0, kMost, 0));
}

TEST_F(ProcessTest, HelpAndVersion) {
  Start({"--help"});
  EXPECT_EQ(Wait(), 0);
  EXPECT_THAT(Log(), testing::AllOf(HasSubstr("A process for tests."), HasSubstr("--config"), HasSubstr("--set"),
                                    HasSubstr("--url"), HasSubstr("--prefix"), HasSubstr("mode")));
  Start({"--version"});
  EXPECT_EQ(Wait(), 0);
  EXPECT_THAT(Log(), testing::EndsWith(PLSLAM_VERSION "\n"));
}

TEST_F(ProcessTest, EndsWithTheProcessThatStartedIt) {
  Start({"--parent", std::to_string(getpid())});
  ASSERT_TRUE(WaitForLine("runs")) << Log();
  EXPECT_THAT(Log(), testing::Not(HasSubstr("process_test_program"))) << "its launcher speaks for it";
  child_->Signal(bus::kStopOrder);
  EXPECT_EQ(Wait(), 0);
  Start({"--parent", "1"});  // is not ours
  EXPECT_EQ(Wait(), 1);
  EXPECT_THAT(Log(), HasSubstr("the process that started this one has exited"));
}

}  // namespace
}  // namespace plslam::launcher
