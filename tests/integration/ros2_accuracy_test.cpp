// SPDX-License-Identifier: BSD-3-Clause
// Poses of images that came through DDS are those of the same images from their files.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include "core/accuracy/association.h"
#include "core/datasets/open_dataset.h"
#include "core/io/trajectories/trajectory.h"
#include "tests/integration/ros2_robot.h"
#include "tests/support/long_tests.h"

namespace plslam::test {
namespace {

class Ros2Accuracy : public Ros2 {
 protected:
  /// Runs with images of DDS, whose stamps are those of the dataset, into the folder `live`.
  void RunLive(const std::string& dataset, int rate_hz, int n_frames, const std::vector<std::string>& options) {
    std::vector<std::string> arguments{"run", fmt::format("ros2:{}", kTopics), "--out", folder_.Path("live")};
    arguments.insert(arguments.end(), options.begin(), options.end());
    const auto run = Start(BinaryFolder() / "plslam", arguments, "run.log");
    const auto robot = StartRobot(
        {dataset, std::to_string(rate_hz), std::to_string(n_frames), "synchronous", "begin_s=0", "listen_s=1"});
    Wait(*robot);
    run->Signal(SIGINT);
    Wait(*run);
    ASSERT_EQ(run->Poll()->code, 0) << Log("run.log");
  }
  /// The same from the files, into the folder `file`.
  void RunFile(const std::string& dataset, int first, int n_frames, const std::vector<std::string>& options) {
    std::vector<std::string> arguments{"run",     dataset,
                                       "--start", std::to_string(first),
                                       "--stop",  std::to_string(n_frames),
                                       "--out",   folder_.Path("file")};
    arguments.insert(arguments.end(), options.begin(), options.end());
    const auto run = Start(BinaryFolder() / "plslam", arguments, "file.log");
    const auto has_ended = [&] { return run->Poll().has_value(); };
    // Large images take longer than others that are waited for.
    ASSERT_TRUE(WholeRun::WaitFor(has_ended) || WholeRun::WaitFor(has_ended)) << Log("file.log");
    ASSERT_EQ(run->Poll()->code, 0) << Log("file.log");
  }

  Trajectory PosesOf(const std::string& run) const {
    return ReadTrajectory(folder_.Path(run + "/trajectory.tum"), TrajectoryFormat::kTum);
  }

  /// Compares the poses up to the first frame that a busy machine skips: it changes the poses after it.
  void ExpectThePosesOfTheFile(const std::string& dataset, int rate_hz, int n_frames, double tolerance) {
    ASSERT_NO_FATAL_FAILURE(RunLive(dataset, rate_hz, n_frames, {"--no-mapping"}));
    const Trajectory live = PosesOf("live");
    ASSERT_GT(static_cast<int>(live.size()), n_frames / 2);
    const auto frames = OpenDataset(dataset, "");
    int first = 0;
    while (first < frames->size() && frames->t_ns(first) < live.front().t_ns) ++first;
    ASSERT_NO_FATAL_FAILURE(RunFile(dataset, first, n_frames, {"--no-mapping"}));
    const Trajectory file = PosesOf("file");
    size_t n = 0;
    for (; n < std::min(live.size(), file.size()) && live[n].t_ns == file[n].t_ns; ++n) {
      const SE3 T_live = live.front().T_a_b.Inverse() * live[n].T_a_b,
                T_file = file.front().T_a_b.Inverse() * file[n].T_a_b;
      EXPECT_LT((T_live.Inverse() * T_file).Log().norm(), tolerance) << "frame " << first + static_cast<int>(n);
    }
    EXPECT_GT(n, 10U);
    fmt::print("{}: {} of {} frames; the first {} are compared\n", dataset, live.size(), n_frames, n);
  }

  /// The root mean square of the errors of position after alignment, over the times of both.
  double Ate(const std::string& run, const Dataset& truth) const {
    Trajectory true_poses;
    for (int i = 0; i < truth.size(); ++i) {
      if (const auto T = truth.GroundTruth(i)) true_poses.push_back({truth.t_ns(i), *T});
    }
    const PosePairs pairs = AssociateNearest(PosesOf(run), true_poses, 1'000'000);
    Eigen::Matrix3Xd estimates(3, pairs.size()), truths(3, pairs.size());
    for (size_t i = 0; i < pairs.size(); ++i) {
      estimates.col(static_cast<int>(i)) = pairs[i].estimate.translation();
      truths.col(static_cast<int>(i)) = pairs[i].truth.translation();
    }
    const Eigen::Matrix4d T = Eigen::umeyama(estimates, truths, false);
    const Eigen::Matrix3Xd errors =
        (T.topLeftCorner<3, 3>() * estimates).colwise() + T.topRightCorner<3, 1>() - truths;
    return std::sqrt(errors.squaredNorm() / static_cast<double>(pairs.size()));
  }
};

// Images and calibration arrive as they were sent.
TEST_F(Ros2Accuracy, PosesAreThoseOfTheDatasetItself) { ExpectThePosesOfTheFile(kWorld, 10, 50, 1e-8); }

// The lenses are distorted and the cameras turned against each other: CameraInfo says so in other numbers.
TEST_F(Ros2Accuracy, RecordingHasThePosesOfItsFile) {
  PLSLAM_REQUIRE_DATA(folder, "euroc_MH_01_a");
  ExpectThePosesOfTheFile(folder.string(), 8, 30, 1e-6);
}

TEST_F(Ros2Accuracy, AteIsThatOfTheFolder) {
  PLSLAM_REQUIRE_LONG_TESTS();
  constexpr const char* kRoom = "synthetic:room?size=752x480&frames=200";
  ASSERT_NO_FATAL_FAILURE(RunLive(kRoom, 20, 200, {}));
  ASSERT_NO_FATAL_FAILURE(RunFile(kRoom, 0, 200, {}));
  const auto room = OpenDataset(kRoom, "");
  const double live_m = Ate("live", *room), file_m = Ate("file", *room);
  fmt::print("752x480 at 20 Hz: {} of 200 frames; ATE {:.2f} mm, from the folder {:.2f} mm\n", PosesOf("live").size(),
             1e3 * live_m, 1e3 * file_m);
  EXPECT_GT(PosesOf("live").size(), 190U);
  EXPECT_LT(live_m, 1.5 * file_m + 0.001);
}

}  // namespace
}  // namespace plslam::test
