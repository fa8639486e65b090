// SPDX-License-Identifier: BSD-3-Clause
// The whole system with frames from GStreamer instead of a dataset.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <signal.h>

#include <filesystem>
#include <fstream>

#include "core/datasets/camera_file.h"
#include "core/datasets/open_dataset.h"
#include "tests/integration/image_folder_of.h"
#include "tests/integration/run_watcher.h"
#include "tests/integration/whole_run.h"
#include "tests/support/text_file.h"
#include "tests/unit/camera/gst_elements.h"

namespace plslam {
namespace {

namespace fs = std::filesystem;
using test::WholeRun;
using testing::HasSubstr;

constexpr int kFrames = 30;

/// A world as a folder of images at 20 Hz.
class CameraRun : public testing::Test {
 protected:
  void WriteWorld(int frames) {
    const auto world = OpenDataset("synthetic:room?size=376x240&frames=30", "");
    std::vector<test::ChosenFrame> chosen;
    for (int i = 0; i < frames; ++i) chosen.push_back({i, false});
    test::WriteImageFolder(*world, chosen, folder_.Path("world"));
    // Times follow from the rate only, as in GStreamer.
    for (const char* file : {"times.txt", "groundtruth.txt"}) fs::remove(folder_.Path("world/") + file);
    RigCalibration rig = world->rig();
    rig.rate_hz = 20.0;
    camera_ = CameraFileText(rig);
    folder_.Write("world/camera.yaml", camera_);
  }

  std::string Images(const char* side) const { return folder_.Path("world/") + side; }

  /// `source` are the lines of the map.
  std::string WriteRig(const std::string& source) const {
    return folder_.Write("rig.yaml", camera_ + "source:\n" + source);
  }

  std::string ImageFiles() const {
    const auto side = [&](const char* name) {
      return fmt::format(
          "multifilesrc location=\"{}/%06d.png\" caps=\"image/png,framerate=20/1\" ! pngdec ! videoconvert ! "
          "video/x-raw,format=GRAY8 ! appsink name={}",
          Images(name), name);
    };
    return fmt::format("  pipeline: '{} {}'\n", side("left"), side("right"));
  }

  /// The first images of the world, repeated at 20 Hz: static cameras.
  std::string StandingCameras(const std::string& properties) const {
    const auto side = [&](const char* name) {
      return fmt::format(
          "filesrc location=\"{}/000000.png\" ! pngdec ! imagefreeze is-live=true {} ! videoconvert ! "
          "video/x-raw,format=GRAY8,framerate=20/1 ! appsink name={}",
          Images(name), properties, name);
    };
    return fmt::format("  pipeline: '{} {}'\n", side("left"), side("right"));
  }

  const ScratchFolder folder_;
  std::string camera_;
};

TEST_F(CameraRun, GStreamerGivesSameBytesAsImageFolder) {
  PLSLAM_REQUIRE_ELEMENTS("multifilesrc", "pngdec", "videoconvert");
  WriteWorld(kFrames);
  WholeRun folder, cameras;
  ASSERT_EQ(folder.Run({"run", folder_.Path("world")}), 0) << folder.Logs();
  ASSERT_EQ(cameras.Run({"run", WriteRig(ImageFiles()), "--pace", "lockstep"}), 0) << cameras.Logs();
  EXPECT_EQ(cameras.Summary()["frames"], kFrames);
  EXPECT_GE(cameras.Summary()["tracked_frames"], kFrames - 1);
  for (const char* file : {"trajectory.tum", "trajectory_live.tum", "keyframes.tum", "covariance.txt", "map.ply"}) {
    EXPECT_FALSE(cameras.Read(file).empty()) << file;
    EXPECT_EQ(cameras.Read(file), folder.Read(file)) << file;
  }
}

TEST_F(CameraRun, KilledInLockstepResumesWithSameResult) {
  PLSLAM_REQUIRE_ELEMENTS("multifilesrc", "pngdec", "videoconvert");
  WriteWorld(kFrames);
  WholeRun whole, killed;
  const std::string rig = WriteRig(ImageFiles());
  ASSERT_EQ(whole.Run({"run", rig, "--pace", "lockstep"}), 0) << whole.Logs();
  const test::RunWatcher watcher;
  killed.Start({"run", rig, "--pace", "lockstep", "--url", watcher.url()});
  ASSERT_TRUE(watcher.WaitForFrame(3)) << killed.Logs();
  if (const pid_t camera = killed.PidOf("camera"); camera > 0) kill(camera, SIGKILL);
  ASSERT_EQ(killed.Wait(), 0) << killed.Logs();
  EXPECT_EQ(killed.Read("trajectory.tum"), whole.Read("trajectory.tum")) << killed.Logs();
  EXPECT_EQ(killed.Summary()["processes"]["camera"]["restarts"], 1) << "it was there to be killed";
}

TEST_F(CameraRun, LiveCamerasAreFollowedAtTheirRate) {
  PLSLAM_REQUIRE_ELEMENTS("videotestsrc");
  camera_ =
      "rate_hz: 30\nbaseline_m: 0.1\nleft:\n  model: pinhole\n  resolution_px: [320, 240]\n"
      "  focal_length_px: [200, 200]\n  principal_point_px: [160, 120]\n";
  const std::string rig = WriteRig(
      "  pipeline: 'videotestsrc is-live=true num-buffers=150 pattern=smpte ! video/x-raw,format=GRAY8,width=320,"
      "height=240,framerate=30/1 ! tee name=t t. ! queue ! appsink name=left t. ! queue ! appsink name=right'\n");
  WholeRun run;
  ASSERT_EQ(run.Run({"run", rig}), 0) << run.Logs();
  const nlohmann::json summary = run.Summary();
  EXPECT_GE(summary["all_frames"], 140) << run.Logs();
  EXPECT_EQ(summary["configuration"]["camera"]["camera"]["pace"], "realtime");
  EXPECT_GE(summary["wall_s"], 4.5) << "150 frames at 30 Hz";
  EXPECT_LT(summary["processes"]["camera"]["peak_memory_mb"], 200.0);
  EXPECT_EQ(summary["processes"]["camera"]["restarts"], 0);
}

TEST_F(CameraRun, KilledLiveResumesInSameSession) {
  PLSLAM_REQUIRE_ELEMENTS("pngdec", "imagefreeze", "videoconvert");
  WriteWorld(1);
  WholeRun run;
  const test::RunWatcher watcher;
  run.Start({"run", WriteRig(StandingCameras("num-buffers=60")), "--url", watcher.url()});
  ASSERT_TRUE(watcher.WaitForFrame(10)) << run.Logs();
  const pid_t camera = run.PidOf("camera");
  ASSERT_GT(camera, 0) << run.Logs();
  kill(camera, SIGKILL);
  ASSERT_EQ(run.Wait(), 0) << run.Logs();
  const nlohmann::json summary = run.Summary();
  EXPECT_EQ(summary["processes"]["camera"]["restarts"], 1);
  EXPECT_GT(summary["all_frames"], 65) << run.Logs();
  EXPECT_EQ(summary["lost_frames"], 0) << run.Logs();
  EXPECT_GE(summary["tracked_frames"].get<int>(), summary["all_frames"].get<int>() - 5) << run.Logs();
}

TEST_F(CameraRun, LostCameraEndsTheRunAndSavesTheMap) {
  PLSLAM_REQUIRE_ELEMENTS("pngdec", "imagefreeze", "videoconvert", "identity");
  WriteWorld(1);
  WholeRun run;
  const std::string map = folder_.Path("map.plmap");
  const test::RunWatcher watcher;
  run.Start({"run", WriteRig(StandingCameras("! identity error-after=40") + "  give_up_s: 1\n"), "--save-map", map,
             "--url", watcher.url()});
  ASSERT_TRUE(watcher.WaitForFrame(5)) << run.Logs();
  fs::remove_all(Images("right"));
  EXPECT_EQ(run.Wait(), 1) << run.Logs();
  EXPECT_THAT(run.Logs(), testing::ContainsRegex("plslam: error: .*rig.yaml: source.pipeline: no frames for .*s "));
  EXPECT_GE(run.Summary()["tracked_frames"], 25) << run.Logs();
  EXPECT_TRUE(fs::exists(map)) << run.Logs();
}

TEST_F(CameraRun, DatasetOptionsAndMissingDevicesAreErrors) {
  WriteWorld(1);
  WholeRun run;
  EXPECT_EQ(run.Run({"run", WriteRig("  pair: [/nowhere/a, /nowhere/b]\n"), "--stop", "10"}), 1);
  EXPECT_THAT(run.Logs(), HasSubstr("--stop is for datasets, and "));
  WholeRun without;
  EXPECT_EQ(without.Run({"run", WriteRig("  pair: [/nowhere/a, /nowhere/b]\n")}), 1);
  EXPECT_THAT(without.Logs(), HasSubstr("rig.yaml: source.pair: "));
}

}  // namespace
}  // namespace plslam
