// SPDX-License-Identifier: BSD-3-Clause
// A wall clock that is stepped must change nothing: only steady clocks are read, except for the time stamps of logs.
#include <gtest/gtest.h>

#include <algorithm>
#include <regex>

#include "tests/unit/structure/source_tree.h"

namespace plslam {
namespace {

bool ReadsTheWallClock(const test::SourceFile& file) {
  static const std::regex kReads(
      "system_clock|wall_clock\\.h|CLOCK_REALTIME|gettimeofday|\\btime\\((nullptr|NULL|0)\\)");
  return std::any_of(file.lines.begin(), file.lines.end(),
                     [](const std::string& line) { return std::regex_search(line, kReads); });
}

TEST(WallClock, IsReadForTimeStampsOfLogsAndByTheDoctorOnly) {
  for (const auto& file : test::SourceFiles({"core", "adapter", "camera", "player", "vo_process", "mapping_process",
                                             "loop_process", "viewer_headless", "dense_process", "ros2", "tools"})) {
    if (!ReadsTheWallClock(file)) continue;
    // process_status publishes it for a comparison of hosts. Live images have the time of day, by an offset that is
    // measured once.
    const bool may = file.path == "camera/camera_pipeline.cpp" || file.path == "core/bus/transport/wall_clock.h" ||
                     file.path == "core/bus/logs/log_writer.cpp" || file.path == "core/bus/delivery/history.cpp" ||
                     file.path == "core/process/process_status.cpp" ||
                     file.path == "vo_process/node/self_calibration_file.cpp" ||  // the day it was written
                     file.path.starts_with("tools/doctor/");
    EXPECT_TRUE(may) << file.path;
  }
}

}  // namespace
}  // namespace plslam
