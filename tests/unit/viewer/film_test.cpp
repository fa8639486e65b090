// SPDX-License-Identifier: BSD-3-Clause
// Films as files, which OpenCV's videoio reads back.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <signal.h>

#include <filesystem>
#include <opencv2/core.hpp>
#include <opencv2/videoio.hpp>

#include "tests/support/data_folder.h"
#include "tests/support/text_file.h"
#include "viewer_headless/video/run_video.h"

namespace plslam::viewer {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

std::unique_ptr<FilmProcess> Start(const std::string& file) {
  return std::make_unique<FilmProcess>(file, test::BinaryFolder() / "plslam_film");
}

/// Leaves the test where GStreamer cannot write MP4.
#define PLSLAM_REQUIRE_FILM(video) \
  if ((video).is_folder()) GTEST_SKIP() << (video).why_folder()

TEST(Film, AnMp4FileThatOpenCvReadsBack) {
  const ScratchFolder folder;
  const std::string file = folder.Path("deep/film.mp4");
  {
    RunVideo video(file, Start(file), 10.0, {161, 121});
    PLSLAM_REQUIRE_FILM(video);
    for (int i = 0; i < 12; ++i) video.Add(cv::Mat(121, 161, CV_8UC3, cv::Scalar::all(20 * i)));
    EXPECT_FALSE(std::filesystem::exists(file)) << "not before it is whole";
    EXPECT_EQ(video.pictures(), 12);
    EXPECT_EQ(video.path(), file);
    video.Close();
  }
  EXPECT_FALSE(std::filesystem::exists(folder.Path("deep/film.part.mp4")));
  cv::VideoCapture capture(file);
  ASSERT_TRUE(capture.isOpened());
  cv::Mat picture;
  int n = 0;
  for (; capture.read(picture); ++n) EXPECT_NEAR(cv::mean(picture)[1], 20 * n, 6.0) << "picture " << n;
  EXPECT_EQ(n, 12);
  EXPECT_EQ(picture.size(), cv::Size()) << "read to the end";
  EXPECT_NEAR(capture.get(cv::CAP_PROP_FPS), 10.0, 0.01);
}

TEST(Film, FilmThatCannotBeRenamedIsAnError) {
  const ScratchFolder folder;
  const std::string file = folder.Path("film.mp4");
  std::filesystem::create_directories(file);
  RunVideo video(file, Start(file), 10.0, {64, 48});
  PLSLAM_REQUIRE_FILM(video);
  video.Add(cv::Mat(48, 64, CV_8UC3, cv::Scalar::all(9)));
  EXPECT_THAT([&] { video.Close(); }, ThrowsMessage<std::runtime_error>(HasSubstr("film.mp4: cannot be renamed: ")));
  EXPECT_FALSE(std::filesystem::exists(folder.Path("film.part.mp4")));
}

TEST(Film, KilledEncoderIsReported) {
  const ScratchFolder folder;
  const std::string file = folder.Path("film.mp4");
  auto film = Start(file);
  const pid_t pid = film->pid();
  RunVideo video(file, std::move(film), 10.0, {640, 480});
  PLSLAM_REQUIRE_FILM(video);
  const cv::Mat picture(480, 640, CV_8UC3, cv::Scalar::all(9));
  video.Add(picture);
  kill(pid, SIGKILL);
  const auto add = [&] {
    // Data in the pipe are lost silently when the program dies.
    for (int i = 0; i < 10; ++i) video.Add(picture);
  };
  EXPECT_THAT(add, ThrowsMessage<std::runtime_error>(HasSubstr("film.mp4: no film: ")));
  EXPECT_THAT(add, ThrowsMessage<std::runtime_error>(HasSubstr("film.mp4: the film program has exited")));
  EXPECT_THROW(video.Close(), std::runtime_error);
  EXPECT_TRUE(std::filesystem::is_empty(folder.Path("")));
}

/// plslam_film where no file may have more than so many blocks of 512 bytes, as where a disk is full.
std::unique_ptr<FilmProcess> StartWithLimit(const ScratchFolder& folder, const std::string& file, int blocks) {
  const std::string program = folder.Write("limited", fmt::format("#!/bin/sh\nulimit -f {}\nexec {} \"$@\"\n", blocks,
                                                                  (test::BinaryFolder() / "plslam_film").string()));
  std::filesystem::permissions(program, std::filesystem::perms::owner_all);
  return std::make_unique<FilmProcess>(file, program);
}

class FilmOnAFullDisk : public testing::TestWithParam<int> {};

TEST_P(FilmOnAFullDisk, SystemErrorIsReportedAndNoFileIsLeft) {
  const ScratchFolder folder;
  const std::string file = folder.Path("film.mp4");
  const auto film = [&] {
    RunVideo video(file, StartWithLimit(folder, file, GetParam()), 10.0, {640, 480});
    cv::Mat noise(480, 640, CV_8UC3);
    cv::RNG random(1);
    // More than the encoder keeps.
    for (int i = 0; i < 120; ++i) {
      random.fill(noise, cv::RNG::UNIFORM, 0, 256);
      video.Add(noise);
    }
    video.Close();
  };
  EXPECT_THAT(film, ThrowsMessage<std::runtime_error>(HasSubstr("film.mp4: cannot be written: File too large")));
  for (const auto& entry : std::filesystem::directory_iterator(folder.Path(""))) {
    EXPECT_EQ(entry.path().filename(), "limited") << "neither a film nor pictures in its place";
  }
}

INSTANTIATE_TEST_SUITE_P(FromTheStartAndHalfway, FilmOnAFullDisk, testing::Values(0, 100));

/// As where the viewer is killed.
TEST(Film, UnfinishedFilmLeavesNoFile) {
  const ScratchFolder folder;
  const std::string file = folder.Path("film.mp4");
  {
    FilmProcess film(file, test::BinaryFolder() / "plslam_film");
    try {
      film.Begin(10.0, {64, 48});
    } catch (const std::runtime_error& e) {
      GTEST_SKIP() << e.what();
    }
    film.Add(cv::Mat(48, 64, CV_8UC3, cv::Scalar::all(9)));
  }
  EXPECT_TRUE(std::filesystem::is_empty(folder.Path("")));
}

TEST(Film, OddSizesAreRefused) {
  const ScratchFolder folder;
  FilmProcess film(folder.Path("film.mp4"), test::BinaryFolder() / "plslam_film");
  EXPECT_THAT(
      [&] {
        film.Begin(10.0, {63, 48});
      },
      ThrowsMessage<std::runtime_error>(HasSubstr("an even width and height")));
}

}  // namespace
}  // namespace plslam::viewer
