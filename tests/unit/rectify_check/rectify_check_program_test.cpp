// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "core/io/images/image_file.h"
#include "tests/support/data_folder.h"
#include "tests/support/text_file.h"

namespace plslam::rectify_check {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class RectifyCheckProgram : public testing::Test {
 protected:
  RectifyCheckProgram() {
    std::string pattern = testing::TempDir() + "rectify XXXXXX";
    folder_ = mkdtemp(pattern.data());
  }
  ~RectifyCheckProgram() override { fs::remove_all(folder_); }

  int Run(const std::string& arguments) {
    const std::string command = "cd '" + folder_.string() + "' && '" + (test::BinaryFolder() / "plslam").string() +
                                "' rectify-check " + arguments + " >out 2>error";
    return WEXITSTATUS(std::system(command.c_str()));  // NOLINT: the test runs the program
  }
  std::string Text(const std::string& name) const { return ReadText(folder_ / name); }
  fs::path folder_;
};

TEST_F(RectifyCheckProgram, AWorldIsWellRectified) {
  ASSERT_EQ(Run("'synthetic:room?frames=4&size=376x240' --json --out a.png"), 0) << Text("error");
  const auto json = nlohmann::json::parse(Text("out"));
  EXPECT_TRUE(json["usable"].get<bool>());
  EXPECT_LT(json["median_abs_px"].get<double>(), 0.5);
  EXPECT_GT(json["matches"].get<int>(), 100);
  EXPECT_GT(ReadImageSize((folder_ / "a.png").string()).width_px, 2 * 376);
}

// `All/RealSequence.WarnsOnlyOfWhatIsWrong` expects the same warning of a run.
TEST_F(RectifyCheckProgram, LengthsAreMeasuredAsInARun) {
  PLSLAM_REQUIRE_DATA(sequence, "kitti_01");
  ASSERT_EQ(Run(fmt::format("'{}' --json", sequence.string())), 0) << Text("error");
  const auto json = nlohmann::json::parse(Text("out"));
  EXPECT_NEAR(json["length_error_percent"].get<double>(), 15.0, 1.0) << json;
  EXPECT_NEAR(json["length_sigma_percent"].get<double>(), 1.0, 0.5) << json;
  EXPECT_THAT(json["verdict"].get<std::string>(),
              HasSubstr("would change lengths at the median depth by 15 % (sigma 1 %)"));
}

TEST_F(RectifyCheckProgram, ErrorsAreOneSentence) {
  EXPECT_EQ(Run("nowhere"), 1);
  EXPECT_THAT(Text("error"), HasSubstr("nowhere"));
  EXPECT_EQ(Run("'synthetic:room?frames=4&size=376x240' --frame 9"), 1);
  EXPECT_THAT(Text("error"), HasSubstr("has 4 frames"));
}

/// The sequence with the principal point of the right camera `lower_px` further down.
void WriteSequenceWithShiftedCamera(const fs::path& sequence, double lower_px, const fs::path& folder) {
  fs::create_directories(folder / "mav0" / "cam1");
  fs::create_directory_symlink(sequence / "mav0" / "cam0", folder / "mav0" / "cam0");
  fs::create_directory_symlink(sequence / "mav0" / "cam1" / "data", folder / "mav0" / "cam1" / "data");
  fs::create_symlink(sequence / "mav0" / "cam1" / "data.csv", folder / "mav0" / "cam1" / "data.csv");
  std::ifstream original(sequence / "mav0" / "cam1" / "sensor.yaml");
  std::ofstream changed(folder / "mav0" / "cam1" / "sensor.yaml");
  for (std::string line; std::getline(original, line);) {
    const size_t last_comma = line.rfind(',', line.find(']'));
    if (line.starts_with("intrinsics:")) {
      const double cy_px = std::stod(line.substr(last_comma + 1));
      line = line.substr(0, last_comma + 1) + " " + std::to_string(cy_px + lower_px) + "]";
    }
    changed << line << "\n";
  }
}

TEST_F(RectifyCheckProgram, ARealRigAndTheSameWithAWrongCalibration) {
  PLSLAM_REQUIRE_DATA(sequence, "euroc_MH_01_a");
  ASSERT_EQ(Run(fmt::format("'{}' --json", sequence.string())), 0) << Text("out") << Text("error");
  EXPECT_LT(nlohmann::json::parse(Text("out"))["median_abs_px"].get<double>(), 0.5);
  WriteSequenceWithShiftedCamera(sequence, 4.0, folder_ / "wrong");
  ASSERT_EQ(Run("wrong --json"), 1) << Text("out") << Text("error");
  const auto json = nlohmann::json::parse(Text("out"));
  EXPECT_NEAR(json["offset_px"].get<double>(), -4.0, 0.7) << json;
  EXPECT_THAT(json["verdict"].get<std::string>(), HasSubstr("lower"));
}

}  // namespace
}  // namespace plslam::rectify_check
