// SPDX-License-Identifier: BSD-3-Clause
#include "viewer_headless/node/picture_node.h"

#include <gmock/gmock.h>

#include <filesystem>

#include "core/run/run_writer.h"
#include "plslam/tracks_t.hpp"
#include "tests/support/text_file.h"
#include "tests/unit/viewer/some_rig.h"

namespace plslam::viewer {
namespace {

FramePose PoseOf(FrameId frame_id) {
  FramePose pose;
  pose.frame_id = frame_id;
  pose.state = TrackingState::kTracking;
  return pose;
}

TEST(PictureNode, SecondStreamAfterMissingPictures) {
  const ScratchFolder folder;
  PrepareOutputFolder(folder.Path("overlays"));
  bus::BusOptions options;
  options.url = "memq://";
  bus::Bus bus(options, "viewer");
  PictureNode pictures(
      bus, {.out = folder.Path(""), .overlay_every = 1, .video = ""}, {}, [] {}, [] {});
  const RigCalibration rig = SomeRig();
  pictures.SetCamera(rig, Rectify(rig));
  // Frames whose images never arrived.
  for (int64_t frame = 100; frame < 120; ++frame) pictures.AddPose(PoseOf(FrameId(frame)));
  pictures.StartNewRun(nullptr);
  pictures.AddPose(PoseOf(0));
  const cv::Mat image(240, 320, CV_8UC1, cv::Scalar(90));
  bus::FramePublisher(bus, true).Publish({0, 0, image, image});
  bus.Publish(bus::kTracks, tracks_t{});
  const std::string file = folder.Path("overlays/000000.png");
  bus.Every(std::chrono::milliseconds(5), [&] {
    if (std::filesystem::exists(file)) bus.Stop();
  });
  // A test that fails must not hang.
  bus.Every(std::chrono::seconds(10), [&] { bus.Stop(); });
  bus.Run();
  EXPECT_TRUE(std::filesystem::exists(file));
}

/// Returns the report's picture of a frame with that right image.
ReportPicture PictureWith(const cv::Mat& right) {
  bus::BusOptions options;
  options.url = "memq://";
  bus::Bus bus(options, "viewer");
  PictureStore store(10);
  PictureNode pictures(
      bus, {.out = "", .report_pictures = 10, .video = ""}, {nullptr, &store}, [] {}, [&] { bus.Stop(); });
  const RigCalibration rig = SomeRig();
  pictures.SetCamera(rig, Rectify(rig));
  pictures.AddPose(PoseOf(0));
  bus::FramePublisher(bus, true).Publish({0, 0, cv::Mat(240, 320, CV_8UC1, cv::Scalar(90)), right});
  bus.Publish(bus::kTracks, tracks_t{});
  // A test that fails must not hang.
  bus.Every(std::chrono::seconds(10), [&] { bus.Stop(); });
  bus.Run();
  return store.pictures().empty() ? ReportPicture() : store.pictures().at(0);
}

TEST(PictureNode, TheReportHasTheRightImageOfStereo) {
  const ReportPicture picture = PictureWith(cv::Mat(240, 320, CV_8UC1, cv::Scalar(160)));
  EXPECT_FALSE(picture.jpeg.empty());
  EXPECT_FALSE(picture.right_jpeg.empty());
}

TEST(PictureNode, ADepthMapIsNoRightImage) {
  const ReportPicture picture = PictureWith(cv::Mat(240, 320, CV_16UC1, cv::Scalar(5000)));
  EXPECT_FALSE(picture.jpeg.empty());
  EXPECT_TRUE(picture.right_jpeg.empty());
}

/// Returns the result for frames whose pictures never arrive, except for those that are already in `overlays/`.
PictureNode::Result ResultWithoutPictures(const ScratchFolder& folder, bool lockstep, bool ended) {
  PrepareOutputFolder(folder.Path("overlays"));
  bus::BusOptions options;
  options.url = "memq://";
  bus::Bus bus(options, "viewer");
  const Map map;
  PictureNode pictures(
      bus, {.out = folder.Path(""), .overlay_every = 5, .video = folder.Path("film")}, {&map, nullptr}, [] {}, [] {});
  Recorder recorder;
  for (int64_t frame = 0; frame < 20; ++frame) {
    recorder.AddPose(PoseOf(FrameId(frame)));
    pictures.AddPose(PoseOf(FrameId(frame)));
  }
  EXPECT_TRUE(pictures.MayCome());
  return pictures.Finish(recorder, lockstep, ended);
}

TEST(PictureNode, MissingPicturesInLockstepAreReported) {
  const ScratchFolder folder;
  std::filesystem::create_directories(folder.Path("overlays"));
  folder.Write("overlays/000005.png", "by the viewer_headless before this one");
  const auto result = ResultWithoutPictures(folder, true, true);
  EXPECT_EQ(result.missing, 20);
  EXPECT_THAT(result.failures,
              testing::UnorderedElementsAre(testing::HasSubstr("3 of 4 pictures are missing in "),
                                            testing::HasSubstr("film: no film: 20 of 20 frames have no picture")));
}

TEST(PictureNode, MissingPicturesInRealTimeAreCounted) {
  const auto result = ResultWithoutPictures(ScratchFolder(), false, true);
  EXPECT_EQ(result.missing, 20);
  EXPECT_THAT(result.failures, testing::ElementsAre(testing::HasSubstr("film: no film: no pictures were received")));
}

TEST(PictureNode, PicturesAfterAnInterruptAreNotMissing) {
  const auto result = ResultWithoutPictures(ScratchFolder(), true, false);
  EXPECT_EQ(result.missing, 0);
  EXPECT_THAT(result.failures, testing::IsEmpty());
}

}  // namespace
}  // namespace plslam::viewer
