#include "vo_process/tracking/point_refiner.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "core/geometry/se3.h"

namespace plslam {
namespace {

constexpr StereoCamera kCamera{300.0, 160.0, 120.0, 0.2, 320, 240};
constexpr double kDepth_m = 2.0;
constexpr double kSlant = 0.4;

/// A textured wall z = kDepth_m + kSlant * x in the frame of the first camera.
class Wall {
 public:
  Wall() {
    std::mt19937_64 random(3);
    std::uniform_real_distribution<double> uniform(0.0, 1.0);
    for (auto& wave : waves_) {
      const double direction = 2.0 * std::numbers::pi * uniform(random);
      // Six to forty pixels long where the wall is two metres away.
      const double frequency = 2.0 * std::numbers::pi / (0.04 * std::pow(7.0, uniform(random)));
      wave = {frequency * std::cos(direction), frequency * std::sin(direction), 6.0 * uniform(random)};
    }
  }

  /// Where the ray of a pixel meets the wall.
  static Eigen::Vector3d Meet(const SE3& T_w_c, const Eigen::Vector2d& px) {
    const Eigen::Vector3d ray = T_w_c.rotation() * Eigen::Vector3d((px.x() - kCamera.cx_px) / kCamera.f_px,
                                                                   (px.y() - kCamera.cy_px) / kCamera.f_px, 1.0);
    const Eigen::Vector3d& o = T_w_c.translation();
    const double s = (kDepth_m + kSlant * o.x() - o.z()) / (ray.z() - kSlant * ray.x());
    return o + s * ray;
  }

  cv::Mat Render(const SE3& T_w_c, double gain = 1.0) const {
    cv::Mat image(kCamera.height_px, kCamera.width_px, CV_8UC1);
    for (int y = 0; y < image.rows; ++y) {
      for (int x = 0; x < image.cols; ++x) {
        const Eigen::Vector3d p = Meet(T_w_c, Eigen::Vector2d(x, y));
        double value = 110.0;
        for (const auto& [fx, fy, phase] : waves_) value += 9.0 * std::sin(fx * p.x() + fy * p.y() + phase);
        image.at<uint8_t>(y, x) = static_cast<uint8_t>(std::clamp(std::lround(gain * value), 0L, 255L));
      }
    }
    return image;
  }

 private:
  std::array<std::array<double, 3>, 50> waves_;
};

StereoPoint PointAt(const Eigen::Vector3d& uvd, const SE3& T_w_c) {
  StereoPoint point;
  point.left.px = uvd.head<2>();
  point.disparity_px = uvd.z();
  point.sigma_px = 0.5;
  point.sigma_disparity_px = 0.1;
  // n^T p = 1 of the wall; disparities on it change by the baseline times n.
  const Eigen::Vector3d normal = T_w_c.rotation().conjugate() * Eigen::Vector3d(-kSlant, 0.0, 1.0);
  const double distance = normal.dot(kCamera.Backproject(uvd));
  point.disparity_slope = kCamera.baseline_m / distance * normal.head<2>();
  point.slope_information.setConstant(1e4);
  return point;
}

RefinementOptions On() {
  RefinementOptions options;
  options.enabled = true;
  return options;
}

/// The wall seen from the first camera and from another one; corners of the second view are 0.8 pixels off.
struct Scene {
  explicit Scene(const SE3& T_w_second, bool with_image = true, double gain = 1.0) : T_w_c(T_w_second) {
    const Wall wall;
    StereoFeatures first_features;
    StereoFeatures second_features;
    std::mt19937_64 random(11);
    std::normal_distribution<double> normal(0.0, 0.8);
    for (int i = 0; i < 80; ++i) {
      const Eigen::Vector2d px(60.0 + 20.3 * (i % 10), 50.0 + 19.7 * (i / 10));
      const Eigen::Vector3d p_w = Wall::Meet(SE3(), px);
      const Eigen::Vector3d uvd = kCamera.ProjectStereo(T_w_c.Inverse() * p_w);
      if (!kCamera.InImage(uvd.head<2>(), 15.0)) continue;
      first_features.points.push_back(PointAt(kCamera.ProjectStereo(p_w), SE3()));
      truth.push_back(uvd);
      StereoPoint second = PointAt(uvd, T_w_c);
      const Eigen::Vector2d slid(normal(random), normal(random));
      second.left.px += slid;
      second.disparity_px += second.disparity_slope.dot(slid);
      second_features.points.push_back(second);
      matches.push_back({static_cast<int>(matches.size()), static_cast<int>(matches.size())});
    }
    first = TrackedFrame(first_features, with_image ? ImageLevels(wall.Render(SE3())) : ImageLevels());
    int64_t next_id = 0;
    landmarks.Found(SE3(), first, next_id);
    refiner.Remember({&landmarks}, SE3(), first);
    frame = TrackedFrame(second_features, with_image ? ImageLevels(wall.Render(T_w_c, gain)) : ImageLevels());
  }

  std::vector<RefinedPoint> Refine() const { return refiner.Refine(landmarks, matches, frame, T_w_c); }

  SE3 T_w_c;
  PointLandmarks landmarks{kCamera, OrbOptions(), LandmarkOptions()};
  PointRefiner refiner{kCamera, On()};
  TrackedFrame first{StereoFeatures()};
  TrackedFrame frame{StereoFeatures()};
  std::vector<LandmarkMatch> matches;
  std::vector<Eigen::Vector3d> truth;
};

SE3 Second() { return SE3(ExpSO3(Eigen::Vector3d(0.02, -0.08, 0.1)), Eigen::Vector3d(0.15, -0.05, 0.25)); }

TEST(PointRefiner, CornersThatSlidAreBroughtBack) {
  for (const double gain : {1.0, 0.7}) {
    const Scene scene(Second(), true, gain);
    const std::vector<RefinedPoint> refined = scene.Refine();
    EXPECT_GT(refined.size(), 0.7 * static_cast<double>(scene.matches.size())) << gain;
    double squared_px = 0.0;
    double squared_disparity_px = 0.0;
    for (const RefinedPoint& r : refined) {
      squared_px += (r.point.left.px - scene.truth[r.feature].head<2>()).squaredNorm() / 2.0;
      squared_disparity_px += std::pow(r.point.disparity_px - scene.truth[r.feature].z(), 2);
      EXPECT_LT(r.point.sigma_px, 0.5);
    }
    const auto n = static_cast<double>(refined.size());
    EXPECT_LT(std::sqrt(squared_px / n), 0.15) << gain;
    EXPECT_LT(std::sqrt(squared_disparity_px / n), 0.05) << gain;
  }
}

TEST(PointRefiner, WithoutImagesOrSwitchedOffNothingIsRefined) {
  EXPECT_TRUE(Scene(Second(), false).Refine().empty());
  Scene scene(Second());
  scene.frame.image = ImageLevels();
  EXPECT_TRUE(scene.Refine().empty());
  RefinementOptions off = On();
  off.enabled = false;
  scene = Scene(Second());
  scene.refiner = PointRefiner(kCamera, off);
  scene.refiner.Remember({&scene.landmarks}, SE3(), scene.first);
  EXPECT_TRUE(scene.Refine().empty());
}

TEST(PointRefiner, WhatIsHiddenKeepsItsCorner) {
  Scene scene(Second());
  scene.frame.image = ImageLevels(cv::Mat(kCamera.height_px, kCamera.width_px, CV_8UC1, cv::Scalar(80)));
  EXPECT_TRUE(scene.Refine().empty());
}

TEST(PointRefiner, ACornerFarFromThePatchIsKept) {
  Scene scene(Second());
  const size_t before = scene.Refine().size();
  scene.frame.features.points[scene.Refine().front().feature].left.px.x() += 10.0;
  EXPECT_EQ(scene.Refine().size(), before - 1);
}

TEST(PointRefiner, LandmarksThatAreNoMoreAreForgotten) {
  Scene scene(Second());
  ASSERT_FALSE(scene.Refine().empty());
  const PointLandmarks none(kCamera, OrbOptions(), LandmarkOptions());
  scene.refiner.Remember({&none}, scene.T_w_c, scene.frame);
  EXPECT_TRUE(scene.Refine().empty());
}

TEST(PointRefiner, LearningFromASecondSightChangesNoPlaceByMuch) {
  Scene scene(Second());
  const std::vector<RefinedPoint> before = scene.Refine();
  for (size_t i = 0; i < scene.matches.size(); ++i) {
    scene.frame.point_tracks[i] = {scene.landmarks.landmarks()[i].id, 1, -1};
  }
  scene.refiner.Remember({&scene.landmarks}, scene.T_w_c, scene.frame);
  const std::vector<RefinedPoint> after = scene.Refine();
  ASSERT_EQ(after.size(), before.size());
  for (size_t i = 0; i < after.size(); ++i) {
    EXPECT_LT((after[i].point.left.px - before[i].point.left.px).norm(), 0.1) << i;
  }
}

}  // namespace
}  // namespace plslam
