// SPDX-License-Identifier: BSD-3-Clause
#include "tools/calibration/rig_estimate.h"

#include <gmock/gmock.h>

#include <Eigen/Eigenvalues>
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

/// A squared error by its covariance, and of how many coordinates.
struct ChiSquare {
  double sum = 0.0;
  int n = 0;
};

/// Chi-square of pixels all over the image as the lens predicts them, in the directions in which they are uncertain by
/// more than a thousandth of a pixel: coefficients that compensate each other are not compared one by one.
ChiSquare OfPixels(const CameraCalibration& seen, const CameraCalibration& truth, const Eigen::MatrixXd& covariance) {
  std::vector<Eigen::Vector2d> rays;
  for (double x = -0.6; x < 0.61; x += 0.2) {
    for (double y = -0.45; y < 0.46; y += 0.15) rays.emplace_back(x, y);
  }
  const auto n = static_cast<Eigen::Index>(rays.size());
  Eigen::MatrixXd J(2 * n, covariance.cols());
  Eigen::VectorXd error(2 * n);
  const std::vector<double> a = LensParameters(seen), b = LensParameters(truth);
  for (Eigen::Index i = 0; i < n; ++i) {
    const Eigen::Vector2d& xy = rays[static_cast<size_t>(i)];
    const Eigen::Vector3d ray = xy.homogeneous();
    Eigen::Vector2d p, q;
    EXPECT_TRUE(ProjectLens(seen.model, a.data(), ray.data(), p.data()));
    EXPECT_TRUE(ProjectLens(truth.model, b.data(), ray.data(), q.data()));
    error.segment<2>(2 * i) = p - q;
    J.middleRows(2 * i, 2) = PixelJacobian(seen, xy).value();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> modes(J * covariance * J.transpose());
  const Eigen::VectorXd along = modes.eigenvectors().transpose() * error;
  ChiSquare chi;
  for (Eigen::Index i = 0; i < along.size(); ++i) {
    if (modes.eigenvalues()[i] < 1e-6 * static_cast<double>(n)) continue;
    chi.sum += along[i] * along[i] / modes.eigenvalues()[i];
    ++chi.n;
  }
  return chi;
}

class EveryLens : public testing::TestWithParam<const char*> {};

TEST_P(EveryLens, ProjectsAsTheLibraryDoes) {
  const CameraCalibration camera = test::KnownRig(GetParam()).left;
  const std::vector<double> parameters = LensParameters(camera);
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
  ChiSquare lens, pose, single, focal;
  for (unsigned seed = 1; seed <= 3; ++seed) {
    const RigEstimate e = EstimateRig(Charuco(), Pairs(Charuco(), rig, 60, seed), kSize, GetParam());
    EXPECT_NEAR(e.rig.baseline_m, rig.right.T_b_cam.translation().norm(), 0.0001);
    EXPECT_NEAR(e.noise_px, kNoise_px, 0.003);
    EXPECT_LT(e.baseline_sigma_m, 0.0001);
    for (const bool is_right : {false, true}) {
      const CameraCalibration& seen = is_right ? e.rig.right : e.rig.left;
      const CameraCalibration& truth = is_right ? rig.right : rig.left;
      const Eigen::MatrixXd& covariance = is_right ? e.right_covariance : e.left_covariance;
      EXPECT_NEAR(FocalInCentre_px(seen) / FocalInCentre_px(truth), 1.0, 0.0005);
      EXPECT_NEAR(seen.fy_px / seen.fx_px, truth.fy_px / truth.fx_px, 0.0005);
      // In the corners of the image, where few poses have a corner, eight coefficients are least certain.
      EXPECT_LT(PixelSigma_px(seen, covariance), 5.0);
      const ChiSquare chi = OfPixels(seen, truth, covariance);
      lens.sum += chi.sum;
      lens.n += chi.n;
      const std::vector<double> a = LensParameters(seen), b = LensParameters(truth);
      for (size_t i = 0; i < a.size(); ++i) {
        const auto k = static_cast<Eigen::Index>(i);
        single.sum += std::pow(a[i] - b[i], 2) / covariance(k, k);
        ++single.n;
      }
      focal.sum +=
          std::pow((FocalInCentre_px(seen) - FocalInCentre_px(truth)) / FocalInCentreSigma_px(seen, covariance), 2);
      ++focal.n;
    }
    const Vector6d x = (rig.right.T_b_cam.Inverse() * e.rig.right.T_b_cam).Log();
    pose.sum += x.cwiseQuotient(e.T_left_right_sigma).squaredNorm();
    pose.n += 6;
  }
  printf(
      "%s: squared errors by variance: pixels %.1f of %d, parameters %.1f of %d, focal lengths %.1f of %d, rig %.1f "
      "of %d\n",
      GetParam(), lens.sum, lens.n, single.sum, single.n, focal.sum, focal.n, pose.sum, pose.n);
  // Four standard deviations of a chi-square distribution.
  EXPECT_NEAR(lens.sum, lens.n, 4.0 * std::sqrt(2.0 * lens.n));
  // Correlated, so that their sums spread more.
  if (GetParam() != std::string("rational")) {
    EXPECT_LT(single.sum, 2.0 * single.n);
  }
  EXPECT_LT(focal.sum, 4.0 * focal.n);
  EXPECT_GT(focal.sum, 0.4 * focal.n);
  EXPECT_LT(pose.sum, 2.5 * pose.n);
  EXPECT_GT(pose.sum, 0.4 * pose.n);
}

INSTANTIATE_TEST_SUITE_P(Models, EveryLens, testing::Values("radtan", "rational", "equidistant", "double_sphere"));

/// The right camera is turned by 40 degrees about the optical axis, so that its axes are not those of the left one.
TEST(EstimateRig, SigmasOfTheTranslationAreAlongTheLeftAxes) {
  RigCalibration rig = test::KnownRig("radtan");
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(40.0 * kRadPerDeg, Eigen::Vector3d::UnitZ()));
  rig.right.T_b_cam = SE3(turn, rig.right.T_b_cam.translation());
  const RigEstimate e = EstimateRig(Charuco(), Pairs(Charuco(), rig, 40, 4), kSize, "radtan");
  // The baseline lies along x, to some degrees.
  EXPECT_NEAR(e.right_in_left_sigma_m.x() / e.baseline_sigma_m, 1.0, 0.1);
  EXPECT_NEAR(e.right_in_left_sigma_m.norm(), e.T_left_right_sigma.head<3>().norm(), 1e-9);
  EXPECT_GT((e.right_in_left_sigma_m - e.T_left_right_sigma.head<3>()).norm(), 1e-6);
}

TEST(PixelJacobian, NoneOutsideTheValidityOfTheLens) {
  CameraCalibration camera = test::KnownRig("rational").left;
  camera.distortion = {0.0, 0.0, 0.0, 0.0, 0.0, -1.0, 0.0, 0.0};
  EXPECT_TRUE(PixelJacobian(camera, {0.5, 0.0}));
  EXPECT_FALSE(PixelJacobian(camera, {1.0, 0.5}));
}

/// Coefficients that are unlikely under the prior, as in depth cameras: others give the same distortion.
TEST(EstimateRig, RationalLensFarFromThePrior) {
  RigCalibration rig = test::KnownRig("rational");
  for (CameraCalibration* camera : {&rig.left, &rig.right}) {
    camera->distortion = {0.47, -2.55, 0.0005, -0.0003, 1.49, 0.55, -2.38, 1.42};
  }
  ChiSquare lens;
  for (unsigned seed = 1; seed <= 2; ++seed) {
    const RigEstimate e = EstimateRig(Charuco(), Pairs(Charuco(), rig, 40, seed), kSize, "rational");
    EXPECT_NEAR(e.rig.baseline_m, rig.right.T_b_cam.translation().norm(), 0.0001);
    EXPECT_NEAR(e.rig.left.fx_px / rig.left.fx_px, 1.0, 0.0005);
    for (const bool is_right : {false, true}) {
      const ChiSquare chi = OfPixels(is_right ? e.rig.right : e.rig.left, is_right ? rig.right : rig.left,
                                     is_right ? e.right_covariance : e.left_covariance);
      lens.sum += chi.sum;
      lens.n += chi.n;
    }
  }
  printf("squared errors of pixels by variance %.1f of %d\n", lens.sum, lens.n);
  EXPECT_NEAR(lens.sum, lens.n, 4.0 * std::sqrt(2.0 * lens.n));
}

TEST(EstimateRig, MistakesAreNamed) {
  const RigCalibration rig = test::KnownRig("radtan");
  std::vector<BoardPair> pairs = Pairs(Charuco(), rig, 30, 7);
  const auto error = [&] { return ErrorOf([&] { EstimateRig(Charuco(), pairs, kSize, "radtan"); }); };
  std::vector<BoardPair> good = pairs;
  for (BoardPair& pair : pairs) std::swap(pair.left, pair.right);
  EXPECT_THAT(error(), HasSubstr("are exchanged"));
  pairs = good;
  for (size_t i = 0; i + 1 < pairs.size(); ++i) pairs[i].right = good[i + 1].right;
  EXPECT_THAT(error(), HasSubstr("do not match"));
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

TEST(ChoosePairs, ChosenPairsCoverTheImage) {
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
