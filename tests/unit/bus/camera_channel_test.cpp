// SPDX-License-Identifier: BSD-3-Clause
#include "core/bus/messages/frame_channel.h"

#include <gtest/gtest.h>

#include <stdexcept>
#include <vector>

#include "core/bus/messages/convert.h"
#include "plslam/camera_t.hpp"
#include "tests/unit/bus/bus_fixture.h"

namespace plslam::bus {
namespace {

RigCalibration RigOf(double focal_px) {
  RigCalibration rig;
  rig.name = "rig";
  rig.left.width_px = rig.right.width_px = 640;
  rig.left.height_px = rig.right.height_px = 480;
  for (CameraCalibration* camera : {&rig.left, &rig.right}) {
    camera->fx_px = camera->fy_px = focal_px;
    camera->cx_px = 320.0;
    camera->cy_px = 240.0;
  }
  rig.right.T_b_cam = SE3(Eigen::Quaterniond::Identity(), {0.1, 0.0, 0.0});
  rig.baseline_m = 0.1;
  rig.rate_hz = 20.0;
  return rig;
}

TEST(CameraChannel, ARepeatedCameraIsHeardOnceAndAnImpossibleOneIsRefused) {
  BusOptions options;
  options.url = test::PrivateUrl();
  test::Waiter heard, rejected, last;
  test::RunningBus reader(options, "vo");
  std::vector<double> focal_px;
  CameraSubscriber subscriber(
      *reader,
      [&](const RigCalibration& rig) {
        focal_px.push_back(rig.left.fx_px);
        heard.Add();
      },
      [&] { rejected.Add(); });
  reader.Start();
  Bus player(options, "player");
  const auto say = [&](const RigCalibration& rig) { player.Publish(kCamera, ToMessage(rig)); };
  // The newest of a latest channel wins, so each is repeated until it is heard.
  while (heard.value() < 1) say(RigOf(400.0));
  for (int i = 0; i < 20; ++i) say(RigOf(400.0));
  while (rejected.value() < 1) say(RigOf(-1.0));
  while (heard.value() < 2) say(RigOf(500.0));
  reader.Join();
  EXPECT_EQ(focal_px, (std::vector<double>{400.0, 500.0}));
}

TEST(CameraChannel, WhatOneHasKeptAnotherGoesOnWith) {
  BusOptions options;
  options.url = test::PrivateUrl();
  Bus bus(options, "vo");
  double focal_px = 0.0;
  CameraSubscriber subscriber(bus, [&](const RigCalibration& rig) { focal_px = rig.left.fx_px; });
  EXPECT_TRUE(subscriber.bytes().empty());
  const std::vector<uint8_t> kept = RigBytes(ToMessage(RigOf(400.0)));
  subscriber.Restore(kept);
  EXPECT_EQ(focal_px, 400.0);
  EXPECT_EQ(subscriber.bytes(), kept);
  EXPECT_THROW(subscriber.Restore({kept.begin(), kept.end() - 9}), std::runtime_error);
}

}  // namespace
}  // namespace plslam::bus
