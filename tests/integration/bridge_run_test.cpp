// SPDX-License-Identifier: BSD-3-Clause
// A run that is watched through `plslam bridge` by the protocol's own client.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <regex>
#include <string>
#include <vector>

#include "core/io/trajectories/trajectory.h"
#include "core/ros/ros_topics.h"
#include "tests/integration/run_watcher.h"
#include "tests/integration/whole_run.h"
#include "tests/support/data_folder.h"
#include "tests/support/key_file.h"
#include "tests/support/shell.h"
#include "tools/launch/child_process.h"

namespace plslam::test {
namespace {

using nlohmann::json;
using testing::HasSubstr;

class Bridge : public testing::Test {
 protected:
  void SetUp() override {
    if (!HasProgram("node") || !std::filesystem::exists(PLSLAM_MCAP_MODULES "/@foxglove/ws-protocol")) {
      GTEST_SKIP() << "no node, or its packages could not be fetched at the build";
    }
  }

  /// Starts `plslam bridge` on a free port.
  void StartBridge(std::vector<std::string> options = {}) {
    options.insert(options.begin(), {"bridge", "--port", "0", "--url", watcher_.url()});
    const std::filesystem::path log = folder_.Path("bridge.log");
    bridge_ = std::make_unique<launcher::ChildProcess>(BinaryFolder() / "plslam", options, log);
    std::smatch match;
    ASSERT_TRUE(WholeRun::WaitFor([&] {
      const std::string text = ReadText(log);
      if (!std::regex_search(text, match, std::regex("ws://127.0.0.1:([0-9]+)"))) return false;
      port_ = match[1];
      return true;
    })) << ReadText(log);
  }
  void StopBridge() {
    bridge_->Signal(SIGINT);
    ASSERT_TRUE(WholeRun::WaitFor([&] { return bridge_->Poll().has_value(); }));
    EXPECT_EQ(bridge_->Poll()->code, 0) << ReadText(folder_.Path("bridge.log"));
  }

  /// A viewer that listens for so long; its findings are in `file`.
  std::unique_ptr<launcher::ChildProcess> StartViewer(const std::string& file, int seconds,
                                                      const std::string& options = "{}") {
    const std::string script = (SourceFolder() / "tests/mcap/listen_foxglove.mjs").string();
    return std::make_unique<launcher::ChildProcess>(
        "/bin/sh",
        std::vector<std::string>{"-c", fmt::format("exec node '{}' '{}' {} {} '{}' >'{}'", script,
                                                   PLSLAM_MCAP_MODULES, port_, seconds, options, folder_.Path(file))},
        folder_.Path(file + ".log"));
  }
  json FindingsOf(launcher::ChildProcess& viewer, const std::string& file) {
    EXPECT_TRUE(WholeRun::WaitFor([&] { return viewer.Poll().has_value(); }));
    const json found = json::parse(ReadText(folder_.Path(file)), nullptr, false);
    EXPECT_TRUE(found.is_object()) << ReadText(folder_.Path(file + ".log"));
    return found;
  }

  /// Every pose of the run has arrived, once, as it was when its frame was new.
  void ExpectThePosesOfTheRun(const json& found) {
    Trajectory live = ReadTrajectory(run_.out() / "trajectory_live.tum", TrajectoryFormat::kTum);
    ASSERT_GT(live.size(), 100U);
    // When the first ones were new, there was no map that they could be part of.
    const size_t n_before = live.size() - std::min(live.size(), found["odom"].size());
    EXPECT_GE(n_before, 1U);
    ASSERT_LE(n_before, 4U);
    live.erase(live.begin(), live.begin() + static_cast<std::ptrdiff_t>(n_before));
    ASSERT_EQ(found["odom"].size(), live.size());
    for (size_t i = 0; i < live.size(); ++i) {
      EXPECT_EQ(found["odom"][i][0], std::to_string(live[i].t_ns));
      for (int k = 0; k < 3; ++k) {
        EXPECT_NEAR(found["odom"][i][k + 1].get<double>(), live[i].T_a_b.translation()[k], 1e-6) << i;
      }
    }
  }

  ScratchFolder folder_;
  RunWatcher watcher_;
  WholeRun run_;
  std::string port_;
  std::unique_ptr<launcher::ChildProcess> bridge_;
};

// The bus has a key.
TEST_F(Bridge, ViewersOfBothProtocolsSeeTheRun) {
  const std::string key = "bus.key_file=" + KeyFile(folder_.Path(""), '7');
  StartBridge({"--map-file", folder_.Path("house.plmap"), "--set", key});
  const auto viewer = StartViewer(
      "viewer", 150,
      R"({"protocol": "foxglove.sdk.v1", "call_after_s": 6, "calls": {"/plslam/localise_only": {"data": false}, "/plslam/save": {}}})");
  const auto slow = StartViewer("slow", 150, R"({"stop_reading_s": 5})");
  const bool has_dense = std::filesystem::exists(test::BinaryFolder() / "dense_process");
  std::vector<std::string> command{
      "run", "synthetic:room?size=376x240&frames=160", "--url", watcher_.url(), "--pace", "realtime", "--set", key};
  if (has_dense) command.emplace_back("--dense");
  ASSERT_EQ(run_.Run(command), 0) << run_.Logs();
  for (const auto* listener : {viewer.get(), slow.get()}) listener->Signal(SIGTERM);
  json found = FindingsOf(*viewer, "viewer");
  EXPECT_TRUE(found["failures"].empty()) << found["failures"];
  for (const RosTopic& topic : RosTopics()) {
    const bool is_dense = topic.name == ros_topic::kGrid.name || topic.name == ros_topic::kSurfaces.name;
    if (!topic.is_live || (is_dense && !has_dense)) continue;
    ASSERT_TRUE(found["topics"].contains(topic.name)) << topic.name;
    EXPECT_GT(found["topics"][topic.name]["n"].get<int>(), 0) << topic.name;
  }
  EXPECT_EQ(found["topics"]["/camera/left/compressed"]["first_bytes"], json({0xff, 0xd8}));
  ExpectThePosesOfTheRun(found);
  EXPECT_EQ(found["answers"]["/plslam/localise_only"]["success"], true) << found["answers"];
  EXPECT_EQ(found["answers"]["/plslam/save"]["success"], true) << found["answers"];
  EXPECT_TRUE(std::filesystem::exists(folder_.Path("house.plmap")));
  const int n_images = found["topics"]["/camera/left/compressed"]["n"];
  EXPECT_EQ(found["parameters"]["vo.features.features"], "both") << found["parameters"];
  EXPECT_THAT(found["statuses"].dump(), HasSubstr("parameters are read-only"));
  found = FindingsOf(*slow, "slow");
  EXPECT_TRUE(found["failures"].empty()) << found["failures"];
  ExpectThePosesOfTheRun(found);
  EXPECT_LT(found["topics"]["/camera/left/compressed"]["n"].get<int>(), n_images - 5);
  StopBridge();
}

TEST_F(Bridge, OtherClientsAreRefusedWithASentence) {
  StartBridge();
  const auto refusal = [&](const std::string& options) {
    const auto viewer = StartViewer("viewer", 5, options);
    return FindingsOf(*viewer, "viewer")["refused"];
  };
  json refused = refusal(R"({"protocol": "rosbridge_v2"})");
  EXPECT_EQ(refused["status"], 400);
  EXPECT_THAT(refused["text"].get<std::string>(), HasSubstr("foxglove.sdk.v1 and foxglove.websocket.v1"));
  refused = refusal(R"({"origin": "https://evil.example"})");
  EXPECT_EQ(refused["status"], 400);
  EXPECT_THAT(refused["text"].get<std::string>(), HasSubstr("name it with --origin"));
  StopBridge();
}

}  // namespace
}  // namespace plslam::test
