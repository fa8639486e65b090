// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <iostream>
#include <map>
#include <sstream>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "core/process/process_status.h"
#include "plslam/status_t.hpp"
#include "tests/integration/recorded_run.h"
#include "tests/integration/whole_run.h"
#include "tests/support/long_tests.h"
#include "tests/support/text_file.h"

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

std::string ToText(const std::vector<std::pair<double, double>>& samples) {
  std::string text;
  for (const auto& [time, mb] : samples) text += fmt::format(" {:.1f}", mb);
  return text;
}

/// Share of the run and MB, by process.
using Samples = std::map<std::string, std::vector<std::pair<double, double>>>;

/// Samples the memory of the launcher, which publishes no status, until it exits or for `limit_s`.
std::vector<std::pair<double, double>> WatchLauncher(const WholeRun& run, int limit_s) {
  using Clock = std::chrono::steady_clock;
  const auto began = Clock::now();
  const std::filesystem::path statm = fmt::format("/proc/{}/statm", run.process().pid());
  std::vector<std::pair<double, double>> samples;
  for (double s = 0.0; s < limit_s; s = std::chrono::duration<double>(Clock::now() - began).count()) {
    std::istringstream pages(ReadText(statm));
    double total = 0.0, resident = 0.0;
    if (!(pages >> total >> resident) || resident == 0.0) break;  // it has exited but was not waited for
    samples.emplace_back(s, resident * static_cast<double>(sysconf(_SC_PAGESIZE)) * 1e-6);
    std::this_thread::sleep_for(std::chrono::milliseconds(200));
  }
  for (auto& sample : samples) sample.first /= samples.back().first;
  return samples;
}

/// The second half of the run: caches, pools and windows are full by then.
void KeepSecondHalf(std::vector<std::pair<double, double>>& samples) {
  std::erase_if(samples, [](const auto& sample) { return sample.first <= 0.5; });
}

/// Memory while frames are sent: writing the results after the last one is not counted as growth. By frames and not by
/// time, which depends on other tests.
Samples MemoryOf(const std::vector<status_t>& statuses, int frames) {
  Samples memory, unconfirmed;
  double share = 0.0;
  for (const status_t& status : statuses) {
    if (status.process == "player" && status.state == "running") {
      share = bus::CounterOf(status, "frames.sent") / frames;
      for (const auto& [process, samples] : std::exchange(unconfirmed, {})) {
        memory[process].insert(memory[process].end(), samples.begin(), samples.end());
      }
    }
    unconfirmed[status.process].emplace_back(share, status.memory_mb);
  }
  return memory;
}

TEST(Memory, DoesNotGrowWithTheLengthOfTheRun) {
#ifdef PLSLAM_SANITIZED
  GTEST_SKIP() << "a sanitizer keeps what is freed, so that memory grows";
#endif
  const bool is_long = test::LongTests();
  // Forth and back, 99 frames each way.
  const int loops = is_long ? 101 : 13;
  const int frames = 1 + 2 * 99 * loops;
  WholeRun run;
  // A small bound of the history, so that it is reached in the first half: older messages are on disk.
  run.Start({"run", "synthetic:room?frames=100&size=160x120", "--loop", std::to_string(loops), "--bounce", "--record",
             run.log(), "--set", "bus.history_bytes=1000000"});
  const int limit_s = is_long ? 3600 : 240;
  auto launcher = WatchLauncher(run, limit_s);
  ASSERT_EQ(run.Wait(limit_s), 0) << run.Logs();
  const nlohmann::json summary = run.Summary();
  EXPECT_EQ(summary["frames"], frames);
  Samples memory = MemoryOf(test::ReadRecordedRun(run.log()).statuses, frames);
  memory["plslam"] = std::move(launcher);
  // The viewer stores over the whole run pictures for the report: 240 with their features, 20 kB each, and of 2000
  // keyframes, 4 kB each at this size. (Frames are in a file.)
  const double pictures_mb = 240 * 20e-3 + std::min(summary["keyframes"].get<double>(), 2000.0) * 4e-3;
  // Map and places grow slowly: each lap views the room from new positions in between. The heap of vo varies between 8
  // and 13 MB from frame to frame, and the allocator keeps the largest so far.
  const std::map<std::string, double> kept_mb{
      {"viewer", 0.5 * pictures_mb}, {"mapping", 3.0}, {"loop", 3.0}, {"vo", 1.5}};
  for (const char* process : {"player", "vo", "mapping", "loop", "viewer", "plslam"}) {
    KeepSecondHalf(memory[process]);
    ASSERT_GE(memory[process].size(), 5U) << process;
    const double grown_mb = Slope(memory[process]) * 0.5;
    std::cout << process << ": " << grown_mb << " MB in the second half of " << frames << " frames, "
              << summary["keyframes"] << " keyframes:" << ToText(memory[process]) << '\n';
    const double kept = kept_mb.contains(process) ? kept_mb.at(process) : 0.0;
    EXPECT_LT(grown_mb, 3.0 + kept) << process << ", MB in half the run:" << ToText(memory[process]);
  }
}

}  // namespace
}  // namespace plslam
