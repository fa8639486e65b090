// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <opencv2/core.hpp>
#include <regex>

#include "core/datasets/open_dataset.h"
#include "core/io/images/image_file.h"
#include "tests/integration/image_folder_of.h"
#include "tests/integration/whole_run.h"
#include "tests/support/data_folder.h"
#include "tests/support/shell.h"

namespace plslam::test {
namespace {

using testing::AllOf;
using testing::HasSubstr;

constexpr const char* kWorld = "synthetic:room?frames=40&size=376x240";

std::string Program(const std::string& name) { return (BinaryFolder() / name).string(); }

std::string Quoted(const std::filesystem::path& path) { return fmt::format("'{}'", path.string()); }

/// A short run that left its map in its folder.
class RunWithMap {
 public:
  RunWithMap() { exit_code_ = run_.Run({"run", kWorld, "--save-map", (run_.out() / "map.plmap").string()}); }

  bool ok() const { return exit_code_ == 0 && std::filesystem::exists(run_.out() / "map.plmap"); }
  const WholeRun& run() const { return run_; }
  std::filesystem::path out() const { return run_.out(); }

 private:
  WholeRun run_;
  int exit_code_ = -1;
};

TEST(ExportOfARun, OpensInColmapWithTheMappingError) {
  PLSLAM_REQUIRE_PROGRAM("colmap");
  const RunWithMap made;
  ASSERT_TRUE(made.ok()) << made.run().Logs();
  const ScratchFolder folder;
  const std::string source = Quoted(made.out());
  const auto exported = Shell(folder, fmt::format("{} export {} --dataset '{}' --out {}", Program("plslam"), source,
                                                  kWorld, folder.Path("to")));
  ASSERT_EQ(exported.exit_code, 0) << exported.error;
  const auto keyframes = made.run().Summary()["map"]["keyframes"].get<int>();
  EXPECT_THAT(exported.out, HasSubstr(fmt::format("{0} of {0} rectified images", keyframes)));
  std::filesystem::create_directories(folder.Path("adjusted"));
  const auto adjusted = Shell(folder, fmt::format("QT_QPA_PLATFORM=offscreen colmap bundle_adjuster --input_path {} "
                                                  "--output_path {} --BundleAdjustment.max_num_iterations 1",
                                                  folder.Path("to/colmap/sparse"), folder.Path("adjusted")));
  const std::string output = adjusted.out + adjusted.error;
  std::smatch cost;
  ASSERT_TRUE(std::regex_search(output, cost, std::regex(R"(Initial cost : ([0-9.e+-]+) \[px\])"))) << output;
  EXPECT_GT(std::stod(cost[1]), 0.01) << output;
  EXPECT_LT(std::stod(cost[1]), 1.0) << output;
}

TEST(FiguresOfARun, AllFiguresAsPictureAndDrawing) {
  const RunWithMap made;
  ASSERT_TRUE(made.ok()) << made.run().Logs();
  const ScratchFolder folder;
  const std::string vocabularies =
      fmt::format("--points {} --lines {}", Quoted(SourceFolder() / "config/orb.vocabulary"),
                  Quoted(SourceFolder() / "config/lbd.vocabulary"));
  const std::string figures = fmt::format("{} figures {}", Program("evaluate"), Quoted(made.out()));
  const auto drawn = Shell(folder, fmt::format("{} {} --out {}", figures, vocabularies, folder.Path("figures")));
  ASSERT_EQ(drawn.exit_code, 0) << drawn.error;
  for (const char* name : {"top_view", "covisibility", "similarity", "keyframe_pair", "runtime"}) {
    const std::string stem = folder.Path(std::string("figures/") + name);
    ASSERT_TRUE(std::filesystem::exists(stem + ".svg")) << name << "\n" << drawn.out;
    EXPECT_THAT(ReadText(stem + ".svg"), AllOf(HasSubstr("<svg "), HasSubstr("</svg>")));
    EXPECT_THAT(ReadText(stem + ".pdf"), AllOf(HasSubstr("%PDF-"), HasSubstr("%%EOF")));
    const cv::Mat picture = ReadGreyImage(stem + ".png");
    ASSERT_EQ(picture.cols, 2100) << name;
    EXPECT_GT(cv::countNonZero(picture < 200), 7000) << name;
  }
  const auto again = Shell(folder, fmt::format("{} --points none --dataset {}", figures, folder.Path("none")));
  EXPECT_EQ(again.exit_code, 0) << again.error;
  EXPECT_THAT(again.out,
              AllOf(HasSubstr("similarity: skipped: the vocabularies none"), HasSubstr("keyframe_pair: skipped: ")));
}

TEST(ComparisonOfRuns, FromTheirFoldersToAPage) {
  WholeRun points, both;
  ASSERT_EQ(points.Run({"run", kWorld, "--features", "points"}), 0) << points.Logs();
  ASSERT_EQ(both.Run({"run", kWorld}), 0) << both.Logs();
  const ScratchFolder folder;
  const std::string compare =
      fmt::format("{} compare {} {}", Program("evaluate"), Quoted(points.out()), Quoted(both.out()));
  const auto text = Shell(folder, compare + " --html " + folder.Path("page.html"));
  ASSERT_EQ(text.exit_code, 0) << text.error;
  EXPECT_THAT(text.out, AllOf(HasSubstr("\n  features=points, 1 run\n"), HasSubstr("\n  features=both, 1 run\n")));
  EXPECT_THAT(ReadText(folder.Path("page.html")),
              AllOf(HasSubstr("aria-label=\"trajectories\""), HasSubstr("aria-label=\"ate_m\"")));
  const auto converted = Shell(folder, compare + " --format kitti --out " + folder.Path("kitti"));
  ASSERT_EQ(converted.exit_code, 0) << converted.error;
  EXPECT_THAT(converted.out, AllOf(HasSubstr("/out.kitti: 40 poses"), HasSubstr("/out_2.kitti: 40 poses")));
  const auto missing = Shell(folder, compare + " " + folder.Path("none"));
  EXPECT_EQ(missing.exit_code, 1);
  EXPECT_THAT(missing.error, HasSubstr("none: does not exist"));
  const auto twice = Shell(folder, compare + " " + Quoted(both.out()));
  EXPECT_EQ(twice.exit_code, 1);
  EXPECT_THAT(twice.error, HasSubstr("is given twice; a run counts once"));
}

TEST(PaperTables, PaperAndOwnNumbersAndAbsentSequences) {
  PLSLAM_REQUIRE_PROGRAM("python3");
  const ScratchFolder folder;
  const auto dataset = OpenDataset("synthetic:room?frames=30&size=376x240", "");
  std::vector<ChosenFrame> frames;
  for (int i = 0; i < dataset->size(); ++i) frames.push_back({i, false});
  WriteImageFolder(*dataset, frames, folder.Path("root/lt-easy"));
  const auto made = Shell(folder, fmt::format("PLSLAM_BIN={} {} {}", Quoted(BinaryFolder()),
                                              Quoted(SourceFolder() / "scripts/paper_tables"), folder.Path("root")));
  ASSERT_EQ(made.exit_code, 0) << made.error;
  // P-SLAM of the paper failed; ours has numbers, and where a room has too few lines L-SLAM may fail.
  EXPECT_TRUE(std::regex_search(
      made.out, std::regex(R"(\nlt-easy +- / 0\.\d{4} +0\.1412 / \S+ +0\.1243 / 0\.\d{4} +0\.1391 +lt-easy\n)")))
      << made.out << made.error;
  EXPECT_THAT(made.out, HasSubstr("\nlt-medium "));
  EXPECT_TRUE(std::regex_search(
      made.out, std::regex(R"(\n03 +3\.68 +2\.96 +6\.33 +19\.17 +3\.40 +3\.17 +3\.31 +5\.52 +absent\n)")))
      << made.out;
  EXPECT_TRUE(std::regex_search(made.out, std::regex(R"(\nVO\n +P-SLAM +12\.2 ms +8\.7 ms +8\.1 / \d+\.\d ms\n)")))
      << made.out;
  EXPECT_TRUE(std::regex_search(made.out, std::regex(R"(\nsequences +absent +absent +1 present\n)"))) << made.out;
}

}  // namespace
}  // namespace plslam::test
