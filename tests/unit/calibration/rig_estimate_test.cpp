// SPDX-License-Identifier: BSD-3-Clause
#include "tools/calibration/rig_estimate.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "core/geometry/distortion.h"
#include "tests/unit/calibration/board_pictures.h"
#include "tools/calibration/coverage.h"

namespace plslam::calibration {
namespace {

using testing::HasSubstr;

constexpr ImageSize kSize{640, 480};
constexpr double kNoise_px = 0.1;

Board Charuco() { return ParseBoard("charuco:11x8:0.03:0.022"); }

std::vector<BoardPair> Pairs(const Board& board, const RigCalibration& rig, int n, unsigned seed) {
  std::vector<BoardPair> pairs;
  const SE3 T_right_left = rig.right.T_b_cam.Inverse();
  for (const SE3& T_left_board : test::BoardPoses(board, n, seed)) {
    const unsigned s = 1000 * seed + 2 * static_cast<unsigned>(pairs.size());
    pairs.push_back({std::to_string(pairs.size()), test::SeenBoard(board, rig.left, T_left_board, kNoise_px, s),
                     test::SeenBoard(board, rig.right, T_right_left * T_left_board, kNoise_px, s + 1)});
  }
  return pairs;
}

std::string ErrorOf(const std::function<void()>& f) {
  try {
    f();
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "";
}

std::vector<double> Parameters(const CameraCalibration& camera) {
  std::vector<double> all{camera.fx_px, camera.fy_px, camera.cx_px, camera.cy_px};
  all.insert(all.end(), camera.distortion.begin(), camera.distortion.end());
  return all;
}

/// Squares of errors by their sigmas, of both lenses and the rig.
std::vector<double> SquaredErrors(const RigEstimate& e, const RigCalibration& rig) {
  std::vector<double> squares;
  const auto add = [&](const CameraCalibration& seen, const CameraCalibration& truth,
                       const std::vector<double>& sigma) {
    const std::vector<double> a = Parameters(seen), b = Parameters(truth);
    for (size_t i = 0; i < a.size(); ++i) squares.push_back(std::pow((a[i] - b[i]) / sigma[i], 2));
  };
  add(e.rig.left, rig.left, e.left_sigma);
  add(e.rig.right, rig.right, e.right_sigma);
  const Vector6d x = (rig.right.T_b_cam.Inverse() * e.rig.right.T_b_cam).Log();
  for (int i = 0; i < 6; ++i) squares.push_back(std::pow(x[i] / e.T_left_right_sigma[i], 2));
  return squares;
}

class EveryLens : public testing::TestWithParam<const char*> {};

TEST_P(EveryLens, ProjectsAsTheLibraryDoes) {
  const CameraCalibration camera = test::KnownRig(GetParam()).left;
  const std::vector<double> parameters = Parameters(camera);
  for (const Eigen::Vector2d& xy :
       {Eigen::Vector2d(0.0, 0.0), Eigen::Vector2d(0.6, -0.3), Eigen::Vector2d(-0.2, 0.4)}) {
    const Eigen::Vector3d p = 2.0 * xy.homogeneous();
    double pixel[2];
    ASSERT_TRUE(ProjectLens(camera.model, parameters.data(), p.data(), pixel));
    const Eigen::Vector2d d = *Distortion(camera).Distort(xy);
    EXPECT_NEAR(pixel[0], camera.fx_px * d.x() + camera.cx_px, 1e-10);
    EXPECT_NEAR(pixel[1], camera.fy_px * d.y() + camera.cy_px, 1e-10);
  }
}

TEST_P(EveryLens, SixtyPosesGiveTheRigWithTrueSigmas) {
  const RigCalibration rig = test::KnownRig(GetParam());
  double sum = 0.0;
  int n = 0;
  for (unsigned seed = 1; seed <= 2; ++seed) {
    const RigEstimate e = EstimateRig(Charuco(), Pairs(Charuco(), rig, 60, seed), kSize, GetParam());
    EXPECT_NEAR(e.rig.baseline_m, rig.right.T_b_cam.translation().norm(), 0.0001);
    EXPECT_NEAR(e.noise_px, kNoise_px, 0.003);
    EXPECT_LT(e.baseline_sigma_m, 0.0001);
    for (const auto& [seen, truth] : {std::pair(e.rig.left, rig.left), std::pair(e.rig.right, rig.right)}) {
      EXPECT_NEAR(seen.fx_px / truth.fx_px, 1.0, 0.0005);
      EXPECT_NEAR(seen.fy_px / truth.fy_px, 1.0, 0.0005);
    }
    for (const double square : SquaredErrors(e, rig)) {
      sum += square;
      ++n;
    }
  }
  // Parameters are correlated, so that the mean of the squares spreads more than that of as many independent ones.
  EXPECT_GT(sum / n, 0.4);
  EXPECT_LT(sum / n, 2.0);
  printf("%s: mean squared error by variance %.2f of %d\n", GetParam(), sum / n, n);
}

INSTANTIATE_TEST_SUITE_P(Models, EveryLens, testing::Values("radtan", "equidistant"));

TEST(EstimateRig, MistakesAreNamed) {
  const RigCalibration rig = test::KnownRig("radtan");
  std::vector<BoardPair> pairs = Pairs(Charuco(), rig, 30, 7);
  const auto error = [&] { return ErrorOf([&] { EstimateRig(Charuco(), pairs, kSize, "radtan"); }); };
  std::vector<BoardPair> good = pairs;
  for (BoardPair& pair : pairs) std::swap(pair.left, pair.right);
  EXPECT_THAT(error(), HasSubstr("are exchanged"));
  pairs = good;
  for (size_t i = 0; i + 1 < pairs.size(); ++i) pairs[i].right = good[i + 1].right;
  EXPECT_THAT(error(), HasSubstr("do not belong together"));
  pairs.assign(good.begin(), good.begin() + 6);
  EXPECT_THAT(error(), HasSubstr("of 6 pairs, at least 10 are needed"));
}

TEST(EstimateRig, AFewWrongPairsAndCornersAreLeftOut) {
  const RigCalibration rig = test::KnownRig("radtan");
  std::vector<BoardPair> pairs = Pairs(Charuco(), rig, 60, 8);
  std::swap(pairs[3].right, pairs[9].right);
  pairs[20].left.pixels[5].x() += 4.0;
  const RigEstimate e = EstimateRig(Charuco(), pairs, kSize, "radtan");
  EXPECT_THAT(e.left_out_pairs, testing::ElementsAre("3", "9"));
  EXPECT_GE(e.left_out_corners, 1);
  EXPECT_LE(e.left_out_corners, 5);
  EXPECT_NEAR(e.rig.baseline_m, rig.right.T_b_cam.translation().norm(), 0.0001);
}

TEST(ChoosePairs, AreThoseThatCoverTheImage) {
  const RigCalibration rig = test::KnownRig("radtan");
  std::vector<BoardPair> pairs(40, Pairs(Charuco(), rig, 1, 9).front());
  const std::vector<BoardPair> others = Pairs(Charuco(), rig, 10, 10);
  pairs.insert(pairs.end(), others.begin(), others.end());
  const std::vector<int> chosen = ChoosePairs(pairs, kSize, 12);
  EXPECT_EQ(chosen.size(), 12U);
  EXPECT_GE(std::count_if(chosen.begin(), chosen.end(), [](int i) { return i >= 40; }), 8);
}

TEST(Coverage, PictureAndWords) {
  std::vector<Eigen::Vector2d> pixels;
  for (int y = 0; y < 480; y += 10) {
    for (int x = 0; x < 640; x += 10) {
      if (x < 420 || y > 160) pixels.emplace_back(x, y);
    }
  }
  EXPECT_THAT(EmptyRegions(pixels, kSize), testing::ElementsAre("upper right corner"));
  const std::vector<std::string> picture = CoveragePicture(pixels, kSize);
  ASSERT_EQ(picture.size(), 12U);
  EXPECT_EQ(picture[0].substr(24), "        ");
  EXPECT_EQ(picture[0].find(' '), 21U);
}

}  // namespace
}  // namespace plslam::calibration
