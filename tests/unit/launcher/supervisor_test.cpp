// SPDX-License-Identifier: BSD-3-Clause
#include "tools/launch/supervisor.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <stdlib.h>
#include <sys/resource.h>
#include <unistd.h>

#include <fstream>
#include <functional>
#include <thread>
#include <vector>

#include "core/process/process_signals.h"
#include "tests/support/text_file.h"
#include "tools/launch/child_process.h"

namespace plslam::launcher {
namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;
using Ending = Supervisor::Ending;

/// A folder of shell scripts that play the processes.
class SupervisorTest : public testing::Test {
 protected:
  SupervisorTest() {
    std::string pattern = testing::TempDir() + "supervisor XXXXXX";
    folder_ = mkdtemp(pattern.data());
  }
  ~SupervisorTest() override { std::filesystem::remove_all(folder_); }

  Supervisor Make(int max_restarts = 3, milliseconds patience = milliseconds(5000)) const {
    return Supervisor({folder_, folder_, max_restarts, milliseconds(1), patience, nullptr, nullptr});
  }

  /// Waits an hour before it starts something again.
  Supervisor MakePatient(int max_restarts = 3) const {
    return Supervisor({folder_, folder_, max_restarts, std::chrono::hours(1), milliseconds(5000), nullptr, nullptr});
  }

  void Script(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name) << "#!/bin/sh\n" << text << "\n";
    std::filesystem::permissions(folder_ / name, std::filesystem::perms::owner_all);
  }

  std::string Read(const std::string& name) const { return ReadText(folder_ / name); }

  /// Ticks until `done`; false after ten seconds.
  static bool TickUntil(Supervisor& supervisor, const std::function<bool()>& done) {
    const auto limit = Clock::now() + std::chrono::seconds(10);
    while (!done() && Clock::now() < limit) {
      supervisor.Tick(Clock::now());
      std::this_thread::yield();
    }
    return done();
  }

  static bool Stopped(Supervisor& supervisor) {
    supervisor.Stop(Clock::now());
    return TickUntil(supervisor, [&] { return supervisor.stopped(); });
  }

  std::filesystem::path folder_;
};

TEST_F(SupervisorTest, OutputIsLoggedAndArgumentsAreUnchanged) {
  Script("echo", "echo \"$1|$2\"; echo problem >&2");
  Supervisor supervisor = Make();
  supervisor.Start("a", "echo", {"with space", "--x='1'"}, Ending::kMayEnd);
  ASSERT_TRUE(TickUntil(supervisor, [&] { return supervisor.stopped(); }));
  EXPECT_EQ(Read("a.log"), "with space|--x='1'\nproblem\n");
  EXPECT_EQ(supervisor.failure(), "");
  EXPECT_EQ(supervisor.reports()[0].exit_code, 0);
}

TEST_F(SupervisorTest, ChildInheritsNoFilesAndBlocksSignals) {
  Script("files", "[ -e /proc/$$/fd/37 ] && echo inherited; exec grep SigBlk /proc/self/status");
  sigset_t blocked, before;
  sigemptyset(&blocked);
  sigaddset(&blocked, SIGUSR2);
  pthread_sigmask(SIG_BLOCK, &blocked, &before);
  ASSERT_EQ(dup2(0, 37), 37);
  Supervisor supervisor = Make();
  supervisor.Start("a", "files", {}, Ending::kMayEnd);
  ASSERT_TRUE(TickUntil(supervisor, [&] { return supervisor.stopped(); }));
  close(37);
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
  // SIGHUP (1), SIGINT (2) and SIGTERM (15).
  EXPECT_EQ(Read("a.log"), "SigBlk:\t0000000000004003\n");
}

TEST_F(SupervisorTest, NicenessIsRelativeAndKeptOnRestart) {
  // Waits until its niceness is set; then the first process dies.
  Script("polite",
         "until [ $(nice) -gt $1 ]; do :; done; nice >> nicenesses; [ $(wc -l < nicenesses) -lt 2 ] && kill -9 $$; "
         "exit 0");
  std::filesystem::current_path(folder_);
  const int own = getpriority(PRIO_PROCESS, 0);
  Supervisor supervisor = Make();
  supervisor.Start("a", "polite", {std::to_string(own)}, Ending::kMayEnd, 4);
  supervisor.SetReady("a", Clock::now());
  const std::string once = std::to_string(own + 4) + "\n";
  EXPECT_TRUE(TickUntil(supervisor, [&] { return Read("nicenesses") == once + once; })) << Read("nicenesses");
}

TEST_F(SupervisorTest, CrashBeforeReadyFailsWithTheLastLineOfTheLog) {
  Script("bad", "echo first; echo 'vo: error: rig.yaml:3: unknown key'; exit 1");
  Supervisor supervisor = Make();
  supervisor.Start("vo", "bad", {}, Ending::kRestart);
  ASSERT_TRUE(TickUntil(supervisor, [&] { return !supervisor.failure().empty(); }));
  EXPECT_EQ(supervisor.failure(), "vo: rig.yaml:3: unknown key");
  EXPECT_EQ(supervisor.restarts(), 0);
}

TEST_F(SupervisorTest, CrashAfterReadyIsRestarted) {
  Script("crash", "echo start >> starts; [ $(wc -l < starts) -ge 3 ] && exec sleep 100; kill -9 $$");
  Supervisor supervisor = Make();
  std::filesystem::current_path(folder_);
  supervisor.Start("a", "crash", {}, Ending::kRestart);
  supervisor.SetReady("a", Clock::now());
  ASSERT_TRUE(TickUntil(supervisor, [&] { return supervisor.restarts() == 2 && supervisor.pid("a") > 0; }));
  EXPECT_EQ(supervisor.failure(), "");
  EXPECT_TRUE(Stopped(supervisor));
  EXPECT_EQ(supervisor.reports()[0].exit_code, 128 + bus::kStopOrder);
  std::filesystem::current_path("/");
}

TEST_F(SupervisorTest, KilledBeforeReadyIsRestartedAndReported) {
  Script("killed", "echo start >> starts; [ $(wc -l < starts) -ge 3 ] && exec sleep 100; kill -9 $$");
  std::filesystem::current_path(folder_);
  for (const Ending ending : {Ending::kRestart, Ending::kMayEnd, Ending::kWritesAtTheEnd}) {
    std::filesystem::remove("starts");
    std::vector<std::string> reported;
    Supervisor::Options options;
    options.bin = options.logs = folder_;
    options.max_restarts = 3;
    options.first_pause = milliseconds(1);
    options.on_restart = [&](const std::string& name, const std::string& how, int restart) {
      reported.push_back(name + " " + how + " " + std::to_string(restart));
    };
    Supervisor supervisor(options);
    supervisor.Start("a", "killed", {}, ending);
    ASSERT_TRUE(TickUntil(supervisor, [&] { return supervisor.restarts() == 2 && supervisor.pid("a") > 0; }));
    EXPECT_EQ(supervisor.failure(), "");
    EXPECT_EQ(reported, (std::vector<std::string>{"a was ended by SIGKILL 1", "a was ended by SIGKILL 2"}));
    EXPECT_TRUE(Stopped(supervisor));
  }
  std::filesystem::current_path("/");
}

TEST_F(SupervisorTest, KillAllEndsHangingProcesses) {
  Script("stubborn", "trap '' USR1; echo up > up; while :; do read x < fifo; done");
  std::filesystem::current_path(folder_);
  ASSERT_EQ(system("mkfifo fifo"), 0);
  Supervisor supervisor = Make();
  supervisor.Start("a", "stubborn", {}, Ending::kRestart);
  ASSERT_TRUE(TickUntil(supervisor, [&] { return std::filesystem::exists(folder_ / "up"); }));
  std::thread([&] { supervisor.KillAll(); }).join();
  ASSERT_TRUE(TickUntil(supervisor, [&] { return supervisor.restarts() == 1; }));
  EXPECT_TRUE(supervisor.stopped());
  std::filesystem::current_path("/");
}

TEST_F(SupervisorTest, TooManyCrashesFail) {
  Script("crash", "exit 3");
  Supervisor supervisor = Make(2);
  supervisor.Start("a", "crash", {}, Ending::kRestart);
  supervisor.SetReady("a", Clock::now());
  ASSERT_TRUE(TickUntil(supervisor, [&] { return !supervisor.failure().empty(); }));
  EXPECT_EQ(supervisor.failure(), "a ended with exit code 3");
  EXPECT_EQ(supervisor.restarts(), 2);
}

TEST_F(SupervisorTest, PausesGrow) {
  Script("crash", "exit 3");
  Supervisor supervisor = MakePatient();
  supervisor.Start("a", "crash", {}, Ending::kRestart);
  supervisor.SetReady("a", Clock::now());
  ASSERT_TRUE(TickUntil(supervisor, [&] { return supervisor.pid("a") < 0; }));
  const auto ended = Clock::now();
  supervisor.Tick(ended + std::chrono::minutes(59));
  EXPECT_EQ(supervisor.restarts(), 0);
  supervisor.Tick(ended + std::chrono::minutes(61));
  EXPECT_EQ(supervisor.restarts(), 1);
  ASSERT_TRUE(TickUntil(supervisor, [&] { return supervisor.pid("a") < 0; }));
  supervisor.Tick(Clock::now() + std::chrono::minutes(61));
  EXPECT_EQ(supervisor.restarts(), 1) << "the second pause is twice as long";
}

TEST_F(SupervisorTest, PausesStayShortIfReadyEachTime) {
  Script("crash", "exit 3");
  Supervisor supervisor = MakePatient(9);
  supervisor.Start("a", "crash", {}, Ending::kRestart);
  auto now = Clock::now();
  for (int i = 0; i < 5; ++i) {
    supervisor.SetReady("a", now);
    const auto limit = Clock::now() + std::chrono::seconds(10);
    while (supervisor.pid("a") > 0 && Clock::now() < limit) supervisor.Tick(now);
    now += std::chrono::minutes(61);
    supervisor.Tick(now);
    ASSERT_EQ(supervisor.restarts(), i + 1);
  }
  supervisor.SetReady("a", now + std::chrono::minutes(9));
  EXPECT_NEAR(supervisor.reports()[0].slowest_restart_s, 70 * 60, 1e-6) << "61 minutes of pause and 9 of starting";
}

TEST_F(SupervisorTest, MayEndIsRestartedOnlyAfterASignal) {
  Script("player", "echo \"$*\" >> starts; [ $(wc -l < starts) -ge 2 ] && exit 4; kill -9 $$");
  std::vector<pid_t> ended;
  Supervisor supervisor({folder_, folder_, 9, milliseconds(1), milliseconds(5000),
                         [](const std::string& name, int restart, std::vector<std::string> arguments) {
                           arguments.push_back(name + std::to_string(restart));
                           return arguments;
                         },
                         [&](pid_t pid) { ended.push_back(pid); }});
  std::filesystem::current_path(folder_);
  supervisor.Start("a", "player", {"first"}, Ending::kMayEnd);
  const pid_t first = supervisor.pid("a");
  supervisor.SetReady("a", Clock::now());
  ASSERT_TRUE(TickUntil(supervisor, [&] { return !supervisor.failure().empty(); }));
  EXPECT_EQ(supervisor.restarts(), 1);
  EXPECT_EQ(supervisor.failure(), "a ended with exit code 4");
  EXPECT_EQ(Read("starts"), "first\nfirst a1\n");
  ASSERT_EQ(ended.size(), 2U);
  EXPECT_EQ(ended[0], first);
  std::filesystem::current_path("/");
}

TEST_F(SupervisorTest, EndOfAProcessThatMustRunIsACrash) {
  Script("quit", "exit 0");
  Supervisor supervisor = Make(0);
  supervisor.Start("viewer", "quit", {}, Ending::kRestart);
  ASSERT_TRUE(TickUntil(supervisor, [&] { return !supervisor.failure().empty(); }));
  EXPECT_EQ(supervisor.failure(), "viewer ended with exit code 0");
}

TEST_F(SupervisorTest, HangingProcessIsKilledInTheEnd) {
  Script("stubborn", "trap '' USR1; echo up > up; while :; do read x < fifo; done");
  std::filesystem::current_path(folder_);
  ASSERT_EQ(system("mkfifo fifo"), 0);
  Supervisor supervisor = Make(0, milliseconds(20));
  supervisor.Start("a", "stubborn", {}, Ending::kRestart);
  ASSERT_TRUE(TickUntil(supervisor, [&] { return std::filesystem::exists(folder_ / "up"); }));
  EXPECT_TRUE(Stopped(supervisor));
  EXPECT_EQ(supervisor.reports()[0].exit_code, 128 + SIGKILL);
  EXPECT_EQ(supervisor.failure(), "");
  std::filesystem::current_path("/");
}

TEST_F(SupervisorTest, ErrorsWhileStoppingAreFailures) {
  struct Row {
    const char* at_the_order;
    const char* failure;
  };
  for (const Row& row :
       {Row{"exit 0", ""}, Row{"echo 'no space left'; exit 1", "a ended with exit code 1: no space left"},
        Row{"kill -SEGV $$", "a was ended by SIGSEGV"}}) {
    for (const Ending ending : {Ending::kRestart, Ending::kMayEnd, Ending::kWritesAtTheEnd}) {
      Script("stops",
             std::string("trap \"") + row.at_the_order + "\" USR1; echo up > up; while :; do sleep 0.01; done");
      std::filesystem::current_path(folder_);
      std::filesystem::remove("up");
      Supervisor supervisor = Make();
      supervisor.Start("a", "stops", {}, ending);
      ASSERT_TRUE(TickUntil(supervisor, [&] { return std::filesystem::exists(folder_ / "up"); }));
      EXPECT_TRUE(Stopped(supervisor));
      EXPECT_EQ(supervisor.failure(), row.failure);
      EXPECT_EQ(supervisor.restarts(), 0);
    }
  }
  std::filesystem::current_path("/");
}

TEST_F(SupervisorTest, OwnStopSignalFailsOnlyReadyWriters) {
  struct Row {
    Ending ending;
    bool ready;
    const char* failure;
  };
  for (const Row& row : {Row{Ending::kRestart, true, ""}, Row{Ending::kWritesAtTheEnd, false, ""},
                         Row{Ending::kWritesAtTheEnd, true, "a was killed (SIGUSR1) while it stopped"}}) {
    Script("sleeper", "exec sleep 100");
    Supervisor supervisor = Make();
    supervisor.Start("a", "sleeper", {}, row.ending);
    if (row.ready) supervisor.SetReady("a", Clock::now());
    EXPECT_TRUE(Stopped(supervisor));
    EXPECT_EQ(supervisor.failure(), row.failure);
  }
}

TEST_F(SupervisorTest, WriterIsGivenTimeToStop) {
  Script("writer",
         "trap 'until [ -e go ]; do sleep 0.01; done; exit 0' USR1; echo up > up; while :; do sleep 0.01; done");
  std::filesystem::current_path(folder_);
  Supervisor supervisor = Make();
  supervisor.Start("viewer", "writer", {}, Ending::kWritesAtTheEnd);
  supervisor.SetReady("viewer", Clock::now());
  ASSERT_TRUE(TickUntil(supervisor, [&] { return std::filesystem::exists(folder_ / "up"); }));
  const auto stopped = Clock::now();
  supervisor.Stop(stopped);
  supervisor.Tick(stopped + std::chrono::seconds(59));
  std::ofstream(folder_ / "go") << "on";
  EXPECT_TRUE(Stopped(supervisor));
  EXPECT_EQ(supervisor.reports()[0].exit_code, 0);
  EXPECT_EQ(supervisor.failure(), "");
  std::filesystem::current_path("/");
}

TEST_F(SupervisorTest, WriterIsNotRestartedAfterAnError) {
  Script("full", "exit 1");
  Supervisor::Options options;
  options.bin = options.logs = folder_;
  std::string word;
  options.last_word = [&](pid_t pid) { return pid > 0 ? word : "of no process"; };
  Supervisor supervisor(options);
  supervisor.Start("recorder", "full", {}, Ending::kWritesAtTheEnd);
  supervisor.SetReady("recorder", Clock::now());
  ASSERT_TRUE(TickUntil(supervisor, [&] { return !supervisor.failure().empty(); }));
  EXPECT_EQ(supervisor.failed(), "recorder");
  EXPECT_EQ(supervisor.failure(), "recorder ended with exit code 1") << "its log is on the full disk";
  word = "run.lcm: cannot be written: No space left on device";
  EXPECT_EQ(supervisor.failure(), "recorder ended with exit code 1: " + word);
  EXPECT_EQ(supervisor.restarts(), 0);
  EXPECT_TRUE(Stopped(supervisor));
}

TEST_F(SupervisorTest, CrashedWriterIsReportedAtTheStop) {
  Script("crash", "kill -9 $$");
  Supervisor supervisor = MakePatient();
  supervisor.Start("viewer", "crash", {}, Ending::kWritesAtTheEnd);
  supervisor.SetReady("viewer", Clock::now());
  ASSERT_TRUE(TickUntil(supervisor, [&] { return supervisor.pid("viewer") < 0; }));
  EXPECT_EQ(supervisor.failure(), "");
  EXPECT_TRUE(Stopped(supervisor));
  EXPECT_EQ(supervisor.failure(), "viewer was ended by SIGKILL");
}

TEST_F(SupervisorTest, UsedTimeAndMemoryAreReported) {
  Script("work", "i=0; while [ $i -lt 20000 ]; do i=$((i+1)); done");
  Supervisor supervisor = Make();
  const std::vector<char> ours(200'000'000, 1);  // no memory of the child's
  supervisor.Start("a", "work", {}, Ending::kMayEnd);
  ASSERT_TRUE(TickUntil(supervisor, [&] { return supervisor.stopped(); }));
  EXPECT_GT(supervisor.reports()[0].cpu_s, 0.001);
  EXPECT_GT(supervisor.reports()[0].peak_memory_mb, 0.1);
  EXPECT_LT(supervisor.reports()[0].peak_memory_mb, 100.0) << ours.size();
}

TEST_F(SupervisorTest, MissingProgramIsNamed) {
  Supervisor supervisor = Make();
  EXPECT_THAT([&] { supervisor.Start("a", "absent", {}, Ending::kRestart); },
              testing::ThrowsMessage<std::runtime_error>(testing::HasSubstr("absent cannot be started")));
}

TEST_F(SupervisorTest, FiftyRestartsLeakNoFileAndNoProcess) {
  Script("crash", "kill -9 $$");
  const auto open_files = [] {
    const std::filesystem::directory_iterator files("/proc/self/fd");
    return std::distance(begin(files), end(files));
  };
  std::vector<pid_t> ended;
  Supervisor supervisor(
      {folder_, folder_, 50, milliseconds(0), milliseconds(5000), nullptr, [&](pid_t pid) { ended.push_back(pid); }});
  supervisor.Start("a", "crash", {}, Ending::kRestart);
  supervisor.SetReady("a", Clock::now());
  const auto before = open_files();
  ASSERT_TRUE(TickUntil(supervisor, [&] { return !supervisor.failure().empty(); }));
  EXPECT_EQ(supervisor.restarts(), 50);
  EXPECT_EQ(open_files(), before);
  ASSERT_EQ(ended.size(), 51U);
  for (const pid_t pid : ended) EXPECT_EQ(kill(pid, 0), -1) << pid << " is still there";
}

TEST_F(SupervisorTest, DestructionLeavesNothingRunning) {
  Script("sleeper", "exec sleep 100");
  pid_t pid = -1;
  {
    Supervisor supervisor = Make();
    supervisor.Start("a", "sleeper", {}, Ending::kRestart);
    pid = supervisor.pid("a");
    ASSERT_EQ(kill(pid, 0), 0);
  }
  EXPECT_EQ(kill(pid, 0), -1);
}

TEST(ChildProcess, StartErrorNamesTheProgramOrItsLog) {
  const ScratchFolder folder;
  const std::string log = folder.Path("a.log"), lost = folder.Path("gone/a.log");
  EXPECT_THAT(
      [&] { ChildProcess("/nowhere/vo_process", {}, log, 0); },
      testing::ThrowsMessage<std::runtime_error>("/nowhere/vo_process cannot be started: No such file or directory"));
  EXPECT_THAT([&] { ChildProcess("/bin/true", {}, lost, 0); },
              testing::ThrowsMessage<std::runtime_error>("/bin/true cannot be started because its log " + lost +
                                                         " cannot be written: No such file or directory"));
}

}  // namespace
}  // namespace plslam::launcher
