#include <gtest/gtest.h>

#include <iostream>
#include <map>
#include <string>

#include "tests/integration/recorded_run.h"
#include "tests/integration/whole_run.h"
#include "tests/support/long_tests.h"

namespace plslam {
namespace {

using test::WholeRun;

/// Least squares through (x, y): rise of y for one x.
double Slope(const std::vector<std::pair<double, double>>& points) {
  double n = 0, sx = 0, sy = 0, sxx = 0, sxy = 0;
  for (const auto& [x, y] : points) {
    n += 1;
    sx += x;
    sy += y;
    sxx += x * x;
    sxy += x * y;
  }
  const double determinant = n * sxx - sx * sx;
  return determinant > 0 ? (n * sxy - sx * sy) / determinant : 0.0;
}

TEST(Memory, DoesNotGrowWithTheLengthOfTheRun) {
  const bool is_long = test::LongTests();
  // Forth and back, 99 frames each way.
  const int loops = is_long ? 101 : 25;
  const int frames = 1 + 2 * 99 * loops;
  WholeRun run;
  // A small bound of the history, so that it is reached in the first half: what is older lies on disk.
  run.Start({"run", "synthetic:room?frames=100&size=160x120", "--loop", std::to_string(loops), "--bounce", "--record",
             run.log(), "--set", "bus.history_bytes=1000000"});
  ASSERT_EQ(run.Wait(is_long ? 3600 : 240), 0) << run.Logs();
  EXPECT_EQ(run.Summary()["frames"], frames);
  // Second half of the run: caches, pools and windows are full by then.
  const auto log = test::ReadRecordedRun(run.log());
  std::map<std::string, double> end_s;
  for (const auto& status : log.statuses) end_s[status.process] = status.uptime_s;
  std::map<std::string, std::vector<std::pair<double, double>>> memory;
  for (const auto& status : log.statuses) {
    const double share = status.uptime_s / end_s[status.process];
    if (share > 0.5 && status.state != "stopping") memory[status.process].emplace_back(share, status.memory_mb);
  }
  for (const char* process : {"player", "vo", "viewer"}) {
    ASSERT_GE(memory[process].size(), 5U) << process;
    std::cout << process << ": " << Slope(memory[process]) * 0.5 << " MB in the second half of " << frames
              << " frames\n";
    // The viewer keeps what it knows of each frame, half a kilobyte, and over the whole run 240 pictures with their
    // features, 20 kB each, for the report.
    const double kept_mb = process == std::string("viewer") ? 0.5 * (frames * 500e-6 + 240 * 20e-3) : 0.0;
    EXPECT_LT(Slope(memory[process]) * 0.5, 3.0 + kept_mb) << process << ", MB in half the run";
  }
}

}  // namespace
}  // namespace plslam
