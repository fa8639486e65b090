// A wall clock that is stepped must change nothing: only steady clocks are looked at, but for the time stamps of logs.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <regex>
#include <set>
#include <string>

#include "tests/support/data_folder.h"

namespace plslam {
namespace {

namespace fs = std::filesystem;

const char* const kFolders[] = {"core",         "player",          "vo_process", "mapping_process",
                                "loop_process", "viewer_headless", "tools"};

std::set<std::string> FilesThatReadTheWallClock() {
  // Written apart, so that this file is none.
  const std::regex reads(
      "system_"
      "clock|CLOCK_"
      "REALTIME|gettime"
      "ofday|\\btime\\((nullptr|NULL|0)\\)");
  std::set<std::string> files;
  for (const char* folder : kFolders) {
    for (const auto& entry : fs::recursive_directory_iterator(test::SourceFolder() / folder)) {
      const std::string extension = entry.path().extension();
      if (extension != ".cpp" && extension != ".h") continue;
      std::ifstream file(entry.path());
      const std::string text{std::istreambuf_iterator<char>(file), {}};
      if (std::regex_search(text, reads)) files.insert(fs::relative(entry.path(), test::SourceFolder()).string());
    }
  }
  return files;
}

TEST(WallClock, IsReadForTimeStampsOfLogsAndByTheDoctorOnly) {
  for (const std::string& file : FilesThatReadTheWallClock()) {
    // process_status says it to whoever compares hosts.
    const bool may = file == "core/bus/log_writer.cpp" || file == "core/bus/history.cpp" ||
                     file == "core/bus/process_status.cpp" || file.starts_with("tools/doctor/");
    EXPECT_TRUE(may) << file;
  }
}

}  // namespace
}  // namespace plslam
