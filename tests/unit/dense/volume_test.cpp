// SPDX-License-Identifier: BSD-3-Clause
#include "dense_process/volume.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "dense_process/body_mask.h"
#include "dense_process/dense_map.h"
#include "dense_process/surface.h"
#include "tests/support/text_file.h"

namespace plslam::dense {
namespace {

constexpr double kVoxel_m = 0.05;

constexpr StereoCamera kSmallCamera{
    .f_px = 100.0, .cx_px = 40.0, .cy_px = 30.0, .baseline_m = 0.1, .width_px = 80, .height_px = 60};

/// Depth of a plane parallel to the image.
DepthImage Flat(double z_m) {
  DepthImage depth;
  depth.z_m = cv::Mat(kSmallCamera.height_px, kSmallCamera.width_px, CV_32F, cv::Scalar(z_m));
  depth.sigma_m = cv::Mat(kSmallCamera.height_px, kSmallCamera.width_px, CV_32F, cv::Scalar(0.01));
  return depth;
}

/// Adds a keyframe with this depth; its pose is among `poses`.
void AddKeyframe(const KeyframeFrame& name, const DepthImage& depth, const KeyframePoses& poses, DenseMap& map) {
  const cv::Mat grey(kSmallCamera.height_px, kSmallCamera.width_px, CV_8U, cv::Scalar(90));
  EXPECT_TRUE(map.Add(name, depth, grey, kSmallCamera, poses));
}

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

TEST(Volume, BoundedRaysRemoveObstaclesOnly) {
  const auto count = [](const Volume& volume) {
    int n = 0;
    for (const Surface::Vertex& vertex : ExtractSurface(volume).vertices) n += vertex.p.z() < 1.1F ? 1 : 0;
    return n;
  };
  const auto person = [] {
    Volume volume(kVoxel_m);
    for (int i = 0; i < 3; ++i) volume.Integrate(Eigen::Vector3d::Zero(), PlaneRays(1.0, 0.3));
    return volume;
  };
  // Ends beyond the person, and around.
  const auto ends = [](double z_m) {
    std::vector<Eigen::Vector3d> points;
    for (const DepthRay& ray : PlaneRays(z_m)) points.push_back(ray.end);
    return points;
  };
  Volume volume = person();
  const size_t n_known = volume.n_voxels();
  ASSERT_GT(count(volume), 50);
  for (int i = 0; i < 3; ++i) volume.Clear(Eigen::Vector3d::Zero(), ends(2.0));
  EXPECT_EQ(count(volume), 0);
  EXPECT_EQ(volume.n_voxels(), n_known) << "unknown space stays unknown";
  volume = person();
  const int before = count(volume);
  for (int i = 0; i < 10; ++i) volume.Clear(Eigen::Vector3d::Zero(), ends(1.1));
  EXPECT_EQ(count(volume), before) << "a bound just behind it proves nothing";
}

/// No depth, but a lower bound of 2 m.
DepthImage BlankWall() {
  DepthImage wall;
  wall.z_m = wall.sigma_m = cv::Mat::zeros(60, 80, CV_32F);
  wall.at_least_m = cv::Mat(60, 80, CV_32F, cv::Scalar(2.0));
  return wall;
}

/// Adds the first three keyframes of a session, at the origin, with the same depth.
void AddThree(SessionId session, const DepthImage& depth, KeyframePoses& poses, DenseMap& map) {
  for (int64_t i = 0; i < 3; ++i) {
    poses[{session, FrameId(i)}] = SE3();
    AddKeyframe({session, FrameId(i)}, depth, poses, map);
  }
}

TEST(DenseMap, LaterBoundsClearEarlierSubmaps) {
  const DepthImage person = Flat(1.0);
  KeyframePoses poses;
  DenseMap map(kVoxel_m, 0.0);
  AddThree(SessionId(1), person, poses, map);
  ASSERT_FALSE(ExtractSurface(map.Merge(poses, SE3())).vertices.empty());
  AddThree(SessionId(2), BlankWall(), poses, map);
  EXPECT_EQ(map.n_submaps(), 2U);
  EXPECT_TRUE(ExtractSurface(map.Merge(poses, SE3())).vertices.empty());
  // Also after a restart, and after a correction that moves both.
  const std::string path = testing::TempDir() + "bounds.surfaces";
  map.Write(path, poses, poses);
  for (auto& [name, pose] : poses) pose = SE3::Exp((Vector6d() << 0.3, -0.4, 0.2, 0.1, 0.2, -0.3).finished());
  EXPECT_TRUE(ExtractSurface(DenseMap::Read(path, 0.0).Merge(poses, SE3())).vertices.empty());
  // The person is there again if only the second submap moves away: its proof was about another place.
  for (int64_t i = 0; i < 3; ++i) poses[{2, FrameId(i)}] = SE3(Eigen::Quaterniond::Identity(), {50.0, 0.0, 0.0});
  EXPECT_FALSE(ExtractSurface(map.Merge(poses, SE3())).vertices.empty());
}

// A box that is put before a wall after the wall was seen.
TEST(DenseMap, BoundsLeaveLaterObstacles) {
  KeyframePoses poses;
  DenseMap map(kVoxel_m, 0.0);
  AddThree(SessionId(1), BlankWall(), poses, map);
  AddThree(SessionId(2), Flat(1.0), poses, map);
  const size_t n = ExtractSurface(map.Merge(poses, SE3())).vertices.size();
  EXPECT_GT(n, 0U);
  // Also when the map has removed the keyframes of the wall, and after a restart.
  KeyframePoses lasting = poses;
  for (int64_t i = 0; i < 3; ++i) lasting.erase({1, FrameId(i)});
  poses[{3, FrameId(0)}] = lasting[{3, FrameId(0)}] = SE3();
  AddKeyframe({3, FrameId(0)}, Flat(1.0), poses, map);
  map.FollowRemovals(poses, lasting, kSmallCamera);
  EXPECT_GE(ExtractSurface(map.Merge(poses, SE3())).vertices.size(), n);
  const std::string path = testing::TempDir() + "later.surfaces";
  map.Write(path, poses, lasting);
  EXPECT_GE(ExtractSurface(DenseMap::Read(path, 0.0).Merge(lasting, SE3())).vertices.size(), n);
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

/// Adds what each of these keyframes sees: a plane at 2 m.
void AddPlanes(const KeyframePoses& poses, DenseMap& map) {
  for (const auto& [name, pose] : poses) AddKeyframe(name, Flat(2.0), poses, map);
}

KeyframePoses PosesOfPlanes() {
  return {{{1, 0}, SE3()}, {{1, 5}, SE3()}, {{2, 0}, SE3(Eigen::Quaterniond::Identity(), {3.0, 0.0, 0.0})}};
}

/// A map with two submaps of planes.
DenseMap TwoPlanes() {
  DenseMap map(kVoxel_m, 0.0);
  AddPlanes(PosesOfPlanes(), map);
  return map;
}

TEST(SurfacesFile, GivesTheSameMap) {
  const DenseMap map = TwoPlanes();
  const std::string path = testing::TempDir() + "planes.surfaces";
  map.Write(path, PosesOfPlanes(), PosesOfPlanes());
  const DenseMap read = DenseMap::Read(path, 0.0);
  EXPECT_EQ(read.n_submaps(), 2U);
  EXPECT_TRUE(read.Has({1, 5}));
  EXPECT_FALSE(read.Has({3, 5}));
  const Surface one = ExtractSurface(map.Merge(PosesOfPlanes(), SE3()));
  const Surface two = ExtractSurface(read.Merge(PosesOfPlanes(), SE3()));
  ASSERT_FALSE(one.vertices.empty());
  ASSERT_EQ(one.vertices.size(), two.vertices.size());
  for (size_t i = 0; i < one.vertices.size(); ++i) EXPECT_EQ(one.vertices[i].p, two.vertices[i].p);
}

TEST(DenseMap, SurfacePointsGoToTheirSubmaps) {
  KeyframePoses poses = PosesOfPlanes();
  poses[{2, 5}] = poses[{2, 0}];
  DenseMap map(kVoxel_m, 0.0);
  AddPlanes(poses, map);
  const auto split = [&](const KeyframePoses& at) { return map.Split(ExtractSurface(map.Merge(at, SE3())), at); };
  const SurfaceCloud cloud = split(poses);
  ASSERT_EQ(cloud.submaps.size(), 2U);
  EXPECT_EQ(cloud.n_points(), ExtractSurface(map.Merge(poses, SE3())).vertices.size());
  for (const auto& [number, submap] : cloud.submaps) {
    EXPECT_EQ(submap.anchor_session, SessionId(number + 1));
    EXPECT_GT(submap.points.size(), 300U);
    for (const SurfacePoint& point : submap.points) {
      EXPECT_NEAR(point.p.z(), 2.0, 0.02);
      EXPECT_LT(std::abs(point.p.x()), 1.0) << "seen from its own anchor";
      EXPECT_EQ(point.grey, 90);
    }
  }
  // A correction moves the anchor, and the points keep their places relative to it.
  KeyframePoses moved = poses;
  moved[{2, 0}] = SE3(Eigen::Quaterniond::Identity(), {10.0, 1.0, 0.0});
  const SurfaceCloud later = split(moved);
  EXPECT_EQ(later.submaps.at(1).T_w_anchor.translation(), Eigen::Vector3d(10.0, 1.0, 0.0));
  EXPECT_FALSE(HasOtherSurfaces(cloud.submaps.at(1).points, later.submaps.at(1).points, kVoxel_m, 10));
  // A submap whose first keyframe is unknown is anchored to the next one.
  const SurfaceCloud whole = split(poses);
  moved = poses;
  moved.erase({2, 0});
  EXPECT_EQ(split(moved).submaps.at(1).anchor_frame_id, FrameId(5));
  EXPECT_EQ(split(moved).n_points(), whole.n_points());
  EXPECT_EQ(map.CountUnplaced(moved), 0U);
  // Without a place in the map a submap has no points.
  moved.erase({2, 5});
  EXPECT_EQ(map.CountUnplaced(moved), 1U);
  EXPECT_FALSE(split(moved).submaps.contains(1));
}

/// Submaps of three views each: of a plane, of the same 0.1 m aside, of another plane, and the newest one, far from all.
class RemovedKeyframes : public testing::Test {
 protected:
  static SE3 At(double x_m) { return SE3(Eigen::Quaterniond::Identity(), {x_m, 0.0, 0.0}); }
  static KeyframePoses Views(int64_t session, double x_m) {
    KeyframePoses views;
    for (int64_t i = 0; i < 3; ++i) views[{SessionId(session), FrameId(i)}] = At(x_m);
    return views;
  }
  static void Erase(int64_t session, KeyframePoses& poses) {
    std::erase_if(poses, [session](const auto& view) { return view.first.first == SessionId(session); });
  }
  static std::vector<Surface::Vertex> Vertices(const DenseMap& map, const KeyframePoses& poses) {
    return ExtractSurface(map.Merge(poses, SE3())).vertices;
  }
  static float Leftmost(const DenseMap& map, const KeyframePoses& poses) {
    float x = 0.0F;
    for (const Surface::Vertex& vertex : Vertices(map, poses)) x = std::min(x, vertex.p.x());
    return x;
  }
  static int NearFour(const DenseMap& map, const KeyframePoses& poses) {
    int n = 0;
    for (const Surface::Vertex& vertex : Vertices(map, poses)) n += std::abs(vertex.p.x() - 4.0F) < 1.0F ? 1 : 0;
    return n;
  }
  RemovedKeyframes() {
    for (const auto& [session, x_m] : {std::pair(1, 0.0), {2, 0.1}, {3, 4.0}, {4, 9.0}}) {
      KeyframePoses views = Views(session, x_m);
      AddPlanes(views, map_);
      poses_.merge(views);
    }
  }

  KeyframePoses poses_;
  DenseMap map_{kVoxel_m, 0.0};
};

// A bounded map removes a keyframe for each that it inserts.
TEST_F(RemovedKeyframes, OldestWithoutASubmapAreForgotten) {
  std::vector<RemovedKeyframe> removed;
  for (int i = 0; i < 30; ++i) {
    RemovedKeyframe keyframe;
    keyframe.id = i;
    keyframe.session = i < 2 ? 1 : 9;
    keyframe.frame_id = i;
    removed.push_back(keyframe);
  }
  ASSERT_TRUE(map_.Members().contains({1, 0}));
  EXPECT_TRUE(RemovedToForget(removed, 30, map_.Members()).empty());
  const std::set<KeyframeId> forgotten = RemovedToForget(removed, 20, map_.Members());
  EXPECT_EQ(forgotten.size(), 12U) << "18 are left";
  EXPECT_FALSE(forgotten.contains(0)) << "its submap is placed by it";
  EXPECT_TRUE(forgotten.contains(2));
  EXPECT_FALSE(forgotten.contains(29));
}

TEST_F(RemovedKeyframes, ForgottenPlaceDisappears) {
  ASSERT_EQ(map_.n_submaps(), 4U);
  KeyframePoses lasting = poses_;
  map_.FollowRemovals(poses_, lasting, kSmallCamera);
  EXPECT_GT(NearFour(map_, poses_), 100) << "nothing was removed";
  Erase(3, lasting);
  map_.FollowRemovals(poses_, lasting, kSmallCamera);
  EXPECT_EQ(map_.n_submaps(), 3U);
  EXPECT_EQ(NearFour(map_, poses_), 0);
  EXPECT_TRUE(map_.Has({3, 0})) << "it is not fused again";
  EXPECT_LT(Leftmost(map_, poses_), -0.5F) << "the other places stay";
  // It does not return with the place, which is elsewhere then.
  KeyframePoses later = lasting;
  later.merge(Views(5, 4.1));
  map_.FollowRemovals(later, later, kSmallCamera);
  EXPECT_EQ(NearFour(map_, later), 0);
  const std::string path = testing::TempDir() + "forgotten.surfaces";
  map_.Write(path, poses_, lasting);
  EXPECT_EQ(DenseMap::Read(path, 0.0).n_submaps(), 3U);
}

TEST_F(RemovedKeyframes, RedundantOneMovesWithAnother) {
  const float before = Leftmost(map_, poses_);
  KeyframePoses lasting = poses_;
  Erase(1, lasting);
  ASSERT_GT(Leftmost(map_, lasting), before + 0.05F) << "only the removed keyframes saw the left border";
  map_.FollowRemovals(poses_, lasting, kSmallCamera);
  EXPECT_EQ(map_.n_submaps(), 3U);
  EXPECT_NEAR(Leftmost(map_, lasting), before, 0.02F);
  KeyframePoses moved = lasting;
  for (auto& [name, pose] : moved) {
    if (name.first == SessionId(2)) pose = At(0.5);
  }
  EXPECT_NEAR(Leftmost(map_, moved), before + 0.4F, 0.03F);
}

TEST_F(RemovedKeyframes, ManyVisitsNeedTheMemoryOfOne) {
  const size_t once = map_.bytes();
  KeyframePoses known = poses_;
  for (int64_t visit = 5; visit < 30; ++visit) {
    KeyframePoses views = Views(visit, 0.05);
    AddPlanes(views, map_);
    known.merge(views);
    map_.FollowRemovals(known, poses_, kSmallCamera);
  }
  EXPECT_LE(map_.n_submaps(), 5U);
  EXPECT_LT(static_cast<double>(map_.bytes()), 1.5 * static_cast<double>(once));
}

TEST_F(RemovedKeyframes, PlaceUnknownToTheMapWaits) {
  KeyframePoses known = poses_;
  Erase(3, known);
  map_.FollowRemovals(known, known, kSmallCamera);
  EXPECT_EQ(map_.n_submaps(), 4U) << "a map that is being received";
}

/// A person in a submap, whose front wall a later submap sees, and a loop that moves both a little apart.
TEST(DenseMap, CorrectionRestoresNothingCleared) {
  const DepthImage wall = Flat(2.0);
  DepthImage person = Flat(2.0);
  person.z_m(cv::Rect(20, 10, 40, 40)).setTo(1.2);
  DenseMap map(kVoxel_m, 0.0);
  KeyframePoses poses;
  const auto add = [&](int64_t session, int64_t frame, const DepthImage& depth) {
    const KeyframeFrame name{SessionId(session), FrameId(frame)};
    poses[name] = SE3();
    AddKeyframe(name, depth, poses, map);
  };
  const auto in_front = [&] {
    int n = 0;
    for (const Surface::Vertex& vertex : ExtractSurface(map.Merge(poses, SE3())).vertices)
      n += vertex.p.z() < 1.6F ? 1 : 0;
    return n;
  };
  for (int64_t i = 0; i < 3; ++i) add(1, i, person);
  EXPECT_GT(in_front(), 20);
  for (int64_t i = 0; i < 10; ++i) add(2, i, wall);
  EXPECT_EQ(in_front(), 0);
  for (auto& [name, pose] : poses) {
    if (name.first == SessionId(1)) pose = SE3::Exp((Vector6d() << 0.04, 0.03, 0.05, 0.0, 0.03, 0.0).finished());
  }
  EXPECT_EQ(in_front(), 0);
}

TEST(SurfacesFile, SubmapOfARemovedKeyframeHasAnotherAnchor) {
  const DenseMap map = TwoPlanes();
  const std::string path = testing::TempDir() + "removed.surfaces";
  KeyframePoses lasting = PosesOfPlanes();
  lasting.erase({1, 0});
  map.Write(path, PosesOfPlanes(), lasting);
  const Surface all = ExtractSurface(map.Merge(PosesOfPlanes(), SE3()));
  EXPECT_EQ(ExtractSurface(DenseMap::Read(path, 0.0).Merge(lasting, SE3())).vertices.size(), all.vertices.size());
}

TEST(SurfacesFile, DamageIsOneSentence) {
  const std::string path = testing::TempDir() + "damaged.surfaces";
  TwoPlanes().Write(path, PosesOfPlanes(), PosesOfPlanes());
  const std::string bytes = ReadText(path);
  for (const size_t at : {size_t{3}, size_t{60}, bytes.size() / 2, bytes.size() - 1}) {
    std::string damaged = bytes;
    damaged[at] = static_cast<char>(damaged[at] ^ 0x10);
    std::ofstream(path, std::ios::binary) << damaged;
    EXPECT_THROW(DenseMap::Read(path, 0.0), std::runtime_error) << at;
    std::ofstream(path, std::ios::binary) << bytes.substr(0, at);
    EXPECT_THROW(DenseMap::Read(path, 0.0), std::runtime_error) << at;
  }
}

TEST(SurfacesFile, ImpossibleVoxelsAreRefused) {
  Volume::Block block;
  block.known[0] = 1;
  block.sums = {0.5F, 1.0F, 20.0F};
  EXPECT_EQ(Volume::FromBlocks(kVoxel_m, std::vector{block}).n_voxels(), 1U);
  const auto refused = [](const Volume::Block& bad) {
    EXPECT_THROW(Volume::FromBlocks(kVoxel_m, std::vector{bad}), std::runtime_error);
  };
  Volume::Block bad = block;
  bad.origin = {1, 0, 0};
  refused(bad);
  bad = block;
  bad.sums.pop_back();
  refused(bad);
  bad = block;
  bad.sums.push_back(1.0F);
  refused(bad);
  for (const float value :
       {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(), -1.0F, 1e9F}) {
    bad = block;
    bad.sums[1] = value;
    refused(bad);
    bad = block;
    bad.sums[0] = value == -1.0F ? -2.0F : value;
    refused(bad);
  }
}

}  // namespace
}  // namespace plslam::dense
