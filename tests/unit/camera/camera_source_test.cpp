// SPDX-License-Identifier: BSD-3-Clause
#include "camera/camera_source.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <iostream>
#include <thread>
#include <vector>

#include "core/bus/transport/wall_clock.h"
#include "core/io/images/png_codec.h"
#include "tests/support/text_file.h"
#include "tests/unit/camera/gst_elements.h"

namespace plslam::camera {
namespace {

using stream::LoadedFrame;
using testing::HasSubstr;
using testing::ThrowsMessage;

constexpr const char* kToSinks =
    "! tee name=both both. ! queue ! appsink name=left both. ! queue ! appsink name=right";

std::string TestPicture(const std::string& properties, int rate_hz = 30) {
  return fmt::format("videotestsrc {} ! video/x-raw,format=GRAY8,width=64,height=48,framerate={}/1", properties,
                     rate_hz);
}

std::vector<uint8_t> Bytes(const cv::Mat& image) { return {image.datastart, image.dataend}; }

struct Heard {
  int64_t outages = 0;
  int64_t returns = 0;
  double rate_hz = 0.0;
  double skew_ms = 0.0;
};

/// A source of 64x48 pixels, and its reports.
class CameraSourceTest : public testing::Test {
 protected:
  CameraSource Open(const std::string& pipeline, double give_up_s = 10.0, bool resumes = false) {
    LiveRig live;
    live.path = "rig.yaml";
    for (CameraCalibration* camera : {&live.rig.left, &live.rig.right}) {
      camera->width_px = 64;
      camera->height_px = 48;
    }
    live.rig.rate_hz = 30.0;
    live.source.type = SourceSpec::Type::kPipeline;
    live.source.inputs = {pipeline};
    live.source.give_up_s = give_up_s;
    CameraSource::Listener listener;
    listener.on_frame = [this](const CaptureHealth& health, const Pairing&) {
      heard_.rate_hz = health.rate_hz();
      heard_.skew_ms = health.skew_ms();
    };
    listener.on_outage = [this](const std::string& why) { ++(why.empty() ? heard_.returns : heard_.outages); };
    return {live, resumes, listener};
  }

  static std::vector<LoadedFrame> All(CameraSource* source, size_t most = 1000) {
    std::vector<LoadedFrame> frames;
    while (frames.size() < most) {
      auto frame = source->Next();
      if (!frame) break;
      frames.push_back(std::move(*frame));
    }
    return frames;
  }

  static auto Opening(const std::function<CameraSource()>& open) {
    return [open] { open(); };
  }

  Heard heard_;
};

TEST_F(CameraSourceTest, FilesEndAndCanBeReadAgainFromAnywhere) {
  PLSLAM_REQUIRE_ELEMENTS("videotestsrc");
  CameraSource source = Open(TestPicture("num-buffers=10 pattern=ball", 20) + kToSinks);
  EXPECT_FALSE(source.is_live());
  source.Begin(std::nullopt);
  const auto frames = All(&source);
  ASSERT_EQ(frames.size(), 10U);
  for (size_t i = 0; i < frames.size(); ++i) EXPECT_EQ(frames[i].images.t_ns, static_cast<int64_t>(i) * 50'000'000);
  source.Begin(stream::ResumePoint{6, frames[6].images.t_ns});
  const auto rest = All(&source);
  ASSERT_EQ(rest.size(), 3U);
  for (size_t i = 0; i < rest.size(); ++i) {
    EXPECT_EQ(rest[i].images.t_ns, frames[7 + i].images.t_ns);
    EXPECT_EQ(Bytes(rest[i].images.left), Bytes(frames[7 + i].images.left));
  }
}

TEST_F(CameraSourceTest, UnequalLengthsEndWithTheShorterOne) {
  PLSLAM_REQUIRE_ELEMENTS("videotestsrc");
  CameraSource source = Open(TestPicture("num-buffers=30") + "! appsink name=left " + TestPicture("num-buffers=7") +
                             "! appsink name=right");
  source.Begin(std::nullopt);
  EXPECT_EQ(All(&source).size(), 7U);
}

TEST_F(CameraSourceTest, LiveFramesHaveWallClockTimesAtTheirRate) {
  PLSLAM_REQUIRE_ELEMENTS("videotestsrc");
  CameraSource source = Open(TestPicture("is-live=true num-buffers=60") + kToSinks);
  EXPECT_TRUE(source.is_live());
  const int64_t before_ns = 1000 * bus::WallClock_us();
  source.Begin(std::nullopt);
  const auto frames = All(&source);
  const int64_t after_ns = 1000 * bus::WallClock_us();
  ASSERT_GE(frames.size(), 55U);
  EXPECT_GE(frames.front().images.t_ns, before_ns - 1'000'000);
  EXPECT_LE(frames.back().images.t_ns, after_ns);
  EXPECT_NEAR(heard_.rate_hz, 30.0, 3.0);
  EXPECT_EQ(heard_.skew_ms, 0.0);
}

TEST_F(CameraSourceTest, FailedPipelineIsRebuiltAndTimesIncrease) {
  PLSLAM_REQUIRE_ELEMENTS("videotestsrc", "identity");
  CameraSource source = Open(TestPicture("is-live=true") + "! identity error-after=10 " + kToSinks);
  source.Begin(std::nullopt);
  const auto frames = All(&source, 30);
  ASSERT_EQ(frames.size(), 30U);
  for (size_t i = 1; i < frames.size(); ++i) EXPECT_GT(frames[i].images.t_ns, frames[i - 1].images.t_ns);
  EXPECT_GE(heard_.outages, 2);
  EXPECT_EQ(heard_.returns, heard_.outages);
}

TEST_F(CameraSourceTest, CamerasThatDoNotReturnAreGivenUp) {
  PLSLAM_REQUIRE_ELEMENTS("pngdec", "imagefreeze", "identity");
  const ScratchFolder folder;
  const std::string file = folder.Path("a.png");
  WritePng(file, cv::Mat(48, 64, CV_8UC1, cv::Scalar(90)), 1);
  CameraSource source = Open(fmt::format("filesrc location={} ! pngdec ! imagefreeze is-live=true ! videoconvert ! "
                                         "video/x-raw,format=GRAY8,framerate=30/1 ! identity error-after=10 {}",
                                         file, kToSinks),
                             1.0);
  source.Begin(std::nullopt);
  ASSERT_TRUE(source.Next());
  std::filesystem::remove(file);
  EXPECT_THAT([&] { All(&source); }, ThrowsMessage<std::runtime_error>(
                                         testing::AllOf(HasSubstr("rig.yaml: source.pipeline: no frames for "),
                                                        HasSubstr("(source.give_up_s = 1)"), HasSubstr("a.png"))));
}

TEST_F(CameraSourceTest, InvalidPipelinesAreReportedAtTheStart) {
  PLSLAM_REQUIRE_ELEMENTS("videotestsrc");
  const std::pair<std::string, const char*> cases[] = {
      {"videotestsrc ! nosuchelement ! appsink name=left",
       "rig.yaml: source.pipeline: the pipeline cannot be built: no element \"nosuchelement\""},
      {"videotestsrc ! appsink name=left", "has no `appsink name=right`"},
      {"videotestsrc", "must end in two appsinks"},
      {std::string("filesrc location=/nowhere.mkv ! decodebin ! videoconvert ") + kToSinks, "No such file"},
      {std::string("videotestsrc ! video/x-raw,format=RGB ") + kToSinks,
       "; is `videoconvert ! video/x-raw,format=GRAY8` before each appsink"},
  };
  for (const auto& [pipeline, sentence] : cases) {
    EXPECT_THAT([&] { Open(pipeline); }, ThrowsMessage<std::runtime_error>(HasSubstr(sentence))) << pipeline;
  }
}

TEST_F(CameraSourceTest, SizesThatDoNotFitAreNamed) {
  PLSLAM_REQUIRE_ELEMENTS("videotestsrc");
  CameraSource source = Open(std::string("videotestsrc ! video/x-raw,format=GRAY8,width=80,height=48 ") + kToSinks);
  source.Begin(std::nullopt);
  EXPECT_THAT([&] { source.Next(); }, ThrowsMessage<std::runtime_error>(HasSubstr("t images have 80x48 pixels")));
}

TEST_F(CameraSourceTest, StreamWithoutAPairIsAnError) {
  PLSLAM_REQUIRE_ELEMENTS("videotestsrc");
  CameraSource source = Open(TestPicture("num-buffers=20") + "! appsink name=left " +
                             TestPicture("num-buffers=20 timestamp-offset=9000000") + "! appsink name=right");
  source.Begin(std::nullopt);
  EXPECT_THAT([&] { source.Next(); },
              ThrowsMessage<std::runtime_error>(HasSubstr("further apart than source.max_skew_ms = 5")));
}

TEST_F(CameraSourceTest, StopEndsTheWaitForFrames) {
  PLSLAM_REQUIRE_ELEMENTS("videotestsrc");
  CameraSource source = Open(TestPicture("is-live=true", 1) + kToSinks);
  source.Begin(std::nullopt);
  std::thread stopper([&] { source.Stop(); });
  All(&source);
  stopper.join();
  EXPECT_FALSE(source.Next());
}

double Memory_mb() {
  std::ifstream file("/proc/self/statm");
  double size = 0.0, resident = 0.0;
  file >> size >> resident;
  return resident * static_cast<double>(sysconf(_SC_PAGESIZE)) / 1e6;
}

TEST_F(CameraSourceTest, MemoryDoesNotGrowWithTheFrames) {
  PLSLAM_REQUIRE_ELEMENTS("videotestsrc");
  CameraSource source = Open(TestPicture("num-buffers=4000") + kToSinks);
  source.Begin(std::nullopt);
  for (int i = 0; i < 1000; ++i) ASSERT_TRUE(source.Next());
  const double before_mb = Memory_mb();
  for (int i = 0; i < 3000; ++i) ASSERT_TRUE(source.Next());
  std::cout << "memory grew by " << Memory_mb() - before_mb << " MB in 3000 frames\n";
  EXPECT_LT(Memory_mb() - before_mb, 4.0) << "3000 pairs have 18 MB";
}

}  // namespace
}  // namespace plslam::camera
