// SPDX-License-Identifier: BSD-3-Clause
#include "core/map/vertical.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <stdexcept>

namespace plslam {
namespace {

constexpr double kDeg = M_PI / 180.0;

/// A map whose w is rotated by `q_w_level` from a world with up -y: cameras that lean by `lean_deg` at most, and lines.
class LeaningMap {
 public:
  explicit LeaningMap(const Eigen::Quaterniond& q_w_level, double lean_deg = 8.0) : q_w_level_(q_w_level) {
    for (int id = 0; id < 30; ++id) {
      MapKeyframe keyframe;
      keyframe.id = id;
      const Eigen::Quaterniond heading = ExpSO3({0, 0.2 * static_cast<double>(id), 0});
      keyframe.T_w_kf = SE3(q_w_level_ * heading * ExpSO3({lean_deg * kDeg, 0, lean_deg * kDeg * Uniform()}),
                            {1.0 * static_cast<double>(id), 0, 0});
      map_.Put(keyframe);
    }
  }

  /// Lines along a direction of the level world, each turned by a random angle of this standard deviation.
  void AddLines(int n, const Eigen::Vector3d& direction, double sigma_deg) {
    for (int i = 0; i < n; ++i) {
      const Eigen::Vector3d turn = sigma_deg * kDeg * Eigen::Vector3d{Normal(), Normal(), Normal()};
      AddLine((2.0 + Uniform()) * (ExpSO3(turn) * direction.normalized()));
    }
  }

  void AddLinesAnywhere(int n) {
    for (int i = 0; i < n; ++i) AddLine(Eigen::Vector3d{Normal(), Normal(), Normal()}.normalized());
  }

  /// Gives each keyframe a measured vertical, wrong by a random angle of this standard deviation besides a common one.
  void MeasureUp(double sigma_deg, double random_deg, double common_deg) {
    const Eigen::Quaterniond common = ExpSO3({common_deg * kDeg, 0, 0});
    for (int id = 0; id < 30; ++id) {
      MapKeyframe keyframe = *map_.FindKeyframe(id);
      const Eigen::Quaterniond error = ExpSO3(random_deg * kDeg * Eigen::Vector3d{Normal(), Normal(), Normal()});
      keyframe.up = UpDirection{keyframe.T_w_kf.rotation().conjugate() * (common * error * up_w()), sigma_deg * kDeg};
      map_.Put(keyframe);
    }
  }

  Eigen::Vector3d up_w() const { return q_w_level_ * -Eigen::Vector3d::UnitY(); }
  const Map& map() const { return map_; }

 private:
  double Normal() { return std::normal_distribution<double>()(random_); }
  double Uniform() { return std::uniform_real_distribution<double>(-1.0, 1.0)(random_); }

  void AddLine(const Eigen::Vector3d& v_level) {
    MapLine line;
    line.id = next_id_++;
    line.segment_w.p = Eigen::Vector3d{10.0 * Normal(), Normal(), 10.0 * Normal()};
    // Upwards and downwards, as the brighter side has it.
    line.segment_w.q = line.segment_w.p + (line.id.value % 2 == 0 ? 1.0 : -1.0) * (q_w_level_ * v_level);
    map_.Put(line);
  }

  Eigen::Quaterniond q_w_level_;
  Map map_;
  LandmarkId next_id_ = 0;
  std::mt19937 random_{11};
};

double AngleDeg(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::acos(std::min(1.0, a.dot(b))) / kDeg;
}

TEST(Vertical, TiltedMapIsRecoveredFromItsLines) {
  for (const double tilt_deg : {0.0, 7.0, 25.0}) {
    LeaningMap leaning(ExpSO3({0.8 * tilt_deg * kDeg, 0.4, 0.6 * tilt_deg * kDeg}));
    leaning.AddLines(120, {0, 1, 0}, 0.7);
    leaning.AddLines(150, {1, 0, 0.2}, 0.7);
    leaning.AddLines(60, {0.3, 1, 0}, 1.0);  // a slanted roof, 17 degrees off
    leaning.AddLinesAnywhere(100);
    const Vertical vertical = VerticalOf(leaning.map());
    EXPECT_EQ(vertical.source, VerticalSource::kLines) << tilt_deg;
    EXPECT_GT(vertical.n, 80) << tilt_deg;
    EXPECT_LT(AngleDeg(vertical.up_w, leaning.up_w()), 0.3) << "tilted by " << tilt_deg << " degrees";
    EXPECT_GT(AngleDeg(MeanUpOfCameras(leaning.map()), leaning.up_w()), 1.0) << "the cameras alone would be worse";
  }
}

// A camera that looks down at a table by 30 degrees.
TEST(Vertical, IsThatOfHorizontalSurfaces) {
  std::mt19937 random(3);
  std::normal_distribution<double> scatter(0.0, 5.0 * kDeg);
  const Eigen::Vector3d about(0, -1, 0);
  const Eigen::Quaterniond q_w_level = ExpSO3({-30.0 * kDeg, 0, 0});
  std::vector<Eigen::Vector3d> normals;
  const auto add = [&](const Eigen::Vector3d& normal_level, int n) {
    for (int i = 0; i < n; ++i)
      normals.push_back(q_w_level * ExpSO3({scatter(random), scatter(random), scatter(random)}) * normal_level);
  };
  add({0, -1, 0}, 1500);
  add({0, 0, -1}, 2000);                                 // monitors
  add(Eigen::Vector3d(0.4, -1, 0.2).normalized(), 300);  // clutter
  const auto vertical = VerticalFromNormals(normals, about);
  ASSERT_TRUE(vertical);
  EXPECT_EQ(vertical->source, VerticalSource::kSurfaces);
  EXPECT_LT(AngleDeg(vertical->up_w, q_w_level * Eigen::Vector3d(0, -1, 0)), 1.0);
  EXPECT_FALSE(VerticalFromNormals(std::span(normals).first(100), about)) << "too few";
  std::vector<Eigen::Vector3d> hedge;
  for (int i = 0; i < 5000; ++i)
    hedge.push_back(Eigen::Vector3d(scatter(random), scatter(random), scatter(random)).normalized());
  EXPECT_FALSE(VerticalFromNormals(hedge, about)) << "all directions";
}

TEST(Vertical, WithoutLinesFromTheCameras) {
  const LeaningMap leaning(ExpSO3({0.3, 0, 0}), 0.0);
  EXPECT_FALSE(VerticalFromLines(leaning.map(), leaning.up_w()));
  const Vertical vertical = VerticalOf(leaning.map());
  EXPECT_EQ(vertical.source, VerticalSource::kCameras);
  EXPECT_LT(AngleDeg(vertical.up_w, leaning.up_w()), 1e-5);
}

TEST(Vertical, NoUprightLinesGiveNone) {
  LeaningMap level(Eigen::Quaterniond::Identity());
  level.AddLines(200, {1, 0, 0}, 1.0);
  level.AddLines(7, {0, 1, 0}, 0.1);
  EXPECT_FALSE(VerticalFromLines(level.map(), level.up_w())) << "seven lines are chance";
  LeaningMap cloud(Eigen::Quaterniond::Identity());
  cloud.AddLinesAnywhere(3000);
  EXPECT_FALSE(VerticalFromLines(cloud.map(), cloud.up_w())) << "no direction stands out";
}

TEST(Vertical, GravityIsUsedWhereItIsKnown) {
  LeaningMap leaning(ExpSO3({0.3, 0, 0.2}));
  leaning.AddLines(120, {0, 1, 0.1}, 0.7);  // a leaning tower
  leaning.MeasureUp(0.3, 0.2, 0.1);
  const Vertical vertical = VerticalOf(leaning.map());
  EXPECT_EQ(vertical.source, VerticalSource::kGravity);
  EXPECT_EQ(vertical.n, 30);
  EXPECT_LT(AngleDeg(vertical.up_w, leaning.up_w()), 0.3);
  EXPECT_NEAR(vertical.sigma_rad, 0.3 * kDeg, 1e-6) << "errors in common are not averaged";
}

TEST(Vertical, ScatterOfGravityIsInItsSigma) {
  LeaningMap leaning(ExpSO3({0.3, 0, 0.2}));
  leaning.MeasureUp(0.1, 0.8, 0.0);
  const auto vertical = VerticalFromGravity(leaning.map());
  ASSERT_TRUE(vertical);
  EXPECT_GT(vertical->sigma_rad, 0.6 * kDeg);
  EXPECT_LT(vertical->sigma_rad, 1.0 * kDeg);
}

TEST(Vertical, UncertainGravityChoosesTheLines) {
  LeaningMap leaning(ExpSO3({0.3, 0, 0.2}), 50.0);
  leaning.AddLines(120, {0, 1, 0}, 0.7);
  leaning.AddLines(150, {0, 1, 1.4}, 0.7);
  leaning.MeasureUp(3.0, 0.1, 5.0);
  const Vertical vertical = VerticalOf(leaning.map());
  EXPECT_EQ(vertical.source, VerticalSource::kLines);
  EXPECT_LT(AngleDeg(vertical.up_w, leaning.up_w()), 4.0 * vertical.sigma_rad / kDeg);
}

TEST(Vertical, SigmaOfLinesCoversTheirError) {
  int covered = 0;
  for (int seed = 0; seed < 20; ++seed) {
    LeaningMap leaning(ExpSO3({0.02 * seed, 0, 0.2}));
    leaning.AddLines(40 + seed, {0, 1, 0}, 0.8);
    const Vertical vertical = VerticalOf(leaning.map());
    covered += AngleDeg(vertical.up_w, leaning.up_w()) < 3.0 * vertical.sigma_rad / kDeg ? 1 : 0;
  }
  EXPECT_GE(covered, 19);
}

TEST(Vertical, GivenByTheMounting) {
  // All cameras look down by 50 degrees, so their own vertical misleads.
  LeaningMap leaning(ExpSO3({0.2, 0.3, -0.1}), 0.0);
  const Eigen::Quaterniond down = ExpSO3({-50.0 * kDeg, 0, 0});
  Map map;
  for (const auto& [id, keyframe] : leaning.map().keyframes()) {
    MapKeyframe turned = keyframe;
    turned.T_w_kf = SE3(keyframe.T_w_kf.rotation() * down, keyframe.T_w_kf.translation());
    map.Put(turned);
  }
  EXPECT_GT(AngleDeg(VerticalOf(map).up_w, leaning.up_w()), 2.0);
  const Eigen::Vector3d up_c = down.conjugate() * -Eigen::Vector3d::UnitY();
  const Vertical vertical = VerticalOf(map, {3.0 * up_c.x(), 3.0 * up_c.y(), 3.0 * up_c.z()});
  EXPECT_EQ(vertical.source, VerticalSource::kGiven);
  EXPECT_LT(AngleDeg(vertical.up_w, leaning.up_w()), 1e-5);
  EXPECT_EQ(VerticalOf(map, {}).up_w, VerticalOf(map).up_w);
  EXPECT_THROW(VerticalOf(map, {0.0, -1.0}), std::invalid_argument);
  EXPECT_THROW(VerticalOf(map, {0.0, 0.0, 0.0}), std::invalid_argument);
  EXPECT_THROW(VerticalOf(map, {0.0, std::nan(""), 1.0}), std::invalid_argument);
}

TEST(Vertical, EmptyMapAndInvalidLines) {
  EXPECT_EQ(VerticalOf(Map()).up_w, Eigen::Vector3d(0, -1, 0));
  Map map;
  for (int id = 0; id < 20; ++id) {
    MapLine line;
    line.id = id;
    if (id % 2 == 0) line.segment_w.q = {0, std::nan(""), 0};
    map.Put(line);
  }
  EXPECT_FALSE(VerticalFromLines(map, {0, -1, 0}));
}

TEST(Vertical, LevelRotationPutsUpToMinusY) {
  const Eigen::Vector3d up_w = Eigen::Vector3d(0.2, -0.9, 0.3).normalized();
  EXPECT_LT((LevelRotation(up_w) * up_w - Eigen::Vector3d(0, -1, 0)).norm(), 1e-12);
  EXPECT_LT(LevelRotation({0, -1, 0}).angularDistance(Eigen::Quaterniond::Identity()), 1e-12);
}

}  // namespace
}  // namespace plslam
