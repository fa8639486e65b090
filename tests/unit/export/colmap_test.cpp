// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>

#include <cstring>
#include <regex>
#include <sstream>

#include "core/io/maps/map_camera.h"
#include "tests/support/shell.h"
#include "tests/unit/export/small_map.h"
#include "tools/export/colmap.h"

namespace plslam::exports {
namespace {

using test::Shell;
using testing::HasSubstr;

ColmapModel SmallModel() { return ColmapOf(test::SmallStoredMap(), test::SmallCamera()); }

/// Headless, and without the log file that COLMAP otherwise leaves.
std::string Colmap(const std::string& arguments) { return "QT_QPA_PLATFORM=offscreen colmap " + arguments; }

double NumberAfter(const std::string& text, const std::string& name) {
  std::smatch match;
  const std::regex pattern(name + "\\s*:\\s*([-+.e0-9]+)");
  return std::regex_search(text, match, pattern) ? std::stod(match[1]) : -1.0;
}

/// Returns the numbers of each entry of `lines_each` lines, by the first of them; words are skipped.
std::map<int, std::vector<double>> NumbersById(const std::string& text, int lines_each) {
  std::map<int, std::vector<double>> entries;
  std::vector<double> entry;
  int lines = 0;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) {
    if (!line.empty() && line[0] == '#') continue;
    std::istringstream words(line);
    for (std::string word; words >> word;) {
      char* end = nullptr;
      const double number = std::strtod(word.c_str(), &end);
      if (*end == '\0') entry.push_back(number);
    }
    if (++lines % lines_each != 0) continue;
    entries[static_cast<int>(entry.at(0))] = entry;
    entry.clear();
  }
  return entries;
}

TEST(ColmapModel, PointsOfTwoViewsAndMoreWithoutError) {
  const ColmapModel model = SmallModel();
  ASSERT_EQ(model.images.size(), 3U);
  ASSERT_EQ(model.points.size(), 60U);
  for (const ColmapPoint& point : model.points) {
    EXPECT_EQ(point.track.size(), 3U);
    EXPECT_LT(point.error_px, 1e-9);
  }
  EXPECT_EQ(model.images[0].features.size(), 62U);
  EXPECT_EQ(model.images[0].features[59].point_id, 60);
  EXPECT_EQ(model.images[0].features[60].point_id, -1) << "seen by one keyframe alone";
  EXPECT_EQ(model.images[0].features[61].point_id, -1) << "of no landmark";
}

TEST(ColmapModel, PixelsCountFromTheCornerOfTheImage) {
  const StoredMap stored = test::SmallStoredMap();
  const Eigen::Vector2d ours = stored.features.at(1).points[7].left.px;
  EXPECT_EQ(SmallModel().images[1].features[7].px, ours + Eigen::Vector2d(0.5, 0.5));
}

TEST(ColmapModel, KeyframesWithoutFeaturesAndEmptyMaps) {
  StoredMap stored = test::SmallStoredMap();
  stored.features.clear();
  const ColmapModel model = ColmapOf(stored, test::SmallCamera());
  EXPECT_EQ(model.images.size(), 3U);
  EXPECT_TRUE(model.points.empty());
  EXPECT_TRUE(ColmapOf(StoredMap(), test::SmallCamera()).images.empty());
}

TEST(ColmapModel, FramesOfTwoSessionsWithOneNumberHaveTwoNames) {
  Map map;
  MapKeyframe keyframe;
  for (const auto& [id, session, frame] : {std::tuple{0, 0, 7}, {1, 5, 7}, {2, 5, 8}}) {
    keyframe.id = id;
    keyframe.name.session = session;
    keyframe.frame_id = frame;
    map.Put(keyframe);
  }
  EXPECT_THAT(KeyframeImageNames(map),
              testing::ElementsAre(testing::Pair(0, "000007.png"), testing::Pair(1, "000007_s5.png"),
                                   testing::Pair(2, "000008.png")));
}

TEST(ColmapText, FormatOfTheDocumentation) {
  const ScratchFolder folder;
  WriteColmapText(folder.Path("model"), SmallModel());
  EXPECT_THAT(ReadText(folder.Path("model/cameras.txt")), HasSubstr("\n1 PINHOLE 640 480 400 400 320.5 240.5\n"));
  EXPECT_THAT(ReadText(folder.Path("model/images.txt")), HasSubstr("\n1 1 0 0 0 0 0 0 1 000000.png\n"));
  EXPECT_THAT(ReadText(folder.Path("model/points3D.txt")), HasSubstr(" 1 59 2 59 3 59\n"));
}

TEST(ColmapPrograms, ModelAnalyzerCountsTheModel) {
  PLSLAM_REQUIRE_PROGRAM("colmap");
  const ScratchFolder folder;
  WriteColmapText(folder.Path("text"), SmallModel());
  WriteColmapBinary(folder.Path("binary"), SmallModel());
  for (const char* kind : {"text", "binary"}) {
    const auto result = Shell(folder, Colmap("model_analyzer --path " + folder.Path(kind)));
    const std::string output = result.out + result.error;
    EXPECT_EQ(result.exit_code, 0) << kind << ": " << output;
    EXPECT_EQ(NumberAfter(output, "Registered images"), 3) << output;
    EXPECT_EQ(NumberAfter(output, "Points"), 60) << output;
    EXPECT_EQ(NumberAfter(output, "Observations"), 180) << output;
    EXPECT_EQ(NumberAfter(output, "Mean track length"), 3) << output;
  }
}

TEST(ColmapPrograms, ColmapProjectsTheMapOntoTheFeatures) {
  PLSLAM_REQUIRE_PROGRAM("colmap");
  const ScratchFolder folder;
  WriteColmapBinary(folder.Path("binary"), SmallModel());
  std::filesystem::create_directories(folder.Path("adjusted"));
  const auto result = Shell(folder, Colmap("bundle_adjuster --input_path " + folder.Path("binary") +
                                           " --output_path " + folder.Path("adjusted")));
  const std::string output = result.out + result.error;
  const double initial_px = NumberAfter(output, "Initial cost");
  EXPECT_GE(initial_px, 0.0) << output;
  EXPECT_LT(initial_px, 1e-6) << output;
}

TEST(ColmapPrograms, ColmapConvertsOurBinaryToOurText) {
  PLSLAM_REQUIRE_PROGRAM("colmap");
  const ScratchFolder folder;
  WriteColmapText(folder.Path("text"), SmallModel());
  WriteColmapBinary(folder.Path("binary"), SmallModel());
  std::filesystem::create_directories(folder.Path("turned"));
  const auto result = Shell(folder, Colmap("model_converter --output_type TXT --input_path " + folder.Path("binary") +
                                           " --output_path " + folder.Path("turned")));
  ASSERT_EQ(result.exit_code, 0) << result.out << result.error;
  for (const auto& [file, lines_each] : {std::pair{"cameras.txt", 1}, {"images.txt", 2}, {"points3D.txt", 1}}) {
    const auto ours = NumbersById(ReadText(folder.Path("text/") + file), lines_each);
    const auto theirs = NumbersById(ReadText(folder.Path("turned/") + file), lines_each);
    ASSERT_EQ(ours.size(), theirs.size()) << file;
    for (const auto& [id, numbers] : ours) {
      EXPECT_THAT(theirs.at(id), testing::Pointwise(testing::DoubleNear(1e-9), numbers)) << file << " " << id;
    }
  }
}

TEST(MapCamera, StoredCameraIsRead) {
  const StereoCamera camera = MapCamera(test::SmallStoredMap(), "a.plmap");
  EXPECT_EQ(camera.f_px, 400.0);
  EXPECT_EQ(camera.cx_px, 320.0);
  EXPECT_EQ(camera.cy_px, 240.0);
  EXPECT_EQ(camera.baseline_m, 0.12);
  EXPECT_EQ(camera.width_px, 640);
  EXPECT_EQ(camera.height_px, 480);
}

TEST(MapCamera, WrittenWithFewerDigitsIsTheSame) {
  const StereoCamera exact{458.65412345678, 367.21512345678, 248.37512345678, 0.110073808127187, 752, 480};
  const StereoCamera rounded{458.65412, 367.21512, 248.37512, 0.11007381, 752, 480};
  EXPECT_EQ(CameraDifference(exact, exact), "");
  EXPECT_EQ(CameraDifference(exact, rounded), "");
  EXPECT_EQ(CameraDifference(rounded, exact), "");
}

TEST(MapCamera, DifferencesShowDifferingDigits) {
  const StereoCamera camera{400.0, 320.0, 240.0, 0.12, 640, 480};
  StereoCamera other = camera;
  other.f_px = 400.0002;
  EXPECT_EQ(CameraDifference(camera, other), "f_px 400.0002 instead of 400");
  other = camera;
  other.cy_px = 239.9998;
  other.width_px = 641;
  EXPECT_EQ(CameraDifference(camera, other), "cy_px 239.9998 instead of 240, width_px 641 instead of 640");
  other = camera;
  // 2e-4 px at a disparity of 100 px.
  other.baseline_m = 0.12 * (1.0 + 2e-6);
  EXPECT_THAT(CameraDifference(camera, other), HasSubstr("baseline_m 0.12000024"));
}

TEST(MapCamera, InvalidCameraIsReported) {
  StoredMap stored = test::SmallStoredMap();
  const auto error = [&] {
    try {
      MapCamera(stored, "a.plmap");
    } catch (const std::runtime_error& e) {
      return std::string(e.what());
    }
    return std::string("nothing");
  };
  const auto set = [&](size_t number, double value) { std::memcpy(stored.rig.data() + 8 * number, &value, 8); };
  set(0, 0.0);
  EXPECT_EQ(
      error(),
      "a.plmap: its camera is invalid: a focal length of 0 px, a baseline of 0.12 m and images of 640 x 480 px");
  set(0, 400.0);
  set(4, 640.5);
  EXPECT_THAT(error(), HasSubstr("640.5 x 480 px"));
  set(3, std::nan(""));
  EXPECT_THAT(error(), HasSubstr("has a number nan"));
  stored.rig.clear();
  EXPECT_EQ(error(), "a.plmap: does not contain the camera with which it was made");
}

}  // namespace
}  // namespace plslam::exports
