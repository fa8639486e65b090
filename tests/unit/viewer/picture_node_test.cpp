#include "viewer_headless/node/picture_node.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "plslam/tracks_t.hpp"
#include "tests/support/text_file.h"
#include "tests/unit/viewer/some_rig.h"
#include "viewer_headless/outputs.h"

namespace plslam {
namespace {

FramePose PoseOf(int64_t frame_id) {
  FramePose pose;
  pose.frame_id = frame_id;
  pose.state = TrackingState::kTracking;
  return pose;
}

TEST(PictureNode, ASecondStreamHasItsPicturesWhateverWasMissingInTheFirst) {
  const ScratchFolder folder;
  PrepareOutputFolder(folder.Path("overlays"));
  bus::BusOptions options;
  options.url = "memq://";
  bus::Bus bus(options, "viewer");
  PictureNode pictures(bus, {.out = folder.Path(""), .overlay_every = 1, .video = ""}, {}, [] {});
  const Rectifier rectifier(SomeRig());
  pictures.SetRectifier(&rectifier);
  // Frames whose images never came.
  for (int64_t frame = 100; frame < 120; ++frame) pictures.AddPose(PoseOf(frame));
  pictures.BeginAgain(nullptr);
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

}  // namespace
}  // namespace plslam
