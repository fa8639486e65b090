// SPDX-License-Identifier: BSD-3-Clause
#include "dense_process/node/live_products.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "core/bus/run_loop.h"
#include "tests/unit/bus/bus_fixture.h"

namespace plslam::dense {
namespace {

/// A map of one camera that is rolled by this angle.
Map RolledMap(double roll_deg) {
  MapKeyframe keyframe;
  keyframe.id = 0;
  const Eigen::AngleAxisd roll(roll_deg * M_PI / 180.0, Eigen::Vector3d::UnitZ());
  keyframe.T_w_kf = SE3(Eigen::Quaterniond(roll), Eigen::Vector3d::Zero());
  Map map;
  map.Put(keyframe);
  return map;
}

class LiveProductsTest : public testing::Test {
 protected:
  static bus::BusOptions Options() {
    bus::BusOptions options;
    options.url = bus::test::PrivateUrl();
    return options;
  }

  const DenseMap surfaces_{0.05, 0.0};
  bus::Bus bus_{Options(), "dense"};
  LiveProducts live_{bus_, 1.0, {}};
};

TEST_F(LiveProductsTest, IsMadeAgainAfterAWhileIfOld) {
  double now_ms = bus::NowMs();
  EXPECT_FALSE(live_.IsDue(now_ms)) << "nothing was fused";
  live_.Outdate();
  EXPECT_TRUE(live_.IsDue(now_ms));
  const double took_ms = live_.Publish(surfaces_, RolledMap(0.0), now_ms);
  const double pause_ms = std::max(2000.0, 10.0 * took_ms);
  EXPECT_FALSE(live_.IsDue(now_ms + 2.0 * pause_ms)) << "nothing has changed";
  live_.Outdate();
  EXPECT_FALSE(live_.IsDue(now_ms + pause_ms - 1.0));
  EXPECT_TRUE(live_.IsDue(now_ms + pause_ms));
  live_.PublishFinal(Products{{}, {}, false, 0.0, {}, surfaces_.Merge({}, SE3()), {}, {}, {}}, {});
  EXPECT_FALSE(live_.IsDue(now_ms + pause_ms)) << "the grid of the files has all surfaces";
}

TEST_F(LiveProductsTest, SmallChangesKeepItsVertical) {
  const auto up_after = [this](double roll_deg) {
    live_.Publish(surfaces_, RolledMap(roll_deg), bus::NowMs());
    return live_.vertical()->up_w;
  };
  EXPECT_FALSE(live_.vertical());
  const Eigen::Vector3d first = up_after(0.0);
  EXPECT_EQ(up_after(0.2), first);
  const Eigen::Vector3d turned = up_after(0.5);
  EXPECT_NEAR(std::acos(turned.dot(first)) * 180.0 / M_PI, 0.5, 1e-3);
  EXPECT_EQ(up_after(0.3), turned);
}

}  // namespace
}  // namespace plslam::dense
