// SPDX-License-Identifier: BSD-3-Clause
// How images of a robot of ROS 2 reach the bus: none is lost without a report, soon, and at a small cost.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <regex>
#include <sstream>
#include <string>
#include <vector>

#include "tests/integration/bus_frames.h"
#include "tests/integration/ros2_robot.h"
#include "tests/support/long_tests.h"

namespace plslam::test {
namespace {

using nlohmann::json;

/// Milliseconds of processor time that a process has used.
double CpuMs(pid_t pid) {
  std::istringstream fields(ReadText(fmt::format("/proc/{}/stat", pid)));
  constexpr int kUser = 13, kSystem = 14;
  std::string word;
  double ticks = 0.0;
  for (int i = 0; i <= kSystem && fields >> word; ++i) ticks += i >= kUser ? std::stod(word) : 0.0;
  return 1e3 * ticks / static_cast<double>(sysconf(_SC_CLK_TCK));
}

class Ros2Delivery : public Ros2 {
 protected:
  void SetUp() override {
#ifdef PLSLAM_SANITIZED
    GTEST_SKIP() << "times, of a program that is slower";
#else
    Ros2::SetUp();
#endif
  }

  /// Sends images of this world at this rate, and reads the frames as vo_process does.
  void Deliver(const std::string& world, int rate_hz, int n_frames, std::vector<std::string> options = {}) {
    std::unique_ptr<BusFrames> frames;
    host_->Do([&] { frames = std::make_unique<BusFrames>(kBusUrl); });
    const auto process = StartProcess();
    ASSERT_TRUE(LogHas("waiting for images")) << Log();
    options.insert(options.begin(),
                   {world, std::to_string(rate_hz), std::to_string(n_frames), "synchronous", "different=15"});
    const double before_ms = CpuMs(process->pid());
    const auto robot = StartRobot(options);
    Wait(*robot);
    cpu_ms_ = (CpuMs(process->pid()) - before_ms) / n_frames;
    Stop(*process);
    const auto at_s = frames->at_s();
    n_frames_ = at_s.size();
    for (const auto& [t_ns, at] : at_s) stamps_ns_.push_back(t_ns);
    const json heard = Heard();
    for (const json& sent : heard["sent_at_s"]) {
      const auto found = at_s.find(sent[0].get<int64_t>());
      if (found != at_s.end()) delays_ms_.push_back(1e3 * (found->second - sent[1].get<double>()));
    }
    std::sort(delays_ms_.begin(), delays_ms_.end());
    ASSERT_FALSE(delays_ms_.empty()) << Log();
    fmt::print("{}: {} of {} frames; {:.2f} ms median, {:.2f} ms 95 % after the last byte; CPU {:.2f} ms a frame\n",
               world, n_frames_, n_frames, median_ms(), delays_ms_[delays_ms_.size() * 95 / 100], cpu_ms_);
  }

  double median_ms() const { return delays_ms_[delays_ms_.size() / 2]; }

  size_t n_frames_ = 0;
  std::vector<int64_t> stamps_ns_;  ///< of the frames
  double cpu_ms_ = 0.0;             ///< of plslam_ros2, for a frame
  std::vector<double> delays_ms_;   ///< from the last byte of the right image to the reader of the frame, sorted
};

TEST_F(Ros2Delivery, EveryFrameSoonAndCheaply) {
  ASSERT_NO_FATAL_FAILURE(Deliver("synthetic:room?size=752x480&frames=200", 20, 200));
  // Other tests run beside an everyday one.
  EXPECT_GE(n_frames_, LongTests() ? 200U : 190U) << Log();
  EXPECT_LT(median_ms(), LongTests() ? 3.0 : 20.0);
  EXPECT_LT(cpu_ms_, LongTests() ? 2.5 : 5.0);
}

// The buffer that a kernel grants by default.
TEST_F(Ros2Delivery, LargeImagesAreLostWithAReport) {
  setenv(
      "CYCLONEDDS_URI",
      "<CycloneDDS><Domain><Internal><SocketReceiveBufferSize min=\"default\" max=\"212992B\"/></Internal></Domain>"
      "</CycloneDDS>",
      1);
  Deliver("synthetic:room?size=1280x720&frames=150", 30, 150);
  unsetenv("CYCLONEDDS_URI");
  ASSERT_FALSE(HasFatalFailure());
  const std::string log = Log();
  std::smatch found;
  ASSERT_TRUE(std::regex_search(log, found,
                                std::regex(R"(ended: (\d+) frames, (\d+) unpaired, 0 rejected, (\d+) images lost)")))
      << log;
  const int n_frames = std::stoi(found[1]), n_unpaired = std::stoi(found[2]), n_lost = std::stoi(found[3]);
  // Each image between two frames is in a frame, without its partner, or lost; but gaps of more than two seconds do not
  // count, and the ends are not known.
  int n_between = 0;
  for (size_t i = 1; i < stamps_ns_.size(); ++i) {
    const int64_t step_ns = stamps_ns_[i] - stamps_ns_[i - 1];
    if (step_ns < 2'000'000'000) n_between += 2 * static_cast<int>(std::lround(20e-9 * static_cast<double>(step_ns)));
  }
  const int n_known = 2 * n_frames + n_unpaired + n_lost;
  EXPECT_LE(n_known, 300) << log;
  EXPECT_GE(n_known, n_between + 2) << log;
  EXPECT_GE(n_between, 60) << log;
  const bool is_warned = log.find(" Hz arrive: ") != std::string::npos;
  EXPECT_TRUE(is_warned || n_frames > 120) << log;
}

}  // namespace
}  // namespace plslam::test
