// SPDX-License-Identifier: BSD-3-Clause
// Maps and recordings of releases (scripts/golden) open in this version as they were.
//
//   golden_test --describe FOLDER   prints their content
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <iostream>
#include <numeric>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/datasets/open_dataset.h"
#include "core/io/maps/map_file.h"
#include "core/run/node/logged_run.h"
#include "plslam_version.h"
#include "tests/support/data_folder.h"
#include "tests/support/text_file.h"

namespace plslam {
namespace {

uint64_t SumOf(const cv::Mat& image) {
  uint64_t sum = 0;
  for (int row = 0; row < image.rows; ++row) sum = std::accumulate(image.ptr(row), image.ptr(row) + image.cols, sum);
  return sum;
}

std::string DescribeMap(const std::string& path) {
  const StoredMap stored = ReadMapFile(path);
  const Map& map = stored.map;
  size_t n_observations = 0;
  for (const auto& [id, point] : map.points()) n_observations += point.observations.size();
  for (const auto& [id, line] : map.lines()) n_observations += line.observations.size();
  std::string text = fmt::format("map: {} keyframes, {} points, {} lines, {} observations, {} loops, {} sessions\n",
                                 map.keyframes().size(), map.points().size(), map.lines().size(), n_observations,
                                 map.loops().size(), stored.sessions.size());
  for (const auto& [id, keyframe] : map.keyframes()) {
    const Eigen::Vector3d& t = keyframe.T_w_kf.translation();
    text += fmt::format("keyframe {}: {} ns, at {:.6f} {:.6f} {:.6f}\n", id, keyframe.t_ns, t.x(), t.y(), t.z());
  }
  return text;
}

std::string DescribeRecording(const std::string& path) {
  const auto recording = OpenDataset(path, "");
  std::string text = fmt::format("recording: {} frames, {}x{}, f {:.6f}, baseline {:.6f}\n", recording->size(),
                                 recording->rig().left.width_px, recording->rig().left.height_px,
                                 recording->rig().left.fx_px, recording->rig().baseline_m);
  for (int i = 0; i < recording->size(); ++i) {
    const StereoImages images = recording->Read(i);
    text += fmt::format("frame {}: {} ns, sums {} {}, {}\n", i, images.t_ns, SumOf(images.left), SumOf(images.right),
                        recording->GroundTruth(i) ? "with truth" : "without truth");
  }
  return text;
}

std::string Describe(const std::filesystem::path& folder) {
  return DescribeMap((folder / "room.plmap").string()) + DescribeRecording((folder / "room.lcm").string());
}

std::vector<std::filesystem::path> Releases() {
  std::vector<std::filesystem::path> folders;
  for (const auto& entry : std::filesystem::directory_iterator(test::SourceFolder() / "tests/golden"))
    folders.push_back(entry.path());
  std::sort(folders.begin(), folders.end());
  return folders;
}

TEST(Golden, MapsAndRecordingsOfReleasesOpenUnchanged) {
  const std::vector<std::filesystem::path> releases = Releases();
  ASSERT_FALSE(releases.empty());
  for (const std::filesystem::path& folder : releases)
    EXPECT_EQ(Describe(folder), ReadText(folder / "contents.txt")) << folder;
}

// Messages between single processes may be of another version, which is reported; frames and rig may not.
TEST(Golden, OldRecordingsAreReadOrNeedAReplay) {
  for (const std::filesystem::path& folder : Releases()) {
    const ScratchFolder to;
    try {
      const LoggedRun run = ReadLoggedRun((folder / "room.lcm").string());
      WriteLoggedRun(run, to.Path("run"));
      EXPECT_TRUE(run.has_frames);
      const std::string lacks = fmt::format("{}", fmt::join(run.notes.warnings, "; "));
      EXPECT_EQ(run.map.keyframes().empty(), lacks.find("`plslam replay` recomputes them") != std::string::npos)
          << folder << ": " << lacks;
    } catch (const std::runtime_error& error) {
      EXPECT_NE(std::string(error.what()).find("`plslam replay "), std::string::npos) << error.what();
    }
  }
}

TEST(Golden, ThisReleaseHasGoldenFiles) {
  const std::string version = PLSLAM_VERSION;
  const std::string release = version.substr(0, version.rfind('.'));
  EXPECT_TRUE(std::filesystem::exists(test::SourceFolder() / "tests/golden" / release))
      << "scripts/golden " << release;
}

}  // namespace
}  // namespace plslam

int main(int argc, char** argv) {
  if (argc == 3 && std::string_view(argv[1]) == "--describe") {
    std::cout << plslam::Describe(argv[2]);
    return 0;
  }
  testing::InitGoogleTest(&argc, argv);
  return RUN_ALL_TESTS();
}
