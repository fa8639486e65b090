// SPDX-License-Identifier: BSD-3-Clause
#include "tests/integration/process_replay.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "core/datasets/open_dataset.h"
#include "plslam/keyframe_t.hpp"
#include "plslam/map_update_t.hpp"
#include "tests/integration/image_folder_of.h"
#include "tests/integration/whole_run.h"
#include "tests/support/long_tests.h"

namespace plslam {
namespace {

using test::LoggedMessage;
using test::MessageLog;
using test::ProcessReplay;
using test::ReplayedProcess;
using test::ReplayedProcesses;
using test::ReplayFaults;
using test::WholeRun;

/// A run in lockstep, and its log.
class Recording {
 public:
  /// A lap and the beginning of another, which close loops; then the lens is covered while the camera is carried back
  /// to an earlier position, and relocalised.
  void RecordLapAndRelocalisation() {
    constexpr int kSeen = 82, kCovered = 8, kSeenAgain = 8;
    const auto room = OpenDataset("synthetic:room?size=376x240&loops=2&speed=4", "");
    std::vector<test::ChosenFrame> frames;
    for (int i = 0; i < kSeen; ++i) frames.push_back({i, false});
    for (int i = 0; i < kCovered; ++i) frames.push_back({kSeen, true});
    for (int i = 0; i < kSeenAgain; ++i) frames.push_back({20 + i, false});
    test::WriteImageFolder(*room, frames, run_.folder() / "frames");
    Record((run_.folder() / "frames").string());
  }

  void Record(const std::string& dataset) {
    ASSERT_EQ(run_.Run({"run", dataset, "--record", run_.log()}), 0) << run_.Logs();
    log_ = std::make_unique<MessageLog>(run_.log());
  }

  const WholeRun& run() const { return run_; }
  MessageLog& log() { return *log_; }

  std::unique_ptr<ProcessReplay> Replay(const ReplayedProcess& process, const ReplayFaults& faults = {}) {
    return std::make_unique<ProcessReplay>(*log_, process, faults,
                                           run_.folder() / ("replay " + std::to_string(n_replays_++)));
  }

  /// The process publishes the messages in the log, and a viewer writes the same files. Returns the value of a counter
  /// of the process.
  double ExpectSame(const ReplayedProcess& process, const ReplayFaults& faults = {},
                    const std::string& counter = "") {
    const auto replay = Replay(process, faults);
    EXPECT_EQ(replay->Play(), "") << replay->Log();
    if (process.name == "viewer") {
      for (const char* file :
           {"trajectory.tum", "trajectory_live.tum", "keyframes.tum", "covariance.txt", "map.ply"}) {
        EXPECT_NE(run_.Read(file), "") << file;
        EXPECT_TRUE(replay->Read(file) == run_.Read(file)) << file;
      }
    }
    return replay->Counter(counter);
  }

  /// Returns the messages of the log after which the process is killed: the middle one of its outputs (or of its
  /// inputs, if it has no outputs). In long tests, messages all along the log.
  std::vector<size_t> KillPlaces(const ReplayedProcess& process) const {
    constexpr size_t kStride = 23;
    std::vector<size_t> places;
    for (size_t i = kStride; test::LongTests() && i < log_->messages.size(); i += kStride) places.push_back(i);
    size_t middle = log_->messages.size() / 2;
    while (!process.outputs.empty() && !process.outputs.contains(log_->messages[middle].channel->name)) ++middle;
    places.push_back(middle);
    return places;
  }

  /// Number of the message with which the map takes over a loop, which is then adjusted.
  size_t AcceptedLoop() const {
    const auto accepted = std::ranges::find_if(log_->messages, [](const LoggedMessage& message) {
      return message.channel->name == bus::kMapUpdate.name &&
             bus::Decoded<map_update_t>(message.bytes)->answer.accepted == 1;
    });
    return static_cast<size_t>(accepted - log_->messages.begin());
  }

 private:
  WholeRun run_;
  std::unique_ptr<MessageLog> log_;
  int n_replays_ = 0;
};

/// By process, all with one recording.
class ProcessReplayTest : public testing::TestWithParam<ReplayedProcess> {
 protected:
  static Recording& Lap() {
    if (lap_ == nullptr) {
      lap_ = std::make_unique<Recording>();
      lap_->RecordLapAndRelocalisation();
    }
    return *lap_;
  }
  static void TearDownTestSuite() { lap_.reset(); }

 private:
  static std::unique_ptr<Recording> lap_;
};

std::unique_ptr<Recording> ProcessReplayTest::lap_;

TEST_P(ProcessReplayTest, ReplayWithAndWithoutFaultsIsTheSame) {
  Recording& lap = Lap();
  ASSERT_FALSE(HasFatalFailure());
  const nlohmann::json summary = lap.run().Summary();
  ASSERT_GE(summary["loops"], 1);
  ASSERT_GE(summary["loop_closing"]["relocalisations"]["found"], 1);
  const ReplayedProcess& process = GetParam();
  {
    SCOPED_TRACE("without faults");
    lap.ExpectSame(process);
  }
  {
    SCOPED_TRACE("messages are dropped");
    EXPECT_GT(lap.ExpectSame(process, {.drop_fraction = 0.1}, "bus.repaired"), 0);
  }
  {
    SCOPED_TRACE("messages are doubled");
    EXPECT_GT(lap.ExpectSame(process, {.doubled = true}, "bus.duplicates"), 0);
  }
  for (const size_t place : lap.KillPlaces(process)) {
    SCOPED_TRACE(fmt::format("killed behind message {} of {}", place, lap.log().messages.size()));
    lap.ExpectSame(process, {.killed_behind = place});
  }
  if (process.name == "mapping" || process.name == "loop") {
    SCOPED_TRACE("killed when a loop has come into the map");
    lap.ExpectSame(process, {.killed_behind = lap.AcceptedLoop(), .few_updates = true});
  }
}

INSTANTIATE_TEST_SUITE_P(Of, ProcessReplayTest, testing::ValuesIn(ReplayedProcesses()),
                         [](const auto& row) { return row.param.name; });

/// The messages of a channel in a log.
std::vector<LoggedMessage*> Of(MessageLog& log, const bus::Channel& channel) {
  std::vector<LoggedMessage*> messages;
  for (LoggedMessage& message : log.messages) {
    if (message.channel->name == channel.name) messages.push_back(&message);
  }
  return messages;
}

const ReplayedProcess& Mapping() {
  return *std::ranges::find(ReplayedProcesses(), "mapping", &ReplayedProcess::name);
}

TEST(ProcessReplay, DifferencesAreDescribed) {
  Recording recording;
  recording.Record("synthetic:room?size=376x240&frames=20");
  ASSERT_FALSE(HasFatalFailure());
  MessageLog& log = recording.log();
  const std::vector<LoggedMessage> unchanged = log.messages;

  // A page of the second version, which is published once; the first is repeated for a late reader.
  const std::vector<LoggedMessage*> updates = Of(log, bus::kMapUpdate);
  const auto second = std::ranges::find_if(
      updates, [](const LoggedMessage* message) { return bus::Decoded<map_update_t>(message->bytes)->version == 2; });
  ASSERT_NE(second, updates.end());
  LoggedMessage& update = **second;
  auto page = *bus::Decoded<map_update_t>(update.bytes);
  const std::string name = fmt::format("MAP_UPDATE of version {}, page {}", page.version, page.page);
  const int64_t n_points = page.totals.n_points++;
  update.bytes = bus::Encoded(page);
  EXPECT_EQ(recording.Replay(Mapping())->Play(),
            fmt::format("{}: totals.n_points is {}, in the log {}", name, n_points, n_points + 1));

  log.messages = unchanged;
  log.messages.erase(log.messages.begin() + (&update - log.messages.data()));
  EXPECT_EQ(recording.Replay(Mapping())->Play(), name + " is not in the log");

  log.messages = unchanged;
  LoggedMessage& keyframe = *Of(log, bus::kKeyframe).at(0);
  auto features = *bus::Decoded<keyframe_t>(keyframe.bytes);
  features.points.at(0).u_px += 1.0F;
  keyframe.bytes = bus::Encoded(features);
  EXPECT_THAT(recording.Replay(Mapping())->Play(),
              testing::MatchesRegex(R"(MAP_UPDATE of version 1, page 0: points\[[0-9]+\].* is .*, in the log .*)"));
}

}  // namespace
}  // namespace plslam
