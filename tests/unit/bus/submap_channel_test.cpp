// SPDX-License-Identifier: BSD-3-Clause
#include "core/bus/messages/submap_channel.h"

#include <gtest/gtest.h>

#include <limits>
#include <mutex>
#include <thread>

#include "core/bus/channels.h"
#include "tests/unit/bus/bus_fixture.h"

namespace plslam::bus {
namespace {

using Changes = SubmapPublisher::Changes;

/// Enough points for several pages, `step_m` apart along x.
SubmapCloud Line(double step_m, size_t n = 10'000) {
  SubmapCloud submap{7, 12, SE3(Eigen::Quaterniond::Identity(), {1.0, 2.0, 3.0}), {}};
  for (size_t i = 0; i < n; ++i) {
    submap.points.push_back({{static_cast<float>(step_m * static_cast<double>(i)), 0.0F, 1.0F},
                             {0, 0, -127},
                             static_cast<uint8_t>(i % 251)});
  }
  return submap;
}

/// A publisher and a subscriber, each with a bus that runs.
class SubmapChannel : public testing::Test {
 protected:
  ~SubmapChannel() override {
    sender_.Stop();
    reader_.Stop();
    sends_.join();
    reads_.join();
  }
  static BusOptions Options(const std::string& url) {
    BusOptions options;
    options.url = url;
    return options;
  }
  /// Returns the cloud after `n` submaps.
  SurfaceCloud CloudAfter(int64_t n) {
    EXPECT_TRUE(submaps_.Reaches(n));
    EXPECT_EQ(submaps_.value(), n);
    const std::lock_guard lock(mutex_);
    return cloud_;
  }

  const std::string url_ = test::PrivateUrl();
  Bus reader_{Options(url_), "reader"};
  Bus sender_{Options(url_), "dense"};
  test::Waiter submaps_;
  std::mutex mutex_;
  SurfaceCloud cloud_;
  SubmapSubscriber subscriber_{reader_, [this] {
                                 {
                                   const std::lock_guard lock(mutex_);
                                   cloud_ = subscriber_.cloud();
                                 }
                                 submaps_.Add();
                               }};
  SubmapPublisher publisher_{sender_};
  std::thread reads_{[this] { reader_.Run(); }}, sends_{[this] { sender_.Run(); }};
};

TEST_F(SubmapChannel, CarriesPointsInPages) {
  SurfaceCloud cloud{0.05, {{0, Line(0.05)}, {1, Line(0.1, 3)}}};
  ASSERT_GT(CutIntoPages({{0, 1}, 0, 0.05, false, cloud.submaps[0]}, sender_.page_bytes()).size(), 2U);
  publisher_.Publish(cloud, Changes::kSurfaces);
  const SurfaceCloud received = CloudAfter(2);
  EXPECT_EQ(received.voxel_m, 0.05);
  ASSERT_EQ(received.submaps.size(), 2U);
  const SubmapCloud& submap = received.submaps.at(0);
  EXPECT_EQ(submap.points, cloud.submaps[0].points);
  EXPECT_EQ(submap.anchor_session, SessionId(7));
  EXPECT_EQ(submap.anchor_frame_id, FrameId(12));
  EXPECT_EQ(submap.T_w_anchor.translation(), Eigen::Vector3d(1.0, 2.0, 3.0));
  EXPECT_EQ(publisher_.n_submaps(), 2);
}

TEST_F(SubmapChannel, MovedSubmapKeepsItsPoints) {
  SurfaceCloud cloud{0.05, {{0, Line(0.05)}}};
  publisher_.Publish(cloud, Changes::kSurfaces);
  cloud.submaps[0].T_w_anchor = SE3(Eigen::Quaterniond(0.0, 1.0, 0.0, 0.0), {4.0, 5.0, 6.0});
  publisher_.Publish(cloud, Changes::kSurfaces);
  publisher_.Publish(cloud, Changes::kSurfaces);  // no change
  const SurfaceCloud received = CloudAfter(2);
  EXPECT_EQ(received.submaps.at(0).T_w_anchor.translation(), Eigen::Vector3d(4.0, 5.0, 6.0));
  EXPECT_EQ(received.submaps.at(0).points, cloud.submaps[0].points);
}

TEST_F(SubmapChannel, SmallChangesComeOnlyAtTheEnd) {
  SurfaceCloud cloud{0.05, {{0, Line(0.05)}}};
  publisher_.Publish(cloud, Changes::kSurfaces);
  for (SurfacePoint& point : cloud.submaps[0].points) point.p.z() += 0.002F;
  publisher_.Publish(cloud, Changes::kSurfaces);
  EXPECT_EQ(publisher_.n_submaps(), 1);
  publisher_.Publish(cloud, Changes::kAll);
  EXPECT_EQ(CloudAfter(2).submaps.at(0).points, cloud.submaps[0].points);
}

TEST_F(SubmapChannel, SubmapWithoutAPlaceIsEmptied) {
  publisher_.Publish({0.05, {{0, Line(0.05, 20)}, {1, Line(0.05, 20)}}}, Changes::kSurfaces);
  publisher_.Publish({0.05, {{1, Line(0.05, 20)}}}, Changes::kSurfaces);
  publisher_.Publish({0.05, {{1, Line(0.05, 20)}}}, Changes::kSurfaces);
  EXPECT_EQ(CloudAfter(3).n_points(), 20U);
}

TEST_F(SubmapChannel, OtherSurfacesReplaceAll) {
  publisher_.Publish({0.05, {{0, Line(0.05, 20)}, {1, Line(0.05, 20)}}}, Changes::kSurfaces);
  publisher_.Replace();
  publisher_.Publish({0.2, {{0, Line(0.2, 5)}}}, Changes::kSurfaces);
  const SurfaceCloud received = CloudAfter(3);
  EXPECT_EQ(received.n_points(), 5U);
  EXPECT_EQ(received.voxel_m, 0.2);
}

TEST_F(SubmapChannel, NewestPublisherReplacesTheOther) {
  test::Waiter arrived;
  reader_.Subscribe<submap_t>(kSubmap, [&](const submap_t&) { arrived.Add(); });
  publisher_.Publish({0.05, {{0, Line(0.05, 20)}, {1, Line(0.05, 20)}}}, Changes::kSurfaces);
  EXPECT_TRUE(arrived.Reaches(2));
  test::RunningBus restarted(Options(url_), "dense");
  restarted.Start();
  SubmapPublisher newest(*restarted);
  newest.Publish({0.05, {{0, Line(0.05, 7)}}}, Changes::kSurfaces);
  EXPECT_TRUE(arrived.Reaches(3));
  // The last messages of the killed one arrive late.
  publisher_.Publish({0.05, {{0, Line(0.07, 30)}, {1, Line(0.05, 20)}}}, Changes::kSurfaces);
  EXPECT_TRUE(arrived.Reaches(4));
  EXPECT_EQ(CloudAfter(3).n_points(), 7U);
}

TEST_F(SubmapChannel, InvalidSubmapsAreCounted) {
  const auto page = [&](const auto& spoil) {
    submap_t message = CutIntoPages({{0, 1}, 0, 0.05, false, Line(0.05, 4)}, sender_.page_bytes()).front();
    spoil(message);
    sender_.Publish(kSubmap, message);
  };
  page([](submap_t& m) { m.points[2].y_m = std::numeric_limits<float>::quiet_NaN(); });
  page([](submap_t& m) { m.voxel_m = 0.0; });
  page([](submap_t& m) { m.submap = -1; });
  page([](submap_t& m) { m.T_w_anchor.q_wxyz[0] = 3.0; });
  page([](submap_t& m) { m.only_moved = 1; });  // a submap that was never sent
  page([](submap_t&) {});
  EXPECT_EQ(CloudAfter(1).n_points(), 4U);
  EXPECT_EQ(reader_.counters().rejected, 5);
}

}  // namespace
}  // namespace plslam::bus
