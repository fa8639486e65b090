// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <spdlog/sinks/ostream_sink.h>
#include <spdlog/spdlog.h>

#include <filesystem>
#include <opencv2/core.hpp>
#include <sstream>

#include "tests/support/text_file.h"
#include "viewer_headless/film.h"

namespace plslam::viewer {
namespace {

/// Captures the log during its lifetime.
class CapturedLog {
 public:
  CapturedLog() : before_(spdlog::default_logger()) {
    spdlog::set_default_logger(
        std::make_shared<spdlog::logger>("film", std::make_shared<spdlog::sinks::ostream_sink_mt>(text_)));
  }
  ~CapturedLog() { spdlog::set_default_logger(before_); }
  CapturedLog(const CapturedLog&) = delete;
  CapturedLog& operator=(const CapturedLog&) = delete;

  int Count(const std::string& part) const {
    const std::string text = text_.str();
    int n = 0;
    for (size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++n;
    return n;
  }

 private:
  std::ostringstream text_;
  std::shared_ptr<spdlog::logger> before_;
};

void AddPictures(Film& film, int n) {
  const cv::Mat overlay(48, 64, CV_8UC3, cv::Scalar::all(9));
  for (int i = 0; i < n; ++i) {
    FramePose pose;
    pose.frame_id = i;
    pose.t_ns = 100'000'000LL * i;
    film.Add(pose, overlay, Map());
  }
}

TEST(FilmLog, UnwritableFilmIsReportedOnce) {
  const ScratchFolder folder;
  const CapturedLog log;
  {
    Film film(folder.Write("file", "") + "/film");
    AddPictures(film, 6);
    EXPECT_THAT([&] { film.Finish(); },
                testing::ThrowsMessage<std::runtime_error>(testing::HasSubstr("the folder cannot be created")));
  }
  EXPECT_EQ(log.Count("the folder cannot be created"), 1);
  EXPECT_EQ(log.Count("film of the run"), 0);
}

TEST(FilmLog, APictureAloneIsWrittenAtTheEnd) {
  const ScratchFolder folder;
  const CapturedLog log;
  {
    Film film(folder.Path("film"));
    AddPictures(film, 1);
    film.Finish();
  }
  EXPECT_EQ(log.Count("film (1 pictures)"), 1);
  EXPECT_TRUE(std::filesystem::exists(folder.Path("film/000000.png")));
}

TEST(Film, PicturesAreAtTheirTimesOfTheCameraRate) {
  const ScratchFolder folder;
  {
    Film film(folder.Path("film"));
    film.SetRate(10.0);
    const cv::Mat overlay(48, 64, CV_8UC3, cv::Scalar::all(9));
    FramePose pose;
    // Three frames are missing before the second one, the fourth falls into the slot of the third; then the time goes
    // back.
    for (const int64_t t_ms : {0, 400, 500, 520, 600, 100}) {
      pose.t_ns = 1'000'000 * t_ms;
      film.Add(pose, overlay, Map());
    }
    film.Finish();
  }
  std::ptrdiff_t n = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder.Path("film"))) n += entry.is_regular_file();
  EXPECT_EQ(n, 1 + 4 + 1 + 0 + 1 + 1);
}

}  // namespace
}  // namespace plslam::viewer
