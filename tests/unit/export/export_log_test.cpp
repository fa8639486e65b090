// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>

#include <filesystem>
#include <map>

#include "core/bus/channels.h"
#include "core/bus/logs/log_writer.h"
#include "core/bus/messages/convert.h"
#include "core/bus/messages/map_pages.h"
#include "core/bus/transport/wire.h"
#include "core/run/node/logged_run.h"
#include "plslam/camera_t.hpp"
#include "plslam/image_strip_t.hpp"
#include "plslam/pose_t.hpp"
#include "plslam/stream_t.hpp"
#include "tests/support/text_file.h"
#include "tests/unit/export/small_map.h"
#include "tools/export/export_run.h"

namespace plslam::exports {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr int kWidth = 160;
constexpr int kHeight = 120;

int64_t Time(int64_t frame) { return 1'000'000'000 * (frame + 1); }

RigCalibration Rig() {
  RigCalibration rig;
  rig.name = "small";
  rig.rate_hz = 20.0;
  rig.left.width_px = kWidth;
  rig.left.height_px = kHeight;
  rig.left.fx_px = rig.left.fy_px = 100.0;
  rig.right = rig.left;
  rig.baseline_m = 0.1;
  rig.right.T_b_cam = SE3(Eigen::Quaterniond::Identity(), {0.1, 0.0, 0.0});
  return rig;
}

/// A log that is written message by message.
class ExportLog : public testing::Test {
 protected:
  ExportLog() : writer_(path_) {}

  template <class Message>
  void Write(const std::string& prefix, const bus::Channel& channel, Message message, int64_t source = 1) {
    const std::string name = prefix + std::string(channel.name);
    message.header.schema = bus::kSchemaVersion;
    message.header.source = source;
    message.header.seq = numbers_[{name, source}]++;
    writer_.Write(name, bus::Encoded(message), ++time_us_);
  }
  void WriteCamera(const std::string& prefix) { Write(prefix, bus::kCamera, bus::ToMessage(Rig())); }
  void WritePoses(const std::string& prefix, int n) {
    for (int64_t frame = 0; frame < n; ++frame) {
      pose_t pose{};
      pose.header.t_ns = Time(frame);
      pose.frame_id = frame;
      pose.state = 1;
      pose.T_odom_c = pose.T_w_odom = pose.T_prev_c = bus::ToMessage(SE3());
      pose.keyframe_id = -1;
      Write(prefix, bus::kPose, pose);
    }
  }
  void WriteFrame(const std::string& prefix, int64_t frame) {
    for (int8_t camera = 0; camera < 2; ++camera) {
      image_strip_t strip{};
      strip.header.t_ns = Time(frame);
      strip.frame_id = frame;
      strip.camera = camera;
      strip.n_strips = 1;
      strip.width_px = kWidth;
      strip.height_px = kHeight;
      strip.encoding = "mono8";
      strip.n_bytes = kWidth * kHeight;
      strip.data.resize(kWidth * kHeight);
      Write(prefix, bus::kStereoFrame, strip);
    }
  }
  void WriteStream(const std::string& event, int64_t source) {
    stream_t stream{};
    stream.event = event;
    Write("", bus::kStream, stream, source);
  }
  /// Without so many pages at its end.
  void WriteMap(const std::string& prefix, size_t missing_pages = 0) {
    MapUpdate update = WholeMap(test::SmallStoredMap().map);
    update.version = 1;
    const auto pages = bus::CutIntoPages(update, 4000);
    ASSERT_GT(pages.size(), missing_pages);
    for (size_t i = 0; i + missing_pages < pages.size(); ++i) Write(prefix, bus::kMapUpdate, pages[i]);
  }
  LoggedRun Read() {
    writer_.Flush();
    return ReadLoggedRun(path_);
  }
  std::vector<ExportedFile> Export(const std::string& format) {
    writer_.Flush();
    return ExportRun({path_, folder_.Path("out"), {format}, ""});
  }
  std::string ErrorOf(const std::string& format) {
    try {
      Export(format);
    } catch (const std::runtime_error& error) {
      return error.what();
    }
    return "none";
  }
  const ScratchFolder& folder() const { return folder_; }

 private:
  ScratchFolder folder_;
  std::string path_ = folder_.Path("a.lcm");
  bus::LogWriter writer_;
  std::map<std::pair<std::string, int64_t>, int64_t> numbers_;
  int64_t time_us_ = 0;
};

TEST_F(ExportLog, ImagesAreOfTheRobotWithPoses) {
  for (const char* prefix : {"a/", "b/"}) WriteCamera(prefix);
  WritePoses("a/", 3);
  for (int64_t frame = 10; frame < 14; ++frame) WriteFrame("b/", frame);
  EXPECT_FALSE(Read().has_frames);
  WriteFrame("a/", 1);
  const LoggedRun run = Read();
  EXPECT_EQ(run.prefix, "a/");
  EXPECT_TRUE(run.has_frames);
  EXPECT_THAT(Export("mcap").at(1).what, HasSubstr("3 frames, 1 images"));
}

TEST_F(ExportLog, MapThatRobotsShareHasAPrefixOfItsOwn) {
  WriteCamera("a/");
  WritePoses("a/", 3);
  WriteMap("team/");
  EXPECT_EQ(Read().map.keyframes().size(), 3U);
  EXPECT_THAT(Read().notes.warnings, IsEmpty());
  WriteMap("others/");
  EXPECT_TRUE(Read().map.keyframes().empty());
  EXPECT_THAT(Read().notes.warnings, ElementsAre("none of the 2 maps in the log has the prefix of the run"));
  WriteMap("a/");
  EXPECT_EQ(Read().map.keyframes().size(), 3U);
}

TEST_F(ExportLog, LastOfSeveralStreamsIsExported) {
  WriteCamera("");
  WriteStream("begin", 1);
  WritePoses("", 6);
  WriteStream("begin", 2);
  WritePoses("", 4);
  WriteStream("begin", 1);  // said again
  WriteStream("resume", 3);
  EXPECT_EQ(Read().recorder.frames().size(), 4U);
}

TEST_F(ExportLog, LastRigThatCanBeUsedCounts) {
  WritePoses("", 2);
  camera_t bad = bus::ToMessage(Rig());
  bad.right.width_px = kWidth / 2;
  Write("", bus::kCamera, bad);
  EXPECT_THAT(ErrorOf("tum"), HasSubstr("a.lcm: has poses, but its rig 'small' cannot be used: "));
  WriteCamera("");
  Write("", bus::kCamera, bad);
  EXPECT_EQ(Read().recorder.frames().size(), 2U);
}

TEST_F(ExportLog, RigOfAnotherVersionIsReported) {
  WritePoses("", 2);
  Write("", bus::kCamera, stream_t{});
  EXPECT_THAT(ErrorOf("tum"), HasSubstr("has poses, but its rig (channel CAMERA) is from another version"));
  WriteCamera("");
  EXPECT_THAT(Read().notes.warnings, ElementsAre("messages from another version of plslam are skipped, on CAMERA"))
      << "nothing to replay";
}

TEST_F(ExportLog, IncompleteMapIsReported) {
  WriteCamera("");
  WritePoses("", 2);
  WriteMap("", 1);
  EXPECT_THAT(Read().notes.warnings, ElementsAre(HasSubstr("changes of the map are missing")));
}

TEST_F(ExportLog, ExistingFilesStayAndFailuresLeaveNone) {
  WriteCamera("");
  WritePoses("", 3);
  EXPECT_THAT(ErrorOf("colmap"), HasSubstr("colmap needs a saved map"));
  EXPECT_FALSE(std::filesystem::exists(folder().Path("out")));
  std::filesystem::create_directories(folder().Path("out/run"));
  EXPECT_EQ(Export("tum").size(), 2U) << "an empty folder";
  EXPECT_THAT(ErrorOf("tum"), HasSubstr("out/run: already exists, and the files of the run would be written there"));
}

}  // namespace
}  // namespace plslam::exports
