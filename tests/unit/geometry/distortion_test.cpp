// SPDX-License-Identifier: BSD-3-Clause
#include "core/geometry/distortion.h"

#include <cmath>
#include <stdexcept>

#include <gtest/gtest.h>
#include <opencv2/calib3d.hpp>

namespace plslam {
namespace {

CameraCalibration Lens(const std::string& model, std::vector<double> distortion) {
  CameraCalibration c;
  c.model = model;
  c.distortion = std::move(distortion);
  return c;
}

const std::vector<CameraCalibration>& Lenses() {
  static const std::vector<CameraCalibration> lenses{
      Lens("pinhole", {}),
      Lens("radtan", {-0.28340811, 0.07395907, 0.00019359, 1.76187114e-05}),
      Lens("radtan", {0.2624, -0.9531, -0.0054, 0.0026, 1.1633}),
      Lens("equidistant",
           {0.0034823894022493434, 0.0007150348452162257, -0.0020532361418706202, 0.00020293673591811182}),
      Lens("rational", {7.1, 2.3, 0.00031, -0.00012, 0.08, 7.4, 3.9, 0.41}),
      Lens("rational", {-0.28, 0.07, 0.0002, 1.8e-05, 0.01, 0.02, -0.003, 0.001}),
      Lens("double_sphere", {-0.18, 0.59}),
      Lens("double_sphere", {0.32, 0.41})};
  return lenses;
}

TEST(Distortion, UndistortInvertsDistort) {
  for (const CameraCalibration& lens : Lenses()) {
    const Distortion d(lens);
    const double reach = std::min(0.9 * d.max_radius(), 3.0);
    for (double r = 0.0; r <= reach; r += 0.05) {
      for (double angle = 0.0; angle < 6.0; angle += 1.0) {
        const Eigen::Vector2d xy(r * std::cos(angle), r * std::sin(angle));
        const auto distorted = d.Distort(xy);
        ASSERT_TRUE(distorted);
        const auto back = d.Undistort(*distorted);
        ASSERT_TRUE(back) << lens.model << " at radius " << r;
        EXPECT_LT((*back - xy).norm(), 1e-8) << lens.model << " at radius " << r;
      }
    }
  }
}

TEST(Distortion, ManyPointsAreDistortedAsOneIs) {
  for (const CameraCalibration& lens : Lenses()) {
    const Distortion d(lens);
    std::vector<double> x;
    std::vector<double> y;
    for (double r = 0.0; r < 1.2 * d.max_radius(); r += 0.013 * d.max_radius()) {
      x.push_back(r * std::cos(17.0 * r));
      y.push_back(r * std::sin(17.0 * r));
    }
    const std::vector<double> x0 = x;
    const std::vector<double> y0 = y;
    d.Distort(x, y);
    for (size_t i = 0; i < x.size(); ++i) {
      const auto one = d.Distort(Eigen::Vector2d(x0[i], y0[i]));
      ASSERT_EQ(one.has_value(), !std::isnan(x[i])) << lens.model;
      ASSERT_EQ(one.has_value(), !std::isnan(y[i])) << lens.model;
      if (!one) continue;
      EXPECT_EQ(x[i], one->x()) << lens.model;
      EXPECT_EQ(y[i], one->y()) << lens.model;
    }
  }
}

TEST(Distortion, JacobianMatchesDifferences) {
  for (const CameraCalibration& lens : Lenses()) {
    const Distortion d(lens);
    for (const Eigen::Vector2d& xy :
         {Eigen::Vector2d(0.0, 0.0), Eigen::Vector2d(0.3, -0.2), Eigen::Vector2d(-0.4, 0.4)}) {
      const Eigen::Matrix2d J = d.Jacobian(xy);
      for (int i = 0; i < 2; ++i) {
        const Eigen::Vector2d step = 1e-6 * Eigen::Vector2d::Unit(i);
        const Eigen::Vector2d numeric = (*d.Distort(xy + step) - *d.Distort(xy - step)) / 2e-6;
        EXPECT_LT((J.col(i) - numeric).norm(), 1e-7) << lens.model << " at " << xy.transpose();
      }
    }
  }
}

// r (1 - 0.3 r^2) grows up to r = 1 / sqrt(0.9).
TEST(Distortion, NothingBeyondTheTurningPoint) {
  const Distortion d(Lens("radtan", {-0.3, 0.0, 0.0, 0.0}));
  const double turning = 1.0 / std::sqrt(0.9);
  EXPECT_NEAR(d.max_radius(), turning, 1e-6);
  EXPECT_FALSE(d.Distort({1.01 * turning, 0.0}));
  const double edge = turning * (1.0 - 0.3 * turning * turning);
  EXPECT_TRUE(d.Undistort({0.999 * edge, 0.0}));
  EXPECT_FALSE(d.Undistort({1.001 * edge, 0.0}));
  EXPECT_FALSE(d.Undistort({100.0, -100.0}));
}

TEST(Distortion, FisheyeHasNoPlaneBehindTheCamera) {
  const Distortion d(Lens("equidistant", {0.0, 0.0, 0.0, 0.0}));
  EXPECT_TRUE(d.Undistort({1.4, 0.0}));
  EXPECT_FALSE(d.Undistort({1.6, 0.0}));
}

TEST(Distortion, NanIsRefused) {
  for (const CameraCalibration& lens : Lenses()) {
    EXPECT_FALSE(Distortion(lens).Distort({std::nan(""), 0.0}));
    EXPECT_FALSE(Distortion(lens).Undistort({0.0, std::nan("")}));
  }
}

// OpenCV's result for the same coefficients.
TEST(Distortion, EqualsOpenCv) {
  for (const CameraCalibration& lens : Lenses()) {
    if (lens.model == "double_sphere") continue;
    const Distortion d(lens);
    std::vector<cv::Point3d> points;
    std::vector<cv::Point2d> pixels;
    const double reach = std::min(0.95 * d.max_radius(), 2.0);
    for (double r = 0.01; r <= reach; r += 0.03)
      points.emplace_back(r * std::cos(31.0 * r), r * std::sin(31.0 * r), 1.0);
    const cv::Vec3d zero(0.0, 0.0, 0.0);
    if (lens.model == "equidistant") {
      cv::fisheye::projectPoints(points, pixels, zero, zero, cv::Matx33d::eye(), lens.distortion);
    } else {
      cv::projectPoints(points, zero, zero, cv::Matx33d::eye(), lens.distortion, pixels);
    }
    for (size_t i = 0; i < points.size(); ++i) {
      const auto ours = d.Distort(Eigen::Vector2d(points[i].x, points[i].y));
      ASSERT_TRUE(ours) << lens.model;
      EXPECT_NEAR(ours->x(), pixels[i].x, 1e-10) << lens.model << " at " << points[i];
      EXPECT_NEAR(ours->y(), pixels[i].y, 1e-10) << lens.model << " at " << points[i];
    }
  }
}

// The published formula of a point (x, y, z) anywhere, which does not change with the point's distance.
TEST(Distortion, DoubleSphereMatchesThePaper) {
  for (const CameraCalibration& lens : Lenses()) {
    if (lens.model != "double_sphere") continue;
    const double xi = lens.distortion[0];
    const double alpha = lens.distortion[1];
    const Distortion d(lens);
    for (const Eigen::Vector3d& p : {Eigen::Vector3d(0.3, -0.2, 0.7), Eigen::Vector3d(-4.0, 1.0, 2.0),
                                     Eigen::Vector3d(0.0, 0.001, 3.0), Eigen::Vector3d(1.0, 2.0, 0.9)}) {
      const double d1 = p.norm();
      const double d2 = std::hypot(p.x(), p.y(), xi * d1 + p.z());
      const Eigen::Vector2d published = p.head<2>() / (alpha * d2 + (1.0 - alpha) * (xi * d1 + p.z()));
      const auto ours = d.Distort(p.hnormalized());
      ASSERT_TRUE(ours) << p.transpose();
      EXPECT_LT((*ours - published).norm(), 1e-12) << p.transpose();
    }
    EXPECT_DOUBLE_EQ(d.CentreScale(), 1.0 / (1.0 + xi));
  }
}

// 1 - 0.5 r^2 is 0 at sqrt(2): the radius grows without bound before it, and changes sign after it.
TEST(Distortion, NothingBeyondAPole) {
  const Distortion d(Lens("rational", {0.0, 0.0, 0.0, 0.0, 0.0, -0.5, 0.0, 0.0}));
  EXPECT_NEAR(d.max_radius(), std::sqrt(2.0), 1e-6);
  EXPECT_TRUE(d.Distort({1.4, 0.0}));
  EXPECT_FALSE(d.Distort({1.5, 0.0}));
}

TEST(Distortion, WrongModelsAreNamed) {
  EXPECT_THROW(Distortion(Lens("rational", {0.1, 0.1, 0.1, 0.1, 0.1})), std::runtime_error);
  EXPECT_THROW(Distortion(Lens("double_sphere", {0.1})), std::runtime_error);
  EXPECT_THROW(Distortion(Lens("omni", {})), std::runtime_error);
  EXPECT_THROW(Distortion(Lens("radtan", {0.1})), std::runtime_error);
  EXPECT_THROW(Distortion(Lens("equidistant", {0.1, 0.1, 0.1, 0.1, 0.1})), std::runtime_error);
  EXPECT_THROW(Distortion(Lens("pinhole", {0.1})), std::runtime_error);
  EXPECT_THROW(Distortion(Lens("radtan", {std::nan(""), 0.0, 0.0, 0.0})), std::runtime_error);
}

}  // namespace
}  // namespace plslam
