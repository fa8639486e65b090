// SPDX-License-Identifier: BSD-3-Clause
// viewer_headless: conditions of its end, its reports of missing outputs, and repeated messages.
#include <gmock/gmock.h>

#include <algorithm>
#include <filesystem>

#include "core/io/trajectories/trajectory.h"
#include "tests/unit/viewer/viewer_fixture.h"

namespace plslam::viewer {
namespace {

using ViewerDelivery = ViewerFixture;

TEST_F(ViewerDelivery, NothingIsWrittenWithoutACamera) {
  stop_at_ = "running";
  testing::internal::CaptureStderr();
  {
    const ViewerNode node(*process_, Options());
    PublishPose(0);
    bus().Run();
  }
  EXPECT_THAT(testing::internal::GetCapturedStderr(),
              testing::HasSubstr("viewer: error: nothing is written to " + folder_.Path("out") +
                                 ": poses were received, but no rig"));
  EXPECT_FALSE(std::filesystem::exists(Out("trajectory.tum")));
}

TEST_F(ViewerDelivery, WaitsForTheCamera) {
  const ViewerNode node(*process_, Options());
  for (int64_t frame = 0; frame < kFrames; ++frame) PublishPose(frame);
  PublishStream("end", kFrames);
  // As in a restarted viewer: all past messages arrive at once, and the camera, which is repeated, after a while.
  int ticks = 0;
  bus().Every(std::chrono::milliseconds(250), [&] {
    if (++ticks == 6) PublishCamera();
  });
  bus().Run();
  EXPECT_GE(ticks, 6);
  EXPECT_EQ(states_.back(), "finished");
  EXPECT_EQ(ReadTrajectory(Out("trajectory.tum")).size(), 12u);
}

/// A tracker that has finished, and one whose last pose is repaired late.
TEST_F(ViewerDelivery, WaitsForTheAnnouncedEndAndNotForTicks) {
  const ViewerNode node(*process_, Options());
  PublishRun("begin");
  PublishCamera();
  for (int64_t frame = 0; frame + 1 < kFrames; ++frame) PublishPose(frame);
  status_t tracker{};
  tracker.process = "vo";
  tracker.state = "finished";
  bus().Publish(bus::kStatus, tracker);
  PublishStream("end", kFrames);
  int ticks = 0;
  bus().Every(std::chrono::milliseconds(250), [&] {
    if (++ticks == 10) PublishPose(kFrames - 1);
    if (ticks == 14) PublishRun("end", kFrames);
  });
  bus().Run();
  EXPECT_GE(ticks, 14);
  EXPECT_EQ(ReadTrajectory(Out("trajectory.tum")).size(), 12u);
}

/// A restarted viewer: the end of the run is in the launcher's history, and the map arrives last.
TEST_F(ViewerDelivery, AnnouncedKeyframeIsAwaited) {
  const ViewerNode node(*process_, Options());
  PublishRun("begin");
  PublishRun("end", kFrames, 2);
  PublishCamera();
  for (int64_t frame = 0; frame < kFrames; ++frame) PublishPose(frame);
  PublishStream("end", kFrames);
  bus::MapUpdatePublisher mapping(bus(), [] {});
  int ticks = 0;
  bus().Every(std::chrono::milliseconds(250), [&] {
    if (++ticks == 6) mapping.Publish(MapOf(2, 3.0));
  });
  bus().Run();
  EXPECT_GE(ticks, 6);
  EXPECT_NEAR(ReadTrajectory(Out("trajectory.tum")).at(7).T_a_b.translation().x(), 3.0, 1e-9);
}

TEST_F(ViewerDelivery, WaitsForPicturesInLockstep) {
  const ViewerNode node(*process_, Options(4));
  PublishCamera();
  PublishStream("begin", 9, "lockstep");
  for (int64_t frame = 0; frame < 9; ++frame) PublishPose(frame);
  PublishStream("end", 9, "lockstep");
  int64_t frame = 0;
  bus().Every(std::chrono::milliseconds(400), [&] {
    if (frame > 8) return;
    PublishTracks(frame);
    PublishImages(frame++);
  });
  bus().Run();
  EXPECT_EQ(states_.back(), "finished");
  for (const char* name : {"000000.png", "000004.png", "000008.png"}) {
    EXPECT_TRUE(std::filesystem::exists(Out(std::string("overlays/") + name))) << name;
  }
}

TEST_F(ViewerDelivery, UnwritableFileIsReportedOthersAreWritten) {
  stop_at_ = "failed";
  testing::internal::CaptureStderr();
  {
    const ViewerNode node(*process_, Options());
    PublishCamera();
    PublishPose(0);
    PublishStream("end", 1);
    // No file can be renamed over a folder.
    std::filesystem::create_directories(Out("trajectory.tum/in the way"));
    bus().Run();
  }
  EXPECT_EQ(states_.back(), "failed");
  const std::string log = testing::internal::GetCapturedStderr();
  EXPECT_THAT(log, testing::HasSubstr("viewer: error: " + Out("trajectory.tum") + ": cannot be put in place: "));
  EXPECT_THAT(log, testing::EndsWith("\n"));
  EXPECT_EQ(ReadTrajectory(Out("trajectory.kitti")).size(), 1u);
  EXPECT_TRUE(std::filesystem::exists(Out("poses.csv")));
}

TEST_F(ViewerDelivery, RepublishedStreamIsTheSameStream) {
  stop_at_ = "";
  stream_t begin{};
  begin.header.session = 77;
  begin.event = "begin";
  begin.n_frames = 2;
  {
    const ViewerNode node(*process_, Options());
    PublishCamera();
    bus().Publish(bus::kStream, begin);
    for (int64_t frame = 0; frame < 2; ++frame) PublishPose(frame);
    PublishStream("end", 2);
    int ticks_after = -1;
    bus().Every(std::chrono::milliseconds(50), [&] {
      if (ticks_after < 0 && std::find(states_.begin(), states_.end(), "finished") == states_.end()) return;
      if (++ticks_after == 0) bus().Publish(bus::kStream, begin);
      if (ticks_after == 2) PublishPose(1);
      if (ticks_after == 4) bus().Stop();
    });
    bus().Run();
  }
  EXPECT_EQ(ReadTrajectory(Out("trajectory.tum")).size(), 2u) << "the frames before it were not forgotten";
}

}  // namespace
}  // namespace plslam::viewer
