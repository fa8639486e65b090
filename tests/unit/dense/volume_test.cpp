// SPDX-License-Identifier: BSD-3-Clause
#include "dense_process/volume.h"

#include <gtest/gtest.h>

#include <vector>

#include "dense_process/body_mask.h"
#include "dense_process/surface.h"

namespace plslam::dense {
namespace {

constexpr double kVoxel_m = 0.05;

/// Rays from `eye` to the plane z = `z_m`, one a voxel.
std::vector<DepthRay> PlaneRays(double z_m, double half_m = 1.0) {
  std::vector<DepthRay> rays;
  for (double y = -half_m; y <= half_m; y += kVoxel_m) {
    for (double x = -half_m; x <= half_m; x += kVoxel_m) rays.push_back({{x, y, z_m}, 1.0F, 100.0F});
  }
  return rays;
}

TEST(Volume, PlaneIsFoundToAFractionOfAVoxel) {
  Volume volume(kVoxel_m);
  for (int i = 0; i < 3; ++i) volume.Integrate({0.1 * i, 0.0, 0.0}, PlaneRays(2.017));
  const Surface surface = ExtractSurface(volume);
  ASSERT_GT(surface.vertices.size(), 1000U);
  for (const Surface::Vertex& vertex : surface.vertices) {
    EXPECT_NEAR(vertex.p.z(), 2.017F, 0.01F);
    EXPECT_LT(vertex.normal.z(), -0.9F) << "towards the eye";
    EXPECT_EQ(vertex.grey, 100);
  }
  for (const auto& [a, b, c] : surface.triangles) {
    const Eigen::Vector3f u = surface.vertices[b].p - surface.vertices[a].p;
    const Eigen::Vector3f v = surface.vertices[c].p - surface.vertices[a].p;
    EXPECT_LT(u.cross(v).z(), 0.0F) << "counter-clockwise, seen from the eye";
  }
}

TEST(Volume, SpaceBehindASurfaceIsUnknown) {
  Volume volume(kVoxel_m);
  volume.Integrate(Eigen::Vector3d::Zero(), PlaneRays(2.0));
  const Volume::Reader reader(volume);
  EXPECT_TRUE(reader.At({0, 0, 20})) << "free";
  EXPECT_TRUE(reader.At({0, 0, 40})) << "the surface";
  EXPECT_FALSE(reader.At({0, 0, 45}));
  EXPECT_FALSE(reader.At({100, 0, 20})) << "no ray";
}

TEST(Volume, WhatHasGoneIsRemoved) {
  Volume volume(kVoxel_m);
  for (int i = 0; i < 3; ++i) volume.Integrate(Eigen::Vector3d::Zero(), PlaneRays(1.0, 0.3));
  ASSERT_FALSE(ExtractSurface(volume).vertices.empty());
  for (int i = 0; i < 10; ++i) volume.Integrate(Eigen::Vector3d::Zero(), PlaneRays(2.0));
  for (const Surface::Vertex& vertex : ExtractSurface(volume).vertices) EXPECT_GT(vertex.p.z(), 1.9F);
}

TEST(Volume, AddedVolumeMovesRigidly) {
  Volume one(kVoxel_m);
  for (int i = 0; i < 3; ++i) one.Integrate(Eigen::Vector3d::Zero(), PlaneRays(2.0));
  const SE3 T_two_one = SE3::Exp((Vector6d() << 0.03, -0.4, 0.21, 0.1, 0.2, -0.3).finished());
  Volume two(kVoxel_m);
  two.Add(one, T_two_one);
  Surface moved = ExtractSurface(two);
  ASSERT_GT(moved.vertices.size(), 1000U);
  Move(T_two_one.Inverse(), moved);
  for (const Surface::Vertex& vertex : moved.vertices) EXPECT_NEAR(vertex.p.z(), 2.0F, 0.015F);
}

TEST(Volume, SmallMotionKeepsTheVoxels) {
  Volume one(kVoxel_m);
  one.Integrate(Eigen::Vector3d::Zero(), PlaneRays(2.0));
  Volume two(kVoxel_m);
  two.Add(one, SE3());
  EXPECT_EQ(two.n_voxels(), one.n_voxels());
}

TEST(BodyMask, HullOfABodyAndItsMarginAreLeftOut) {
  const BodyPixels bodies{{0, {{100, 100}, {200, 100}, {200, 180}, {100, 180}, {150, 120}, {140, 140}}},
                          {1, {{300, 20}}}};
  const cv::Mat in_use = MaskBodies({}, {400, 300}, bodies);
  EXPECT_EQ(in_use.at<uint8_t>(140, 150), 0);
  EXPECT_EQ(in_use.at<uint8_t>(92, 150), 0) << "margin";
  EXPECT_EQ(in_use.at<uint8_t>(60, 150), 255);
  EXPECT_EQ(in_use.at<uint8_t>(20, 300), 255) << "one feature is no body";
}

}  // namespace
}  // namespace plslam::dense
