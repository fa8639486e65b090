// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <signal.h>

#include <algorithm>
#include <chrono>
#include <thread>

#include "core/bus/bus.h"
#include "core/io/trajectories/trajectory.h"
#include "plslam/map_update_t.hpp"
#include "tests/integration/whole_run.h"
#include "tests/support/data_folder.h"
#include "tools/evaluate/trajectory_errors.h"
#include "tools/launch/run_bus.h"

namespace plslam::launcher {
namespace {

using test::WholeRun;

/// mapping_process and loop_process of several robots, and a listener to their messages.
class SharedMap {
 public:
  SharedMap(const std::string& url, const std::filesystem::path& folder) : bus_(Options(url), "listener") {
    for (const char* executable : {"mapping_process", "loop_process"}) {
      processes_.push_back(std::make_unique<ChildProcess>(test::BinaryFolder() / executable,
                                                          std::vector<std::string>{"--url", url, "--prefix", "team/"},
                                                          folder / (std::string(executable) + ".log")));
    }
    bus_.Subscribe<map_update_t>(bus::kMapUpdate,
                                 [this](const map_update_t& update) { n_keyframes_ = update.totals.n_keyframes; });
    thread_ = std::thread([this] { bus_.Run(); });
  }
  ~SharedMap() {
    bus_.Stop();
    thread_.join();
  }
  bool WaitForKeyframes(int64_t n) {
    return WholeRun::WaitFor([&] { return n_keyframes_ >= n; });
  }
  /// Exit codes of all, after SIGINT.
  std::vector<int> Stop() {
    std::vector<int> codes;
    for (const auto& process : processes_) process->Signal(SIGINT);
    for (const auto& process : processes_) {
      EXPECT_TRUE(WholeRun::WaitFor([&] { return process->Poll().has_value(); }));
      codes.push_back(process->Poll() ? process->Poll()->code : -1);
    }
    return codes;
  }

 private:
  static bus::BusOptions Options(const std::string& url) {
    bus::BusOptions options;
    options.url = url;
    options.prefix = "team/";
    return options;
  }

  bus::Bus bus_;
  std::atomic<int64_t> n_keyframes_ = 0;
  std::vector<std::unique_ptr<ChildProcess>> processes_;
  std::thread thread_;
};

PosePairs PairsOf(const WholeRun& run) {
  return AssociateNearest(ReadTrajectory((run.out() / "trajectory.tum").string()),
                          ReadTrajectory((run.out() / "groundtruth.tum").string()), 1'000'000);
}

double WorstError_m(const PosePairs& pairs, const Similarity& alignment) {
  return std::ranges::max(
      evaluate::ComputeAbsoluteErrors(pairs, alignment, Eigen::Quaterniond::Identity()).translation_m);
}

const std::string kCamera = "&size=376x240";
const std::string kOtherCamera = "&size=480x320&fov=70&baseline=0.2";

std::vector<std::string> Robot(const std::string& url, const std::string& prefix, const std::string& camera,
                               int start, int stop) {
  return {"run",          "synthetic:room?frames=240" + camera,
          "--url",        url,
          "--start",      std::to_string(start),
          "--stop",       std::to_string(stop),
          "--prefix",     prefix,
          "--map-prefix", "team/"};
}

/// The differences between the robots, and whether a tracker is killed during the run.
struct FleetCase {
  const char* name;
  const std::string* second_camera;
  bool is_killed;
};
void PrintTo(const FleetCase& fleet, std::ostream* stream) { *stream << fleet.name; }
class Fleet : public testing::TestWithParam<FleetCase> {};

// Each begins at a different position, and their relative pose is unknown before one reaches an area of the other.
TEST_P(Fleet, TwoRobotsWithTheirOwnPrefixesMakeOneMap) {
  const PrivatePort port;
  WholeRun first, second;
  SharedMap shared(port.Url(), first.folder());
  first.Start(Robot(port.Url(), "ann/", kCamera, 0, 160));
  ASSERT_TRUE(shared.WaitForKeyframes(3)) << first.Logs();
  second.Start(Robot(port.Url(), "bob/", *GetParam().second_camera, 80, 240));
  if (GetParam().is_killed) {
    ASSERT_TRUE(shared.WaitForKeyframes(12)) << second.Logs();
    ASSERT_TRUE(second.Signal("vo_process", SIGKILL));
  }
  EXPECT_EQ(first.Wait(), 0) << first.Logs();
  EXPECT_EQ(second.Wait(), 0) << second.Logs();
  for (const WholeRun* run : {&first, &second}) {
    const nlohmann::json summary = run->Summary();
    EXPECT_EQ(summary["tracked_frames"], 160) << summary.dump(1);
    EXPECT_EQ(summary["processes"].count("mapping"), 0U);
    EXPECT_GT(summary["map"]["keyframes"], 5);
  }
  const PosePairs of_first = PairsOf(first), of_second = PairsOf(second);
  ASSERT_FALSE(of_first.empty() || of_second.empty());
  const Similarity alignment = evaluate::Align(of_first, evaluate::Alignment::kSe3);
  const double first_m = WorstError_m(of_first, alignment), second_m = WorstError_m(of_second, alignment);
  std::cout << "farthest from the truth, both laid on it by the first: " << first_m << " m, " << second_m << " m\n";
  EXPECT_LT(first_m, 0.05);
  EXPECT_LT(second_m, 0.05);
  EXPECT_EQ(shared.Stop(), (std::vector<int>{0, 0})) << first.Logs();
}

INSTANTIATE_TEST_SUITE_P(Robots, Fleet,
                         testing::Values(FleetCase{"TrackerIsKilled", &kCamera, true},
                                         FleetCase{"OtherCamera", &kOtherCamera, false}),
                         [](const auto& fleet) { return fleet.param.name; });

}  // namespace
}  // namespace plslam::launcher
