// SPDX-License-Identifier: BSD-3-Clause
#include "tests/integration/process_replay.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <string>

#include "plslam/loop_closure_t.hpp"
#include "plslam/pose_t.hpp"
#include "tests/integration/whole_run.h"

namespace plslam {
namespace {

using test::LoggedMessage;
using test::MessageLog;
using test::ProcessReplay;
using test::ReplayedProcess;
using test::ReplayedProcesses;
using test::ReplayFaults;
using test::WholeRun;

/// A run in lockstep that closes a loop, and its log.
class ProcessReplayTest : public testing::TestWithParam<ReplayedProcess> {
 protected:
  static void SetUpTestSuite() {
    run_ = std::make_unique<WholeRun>();
    ASSERT_EQ(run_->Run({"run", "synthetic:room?size=376x240&loops=2&speed=3&frames=120", "--record", run_->log()}),
              0)
        << run_->Logs();
    log_ = std::make_unique<MessageLog>(run_->log());
  }
  static void TearDownTestSuite() {
    log_.reset();
    run_.reset();
  }

  void SetUp() override { ASSERT_NE(log_, nullptr); }

  static std::unique_ptr<ProcessReplay> Replay(const MessageLog& log, const ReplayedProcess& process,
                                               const ReplayFaults& faults) {
    static int count = 0;
    return std::make_unique<ProcessReplay>(log, process, faults,
                                           run_->folder() / ("replay " + std::to_string(count++)));
  }

  /// The process says what it says in the log, and the viewer writes the same files.
  static void ExpectSame(const ReplayedProcess& process, const ReplayFaults& faults, const char* counter = nullptr) {
    const auto replay = Replay(*log_, process, faults);
    EXPECT_EQ(replay->Play(), "") << replay->Log();
    if (counter != nullptr) {
      EXPECT_GT(replay->Counter(counter), 0) << counter;
    }
    if (process.name != "viewer") return;
    for (const char* file : {"trajectory.tum", "trajectory_live.tum", "keyframes.tum", "covariance.txt", "map.ply"}) {
      EXPECT_NE(run_->Read(file), "") << file;
      EXPECT_TRUE(replay->Read(file) == run_->Read(file)) << file;
    }
  }

  /// The message of the log that is the middle of what the process says, or gets where it says nothing.
  static size_t MiddleOf(const ReplayedProcess& process) {
    size_t place = log_->messages.size() / 2;
    while (!process.outputs.empty() && !process.outputs.contains(log_->messages[place].channel->name)) ++place;
    return place;
  }

  static std::unique_ptr<WholeRun> run_;
  static std::unique_ptr<MessageLog> log_;
};

std::unique_ptr<WholeRun> ProcessReplayTest::run_;
std::unique_ptr<MessageLog> ProcessReplayTest::log_;

TEST_P(ProcessReplayTest, SaysWhatItSaysInTheLog) { ExpectSame(GetParam(), {}); }

TEST_P(ProcessReplayTest, DroppedMessagesChangeNothing) {
  ExpectSame(GetParam(), {.drop_fraction = 0.1}, "bus.repaired");
}

TEST_P(ProcessReplayTest, DoubledMessagesChangeNothing) {
  ExpectSame(GetParam(), {.doubled = true}, "bus.duplicates");
}

TEST_P(ProcessReplayTest, RestartChangesNothing) { ExpectSame(GetParam(), {.killed_behind = MiddleOf(GetParam())}); }

INSTANTIATE_TEST_SUITE_P(All, ProcessReplayTest, testing::ValuesIn(ReplayedProcesses()),
                         [](const auto& row) { return row.param.name; });

}  // namespace
}  // namespace plslam
