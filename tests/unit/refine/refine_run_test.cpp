// SPDX-License-Identifier: BSD-3-Clause
#include "tools/refine/refine_run.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "core/datasets/camera_file.h"
#include "core/io/maps/map_camera.h"
#include "core/io/trajectories/trajectory.h"
#include "tests/unit/datasets/dataset_folders.h"
#include "tests/unit/mapping/mapping_world.h"

namespace plslam::refine {
namespace {

namespace fs = std::filesystem;

/// The folder of a run with a map, and a trajectory of its keyframes with a frame between each two.
class RefineRunTest : public testing::Test {
 protected:
  RefineRunTest() {
    const test::FeatureWorld world({400, 60}, 1);
    const test::Walk walk = test::MakeWalk(world, test::TurningPath(10), {});
    mapping::Mapper mapper = test::MapAll(walk.keyframes);
    StoredMap stored = mapper.Store();
    stored.rig = CameraBytes(test::FeatureWorld::Camera());
    fs::create_directories(run());
    WriteMapFile((run() / "map.plmap").string(), stored);
    Trajectory frames, truth;
    for (const auto& [id, keyframe] : stored.map.keyframes()) {
      frames.push_back({keyframe.t_ns, keyframe.T_w_kf});
      frames.push_back({keyframe.t_ns + 1000, keyframe.T_w_kf});
      truth.push_back({keyframe.t_ns, walk.T_w_c[static_cast<size_t>(keyframe.name.number)]});
    }
    WriteTrajectory((run() / "trajectory.tum").string(), TrajectoryFormat::kTum, frames);
    WriteTrajectory((run() / "groundtruth.tum").string(), TrajectoryFormat::kTum, truth);
  }

  fs::path run() const { return folder_.path() / "run"; }
  fs::path out() const { return folder_.path() / "refined"; }

  RefineRequest Request() const { return {run().string(), out().string(), {}}; }

  std::string FailureOf(const RefineRequest& request) const {
    try {
      RefineRun(request);
    } catch (const std::runtime_error& e) {
      return e.what();
    }
    return "";
  }

 private:
  test::TemporaryFolder folder_;
};

TEST_F(RefineRunTest, WritesAFolderLikeThatOfARun) {
  const RefinedRun refined = RefineRun(Request());
  ASSERT_TRUE(refined.errors);
  EXPECT_LT(refined.errors->after_m, 1.05 * refined.errors->before_m);
  const StoredMap map = ReadMapFile((out() / "map.plmap").string());
  const Trajectory frames = ReadTrajectory((out() / "trajectory.tum").string());
  EXPECT_EQ(frames.size(), ReadTrajectory((run() / "trajectory.tum").string()).size());
  EXPECT_EQ(ReadTrajectory((out() / "keyframes.tum").string()).size(), map.map.keyframes().size());
  EXPECT_NEAR(frames[0].T_a_b.translation().x(), map.map.FindKeyframe(0)->T_w_kf.translation().x(), 1e-6);
  const RigCalibration rig = ReadCameraFile((out() / "camera.yaml").string(), {640, 480});
  EXPECT_EQ(rig.left.fx_px, 400.0);
  EXPECT_NEAR(rig.baseline_m, 0.12, 1e-12);
  std::ifstream file(out() / "summary.json");
  const nlohmann::json summary = nlohmann::json::parse(file);
  EXPECT_EQ(summary["after"]["keyframes"], map.map.keyframes().size());
  EXPECT_NEAR(summary["after"]["ate_m"].get<double>(), refined.errors->after_m, 1e-12);
}

TEST_F(RefineRunTest, RefusesBadSourcesInOneSentence) {
  RefineRequest request = Request();
  request.out = run().string();
  EXPECT_NE(FailureOf(request).find("is the folder of the map that is refined"), std::string::npos);
  request = Request();
  request.source = (run() / "nothing").string();
  EXPECT_NE(FailureOf(request).find("does not exist"), std::string::npos);
  fs::resize_file(run() / "map.plmap", 1000);
  EXPECT_NE(FailureOf(Request()).find("map.plmap"), std::string::npos);
  fs::remove(run() / "map.plmap");
  EXPECT_NE(FailureOf(Request()).find("--save-map"), std::string::npos);
  EXPECT_FALSE(fs::exists(out()));
}

// A changed byte anywhere is found before anything is written.
TEST_F(RefineRunTest, RefusesMapsWithDamagedSections) {
  const fs::path map = run() / "map.plmap";
  std::string bytes;
  {
    std::ifstream file(map, std::ios::binary);
    bytes.assign(std::istreambuf_iterator<char>(file), {});
  }
  for (int i = 1; i < 20; ++i) {
    std::string damaged = bytes;
    damaged[bytes.size() * static_cast<size_t>(i) / 20] ^= 0x10;
    std::ofstream(map, std::ios::binary) << damaged;
    const std::string sentence = FailureOf(Request());
    EXPECT_NE(sentence.find("map.plmap"), std::string::npos) << "byte " << bytes.size() * i / 20 << ": " << sentence;
    EXPECT_EQ(sentence.find('\n'), std::string::npos) << sentence;
    EXPECT_FALSE(fs::exists(out()));
  }
}

}  // namespace
}  // namespace plslam::refine
