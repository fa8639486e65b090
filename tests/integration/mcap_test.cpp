// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <Eigen/Geometry>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "core/bus/logs/log_reader.h"
#include "core/bus/logs/log_writer.h"
#include "core/datasets/open_dataset.h"
#include "core/io/trajectories/pose_covariance.h"
#include "core/io/trajectories/trajectory.h"
#include "tests/integration/image_folder_of.h"
#include "tests/integration/whole_run.h"
#include "tests/support/data_folder.h"
#include "tests/support/python.h"
#include "tests/support/shell.h"
#include "tests/unit/export/small_map.h"

namespace plslam::test {
namespace {

using nlohmann::json;
using testing::HasSubstr;

constexpr const char* kWorld = "synthetic:room?frames=40&size=376x240";

/// One run with its map, exported once, for all tests here.
class McapOfARun : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    run_ = std::make_unique<WholeRun>();
    exit_code_ =
        run_->Run({"run", kWorld, "--save-map", (run_->out() / "map.plmap").string(), "--record", run_->log()});
  }
  static void TearDownTestSuite() { run_.reset(); }

  void SetUp() override { ASSERT_EQ(exit_code_, 0) << run_->Logs(); }

  static std::filesystem::path out() { return run_->out(); }

  /// `plslam export --format mcap` into the folder of the test.
  ShellResult Export(const std::string& arguments) const {
    return Shell(folder_, fmt::format("'{}' export --format mcap --out {} {}", (BinaryFolder() / "plslam").string(),
                                      folder_.Path("to"), arguments));
  }

  static std::string log() { return run_->log(); }

  /// Returns the content that the format's own libraries read in the file, and `failures`: differences from the folder
  /// of the run. Images are written into the folder of the test.
  json Check(const std::string& run = out().string()) const {
    const std::string script = (SourceFolder() / "tests/mcap/check_mcap.mjs").string();
    std::filesystem::create_directories(folder_.Path("images"));
    const ShellResult checked = Shell(folder_, fmt::format("node '{}' '{}' {} '{}' {}", script, PLSLAM_MCAP_MODULES,
                                                           folder_.Path("to/run.mcap"), run, folder_.Path("images")));
    EXPECT_EQ(checked.exit_code, 0) << checked.error;
    return json::parse(checked.out, nullptr, false);
  }

  static bool CanCheck() { return HasProgram("node") && std::filesystem::exists(PLSLAM_MCAP_MODULES); }

  /// The left images of the world, as JPEG gives them.
  void ExpectTheImagesOfTheWorld() const {
    const auto world = OpenDataset(kWorld, "");
    for (int i = 0; i < world->size(); ++i) {
      const cv::Mat written =
          cv::imread(folder_.Path(fmt::format("images/{}.jpeg", world->t_ns(i))), cv::IMREAD_UNCHANGED);
      const cv::Mat left = world->Read(i).left;
      ASSERT_EQ(written.size(), left.size()) << i;
      EXPECT_LT(cv::norm(written, left, cv::NORM_L1) / static_cast<double>(left.total()), 4.0) << i;
    }
  }

  const ScratchFolder& folder() const { return folder_; }

 private:
  static std::unique_ptr<WholeRun> run_;
  static int exit_code_;
  ScratchFolder folder_;
};
std::unique_ptr<WholeRun> McapOfARun::run_;
int McapOfARun::exit_code_ = -1;

json Topic(const std::string& type, int n) { return {{"type", type}, {"n", n}}; }

TEST_F(McapOfARun, IsReadByTheFormatsOwnLibraries) {
  if (!CanCheck()) GTEST_SKIP() << "no node, or its packages could not be fetched at the build";
  const ShellResult exported = Export(fmt::format("'{}' --dataset '{}'", out().string(), kWorld));
  ASSERT_EQ(exported.exit_code, 0) << exported.error;
  EXPECT_THAT(exported.out, HasSubstr("run.mcap: 40 frames, 40 images, the map"));
  const json layout = json::parse(ReadText(folder().Path("to/foxglove_layout.json")), nullptr, false);
  const json read = Check();
  ASSERT_TRUE(read.is_object());
  EXPECT_EQ(read["failures"], json::array());
  const json topics{{"/tf", Topic("tf2_msgs/msg/TFMessage", 40)},
                    {"/tf_static", Topic("tf2_msgs/msg/TFMessage", 1)},
                    {"/odom", Topic("nav_msgs/msg/Odometry", 40)},
                    {"/pose", Topic("geometry_msgs/msg/PoseWithCovarianceStamped", 40)},
                    {"/path", Topic("nav_msgs/msg/Path", 1)},
                    {"/path_live", Topic("nav_msgs/msg/Path", 1)},
                    {"/path_truth", Topic("nav_msgs/msg/Path", 1)},
                    {"/camera/left/compressed", Topic("sensor_msgs/msg/CompressedImage", 40)},
                    {"/camera/left/camera_info", Topic("sensor_msgs/msg/CameraInfo", 40)},
                    {"/map/points", Topic("sensor_msgs/msg/PointCloud2", 1)},
                    {"/map/lines", Topic("visualization_msgs/msg/Marker", 1)},
                    {"/loops", Topic("visualization_msgs/msg/Marker", 1)},
                    {"/keyframes", Topic("geometry_msgs/msg/PoseArray", 1)},
                    {"/diagnostics", Topic("diagnostic_msgs/msg/DiagnosticArray", 40)}};
  EXPECT_EQ(read["topics"], topics);
  EXPECT_GT(read["points"], 50);
  EXPECT_GT(read["lines"], 5);
  for (const auto& [topic, settings] : layout["configById"]["3D!plslam"]["topics"].items()) {
    EXPECT_TRUE(topics.contains(topic)) << "the layout shows a topic that is not written: " << topic;
  }
  const auto rig = OpenDataset(kWorld, "")->rig().left;
  EXPECT_EQ(read["camera"]["k"], json({rig.fx_px, 0, rig.cx_px, 0, rig.fy_px, rig.cy_px, 0, 0, 1}));
  EXPECT_EQ(read["camera"]["model"], "plumb_bob");
  EXPECT_EQ(read["camera"]["size"], json({376, 240}));
  EXPECT_EQ(read["formats"], json({"jpeg"}));
  ExpectTheImagesOfTheWorld();
  EXPECT_EQ(read["state"]["message"], "tracking");
  EXPECT_EQ(read["state"]["values"][0], json({{"key", "frame_id"}, {"value", "39"}}));
  // The room's first camera looks along the floor: up, -y of w, is z of the world.
  const json& q = read["world"]["transform"]["rotation"];
  const Eigen::Vector3d up = Eigen::Quaterniond(q["w"], q["x"], q["y"], q["z"]) * -Eigen::Vector3d::UnitY();
  EXPECT_GT(up.z(), 0.98) << up.transpose();
}

TEST_F(McapOfARun, CovarianceAndVelocityAreInTheAxesOfRos) {
  if (!CanCheck()) GTEST_SKIP() << "no node, or its packages could not be fetched at the build";
  ASSERT_EQ(Export("'" + out().string() + "'").exit_code, 0);
  const json read = Check();
  ASSERT_TRUE(read.is_object());
  EXPECT_EQ(read["failures"], json::array());
  EXPECT_FALSE(read["topics"].contains("/camera/left/compressed"));
  // p_w = p + R x: the slow twin turns random errors of the frame one by one.
  const Matrix6d covariance = ReadPoseCovariances((out() / "covariance.txt").string()).back().covariance;
  const Trajectory trajectory = ReadTrajectory((out() / "trajectory.tum").string());
  const SE3& T = trajectory.back().T_a_b;
  const Matrix6d root = covariance.llt().matrixL();
  Matrix6d expected = Matrix6d::Zero();
  for (int i = 0; i < 6; ++i) {
    Vector6d turned;
    turned << T.rotation() * Eigen::Vector3d(root.col(i).head<3>()),
        T.rotation() * Eigen::Vector3d(root.col(i).tail<3>());
    expected += turned * turned.transpose();
  }
  for (int k = 0; k < 36; ++k) {
    EXPECT_NEAR(read["covariance"][k].get<double>(), expected(k / 6, k % 6), 1e-6 * covariance.diagonal().maxCoeff());
  }
  const TrajectoryPose& before = trajectory[trajectory.size() - 2];
  const double seconds = 1e-9 * static_cast<double>(trajectory.back().t_ns - before.t_ns);
  const Eigen::Vector3d moved = T.translation() - before.T_a_b.translation();
  const json& v = read["speed"];
  EXPECT_NEAR(Eigen::Vector3d(v["x"], v["y"], v["z"]).norm(), moved.norm() / seconds, 0.01 * moved.norm() / seconds);
}

TEST_F(McapOfARun, AMapAloneHasNoFrames) {
  if (!CanCheck()) GTEST_SKIP() << "no node, or its packages could not be fetched at the build";
  const ShellResult exported = Export("'" + (out() / "map.plmap").string() + "'");
  ASSERT_EQ(exported.exit_code, 0) << exported.error;
  const json read = Check();
  ASSERT_TRUE(read.is_object());
  EXPECT_EQ(read["failures"], json::array());
  EXPECT_EQ(read["topics"].size(), 5U) << read["topics"];
  EXPECT_GT(read["points"], 50);
}

TEST_F(McapOfARun, ExportOfItsLog) {
  if (!CanCheck()) GTEST_SKIP() << "no node, or its packages could not be fetched at the build";
  const ShellResult exported = Export("'" + log() + "'");
  ASSERT_EQ(exported.exit_code, 0) << exported.error;
  EXPECT_THAT(exported.out, HasSubstr("run.mcap: 40 frames, 40 images, the map"));
  const json read = Check();
  ASSERT_TRUE(read.is_object());
  EXPECT_EQ(read["failures"], json::array());
  EXPECT_EQ(read["topics"].size(), 14U) << read["topics"];
  EXPECT_GT(read["points"], 50);
  ExpectTheImagesOfTheWorld();
  for (const char* file : {"trajectory.tum", "trajectory_live.tum", "groundtruth.tum", "covariance.txt", "map.ply"}) {
    EXPECT_EQ(ReadText(folder().Path(std::string("to/run/") + file)), ReadText(out() / file)) << file;
  }
  const ShellResult colmap =
      Shell(folder(), fmt::format("'{}' export --format colmap '{}'", (BinaryFolder() / "plslam").string(), log()));
  EXPECT_EQ(colmap.exit_code, 1);
  EXPECT_THAT(colmap.error, HasSubstr("run.lcm: colmap needs a saved map"));
}

TEST_F(McapOfARun, LogOfFramesAloneNeedsAReplay) {
  const std::string frames = folder().Path("frames.lcm");
  bus::LogReader reader(log());
  {
    bus::LogWriter writer(frames);
    while (const auto event = reader.Next()) {
      if (event->channel != "STEREO_FRAME" && event->channel != "CAMERA") continue;
      writer.Write(event->channel, reader.Data(event->data_offset, event->data_bytes).value(), event->timestamp_us);
    }
  }
  const ShellResult exported = Export(frames);
  EXPECT_EQ(exported.exit_code, 1);
  EXPECT_THAT(exported.error, HasSubstr("frames.lcm: is an LCM log without poses of a run (channel POSE): `plslam "
                                        "replay "));
}

TEST_F(McapOfARun, LoopsJoinTheirKeyframes) {
  if (!CanCheck()) GTEST_SKIP() << "no node, or its packages could not be fetched at the build";
  StoredMap stored = SmallStoredMap();
  stored.map.Add(LoopEdge{0, 2, SE3()});
  stored.map.TakeChanges();
  WriteMapFile(folder().Path("a.plmap"), stored);
  const ShellResult exported = Export(folder().Path("a.plmap"));
  ASSERT_EQ(exported.exit_code, 0) << exported.error;
  const json read = Check(folder().Path("none"));
  ASSERT_TRUE(read.is_object());
  EXPECT_EQ(read["failures"], json::array());
  ASSERT_EQ(read["loops"].size(), 2U);
  for (const int end : {0, 1}) {
    const Eigen::Vector3d p(read["loops"][end]["x"], read["loops"][end]["y"], read["loops"][end]["z"]);
    EXPECT_EQ(p, stored.map.FindKeyframe(2 * end)->T_w_kf.translation());
  }
}

TEST_F(McapOfARun, ImageFilesAreCopiedUnchanged) {
  if (!CanCheck()) GTEST_SKIP() << "no node, or its packages could not be fetched at the build";
  const auto world = OpenDataset(kWorld, "");
  std::vector<ChosenFrame> frames(3);
  for (int i = 0; i < 3; ++i) frames[static_cast<size_t>(i)].index = i;
  WriteImageFolder(*world, frames, folder().Path("png"));
  const auto images = OpenDataset(folder().Path("png"), "");
  Trajectory trajectory;
  for (int i = 0; i < 3; ++i) trajectory.push_back({images->t_ns(i), SE3()});
  std::filesystem::create_directories(folder().Path("run"));
  WriteTrajectory(folder().Path("run/trajectory.tum"), TrajectoryFormat::kTum, trajectory);
  const ShellResult exported = Export(fmt::format("{} --dataset {}", folder().Path("run"), folder().Path("png")));
  ASSERT_EQ(exported.exit_code, 0) << exported.error;
  const json read = Check(folder().Path("run"));
  ASSERT_TRUE(read.is_object());
  EXPECT_EQ(read["failures"], json::array());
  EXPECT_EQ(read["formats"], json({"png"}));
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(ReadText(folder().Path(fmt::format("images/{}.png", images->t_ns(i)))), ReadText(images->LeftFile(i)));
  }
}

TEST_F(McapOfARun, PythonLoadsTheSameFolder) {
  const std::string python = PythonWithNumpy();
  if (python.empty()) GTEST_SKIP() << "no Python with numpy here";
  folder().Write("program.py", R"(
import json, sys
import plslam
run = plslam.load_run(sys.argv[1])
print(json.dumps({"frames": len(run.frames["frame_id"]), "poses": len(run.trajectory), "live": len(run.live),
                  "truth": len(run.truth), "covariances": len(run.covariance[0]), "summary": run.summary["frames"],
                  "keyframes": len(run.map.keyframes.id), "last": run.trajectory.position_m[-1].tolist(),
                  "observed": len(run.map.points.observations)}))
)");
  const ShellResult result =
      Shell(folder(), fmt::format("PYTHONDONTWRITEBYTECODE=1 PYTHONPATH='{}' {} {} '{}'", PLSLAM_PYTHON_FOLDER,
                                  python, folder().Path("program.py"), out().string()));
  ASSERT_EQ(result.exit_code, 0) << result.error;
  const json run = json::parse(result.out);
  for (const char* what : {"frames", "poses", "live", "truth", "covariances", "summary"})
    EXPECT_EQ(run[what], 40) << what;
  EXPECT_GT(run["keyframes"], 2);
  EXPECT_GT(run["observed"], 200);
  const Trajectory trajectory = ReadTrajectory((out() / "trajectory.tum").string());
  for (int k = 0; k < 3; ++k) EXPECT_EQ(run["last"][k], trajectory.back().T_a_b.translation()[k]);
}

}  // namespace
}  // namespace plslam::test
