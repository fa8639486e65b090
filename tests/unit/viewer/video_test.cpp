// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>

#include <filesystem>
#include <opencv2/core.hpp>

#include "tests/support/text_file.h"
#include "viewer_headless/video/run_video.h"
#include "viewer_headless/video/top_view.h"

namespace plslam::viewer {
namespace {

TEST(RunVideo, NameWithoutExtensionIsAFolder) {
  const ScratchFolder folder;
  {
    RunVideo video(folder.Path("film"), nullptr, 10.0, {64, 48});
    EXPECT_TRUE(video.is_folder());
    video.Add(cv::Mat(48, 64, CV_8UC3, cv::Scalar::all(9)));
    video.Add(cv::Mat(96, 128, CV_8UC3, cv::Scalar::all(9)));
  }
  EXPECT_TRUE(std::filesystem::exists(folder.Path("film/000000.png")));
  EXPECT_TRUE(std::filesystem::exists(folder.Path("film/000001.png")));
}

TEST(RunVideo, FolderOfPicturesIfTheEncoderIsMissing) {
  const ScratchFolder folder;
  RunVideo video(folder.Path("film.mp4"),
                 std::make_unique<FilmProcess>(folder.Path("film.mp4"), "/nowhere/plslam_film"), 10.0, {64, 48});
  EXPECT_TRUE(video.is_folder());
  EXPECT_EQ(video.path(), folder.Path("film"));
  EXPECT_EQ(video.why_folder(),
            "/nowhere/plslam_film cannot be started: No such file or directory ('scripts/build release' builds it)");
  video.Add(cv::Mat(48, 64, CV_8UC3, cv::Scalar::all(9)));
  EXPECT_TRUE(std::filesystem::exists(folder.Path("film/000000.png")));
}

// The other end of the connection is closed before any message.
TEST(RunVideo, FolderOfPicturesIfTheEncoderIsInvalid) {
  const ScratchFolder folder;
  RunVideo video(folder.Path("film.mp4"), std::make_unique<FilmProcess>(folder.Path("film.mp4"), "/bin/false"), 10.0,
                 {64, 48});
  EXPECT_TRUE(video.is_folder());
  EXPECT_THAT(video.why_folder(), testing::HasSubstr("film.mp4: no film: /bin/false ended with exit code 1"));
}

TEST(RunVideo, UnwritablePathThrows) {
  const ScratchFolder folder;
  const std::string file = folder.Write("file", "");
  EXPECT_THROW(RunVideo(file + "/film.mp4", StartFilm(file + "/film.mp4"), 10.0, {64, 48}), std::runtime_error);
  EXPECT_THROW(RunVideo(file + "/film", nullptr, 10.0, {64, 48}), std::runtime_error);
}

TEST(RunVideo, RateOfTheRecording) {
  EXPECT_DOUBLE_EQ(PictureRate_hz(0, 100'000'000, 1), 10.0);
  EXPECT_DOUBLE_EQ(PictureRate_hz(0, 0, 1), 20.0);
  EXPECT_DOUBLE_EQ(PictureRate_hz(5, 1, 1), 20.0);
  EXPECT_DOUBLE_EQ(PictureRate_hz(0, 1, 1), 120.0);
}

TEST(RunVideo, PictureAndMapFitTogether) {
  for (const cv::Size size : {cv::Size(640, 400), cv::Size(1241, 420), cv::Size(300, 300), cv::Size(200, 500)}) {
    const cv::Size map = MapSizeBeside(size);
    const cv::Mat joined = Join(cv::Mat(size, CV_8UC3), cv::Mat(map, CV_8UC3));
    EXPECT_EQ(joined.total(), cv::Mat(size, CV_8UC3).total() + cv::Mat(map, CV_8UC3).total());
  }
}

TEST(TopView, PathGoesUpAndIsVisible) {
  TopViewScene scene;
  for (int i = 0; i <= 10; ++i) scene.path.push_back({0.0, 0.0, 1.0 * i});
  TopViewWindow window;
  window.Include(scene.path);
  EXPECT_GE(window.side_m(), 13.0);
  const cv::Mat empty = DrawTopView({}, window, {200, 200});
  const cv::Mat drawn = DrawTopView(scene, window, {200, 200});
  cv::Mat difference;
  cv::absdiff(empty, drawn, difference);
  // In the middle column, above and below the centre, and nowhere far from it.
  EXPECT_GT(cv::sum(difference(cv::Rect(97, 40, 6, 60)))[0], 0.0);
  EXPECT_GT(cv::sum(difference(cv::Rect(97, 100, 6, 60)))[0], 0.0);
  EXPECT_EQ(cv::sum(difference(cv::Rect(0, 0, 60, 200)))[0], 0.0);
}

TEST(TopView, EmptyAndInvalidScene) {
  TopViewScene scene;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  scene.points = {{nan, 0, 0}, {1e300, 0, 0}, {0, 0, 0}};
  scene.path = {{nan, nan, nan}, {1e18, 0, -1e18}, {0, 0, 0}};
  scene.segments = {{{nan, 0, 0}, {1, 0, 1}}};
  TopViewWindow window;
  window.Include(scene.path);
  EXPECT_TRUE(std::isfinite(window.side_m()));
  EXPECT_EQ(DrawTopView(scene, window, {64, 64}).size(), cv::Size(64, 64));
  EXPECT_EQ(DrawTopView({}, TopViewWindow(), {64, 64}).size(), cv::Size(64, 64));
}

TEST(TopView, TheWindowHoldsTheMiddleOfTheLandmarks) {
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < 200; ++i) points.push_back({5.0 + 0.01 * i, 0, i % 20 == 0 ? 9000.0 : 10.0});
  TopViewWindow window;
  window.IncludeMiddle(points);
  EXPECT_DOUBLE_EQ(window.side_m(), 4.0) << "landmarks alone are not looked at";
  window.Include({{0, 0, 0}, {0, 0, 8}});
  window.IncludeMiddle(points);
  EXPECT_NEAR(window.centre_m().x(), 0.5 * 6.9, 0.1);
  EXPECT_DOUBLE_EQ(window.centre_m().y(), 0.5 * 10.0) << "the far ones are none of the middle";
  for (int i = 0; i < 9; ++i) window.IncludeMiddle(std::vector<Eigen::Vector3d>(100, {500, 0, 500}));
  EXPECT_LT(window.side_m(), 1.25 * 1.3 * 16.0) << "nor are those further from the path than it is large";
  const double side_m = window.side_m();
  window.IncludeMiddle({20, {1e4, 0, 1e4}});
  EXPECT_DOUBLE_EQ(window.side_m(), side_m) << "a few are no middle";
}

TEST(TopView, TheWindowNeverShrinks) {
  TopViewWindow window;
  double side_m = 0.0;
  for (int i = 0; i < 100; ++i) {
    window.Include({{std::sin(i) * i, 0, std::cos(i) * i}});
    EXPECT_GE(window.side_m(), side_m);
    side_m = window.side_m();
  }
}

}  // namespace
}  // namespace plslam::viewer
