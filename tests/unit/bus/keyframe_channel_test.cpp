// SPDX-License-Identifier: BSD-3-Clause
#include "core/bus/messages/keyframe_channel.h"

#include <cmath>
#include <limits>
#include <random>

#include <gtest/gtest.h>

#include "core/files/archive.h"
#include "plslam/keyframe_t.hpp"
#include "tests/unit/bus/bus_fixture.h"

namespace plslam::bus {
namespace {

using Outcome = PageOutcome;

InertialInterval IntervalOf(int n_samples) {
  InertialInterval interval;
  interval.from_ns = -1'000'000'000;
  interval.to_ns = 1'500'000'000;
  for (int i = 0; i < n_samples; ++i)
    interval.samples.push_back({1000 + int64_t{i} * 5'000'000, {0.1 * i, -0.2, 0.3}, {9.8, 0.01 * i, -0.5}});
  interval.T_c_imu = SE3(ExpSO3({0.1, 0.2, 0.3}), Eigen::Vector3d(0.01, 0.02, 0.03));
  interval.noise = {1e-3, 2e-5, 3e-3, 4e-4};
  interval.bias = {{{0.01, 0.02, 0.03}, {0.1, 0.2, 0.3}}, 1e-3, 2e-2};
  return interval;
}

Keyframe KeyframeOf(int64_t id, int n_points, int n_lines) {
  std::mt19937_64 random(static_cast<uint64_t>(id));
  Keyframe keyframe;
  keyframe.name.session = 5;
  keyframe.t_ns = 1000 + id;
  keyframe.name.number = id;
  keyframe.frame_id = FrameId(3 * id);
  keyframe.previous_keyframe_id = id - 1;
  keyframe.covariance = 1e-4 * Matrix6d::Identity();
  if (id % 2 == 1) keyframe.up = UpDirection{Eigen::Vector3d(0.6, -0.8, 0.0), 0.01};
  if (id % 2 == 1) keyframe.inertial = IntervalOf(700);
  keyframe.state = 1;
  keyframe.lockstep = id % 2 == 1;
  keyframe.camera = {400.0, 320.5, 240.25, 0.12, 640, 480, -3, 5, 250.5};
  for (int i = 0; i < n_points; ++i) {
    StereoPoint point;
    point.left.px = {static_cast<float>(i), 2.5};
    point.disparity_px = i % 2 == 0 ? 4.25 : -1.0;
    point.left.octave = i % 8;
    point.left.descriptor = {random(), random(), random(), random()};
    keyframe.features.points.push_back(point);
    keyframe.point_landmark_ids.push_back(i - 1);
    keyframe.point_map_ids.push_back(2 * i - 1);
  }
  for (int i = 0; i < n_lines; ++i) {
    StereoLine line;
    line.left.segment = {{static_cast<float>(i), 1.0}, {7.5, 8.5}};
    line.disparity_p_px = i % 2 == 0 ? 3.0 : -1.0;
    line.disparity_q_px = 2.0;
    line.left.descriptor = {random(), random(), random(), random()};
    keyframe.features.lines.push_back(line);
    keyframe.line_landmark_ids.push_back(-1);
    keyframe.line_map_ids.push_back(i / 2 - 1);
  }
  return keyframe;
}

void ExpectEqual(const Keyframe& a, const Keyframe& b) {
  EXPECT_EQ(a.name, b.name);
  EXPECT_EQ(a.frame_id, b.frame_id);
  EXPECT_EQ(a.t_ns, b.t_ns);
  EXPECT_EQ(a.covariance, b.covariance);
  EXPECT_EQ(a.camera, b.camera);
  ASSERT_EQ(a.up.has_value(), b.up.has_value());
  EXPECT_TRUE(!a.up || (a.up->direction == b.up->direction && a.up->sigma_rad == b.up->sigma_rad));
  EXPECT_EQ(archive::ToBytes(a.inertial), archive::ToBytes(b.inertial));
  EXPECT_EQ(a.point_landmark_ids, b.point_landmark_ids);
  EXPECT_EQ(a.line_landmark_ids, b.line_landmark_ids);
  EXPECT_EQ(a.point_map_ids, b.point_map_ids);
  EXPECT_EQ(a.line_map_ids, b.line_map_ids);
  EXPECT_EQ(a.lockstep, b.lockstep);
  ASSERT_EQ(a.features.points.size(), b.features.points.size());
  ASSERT_EQ(a.features.lines.size(), b.features.lines.size());
  for (size_t i = 0; i < a.features.points.size(); ++i) {
    EXPECT_EQ(a.features.points[i].left.px, b.features.points[i].left.px);
    EXPECT_EQ(a.features.points[i].disparity_px, b.features.points[i].disparity_px);
    EXPECT_EQ(a.features.points[i].left.octave, b.features.points[i].left.octave);
    EXPECT_EQ(a.features.points[i].left.descriptor, b.features.points[i].left.descriptor);
  }
  for (size_t i = 0; i < a.features.lines.size(); ++i) {
    EXPECT_EQ(a.features.lines[i].left.segment.p, b.features.lines[i].left.segment.p);
    EXPECT_EQ(a.features.lines[i].HasDepth(), b.features.lines[i].HasDepth());
    EXPECT_EQ(a.features.lines[i].left.descriptor, b.features.lines[i].left.descriptor);
  }
}

class KeyframePages : public testing::TestWithParam<std::tuple<int, int, int>> {};

TEST_P(KeyframePages, AreSmallEnoughAndGiveTheSameKeyframe) {
  const auto [n_points, n_lines, page_bytes] = GetParam();
  const Keyframe keyframe = KeyframeOf(3, n_points, n_lines);
  const auto pages = CutIntoPages(keyframe, page_bytes);
  KeyframeAssembler assembler;
  for (size_t i = 0; i < pages.size(); ++i) {
    EXPECT_LE(pages[i].getEncodedSize(), page_bytes);
    ASSERT_EQ(assembler.Add(pages[i]), i + 1 == pages.size() ? Outcome::kComplete : Outcome::kTaken) << i;
  }
  ExpectEqual(assembler.Take(), keyframe);
}

INSTANTIATE_TEST_SUITE_P(Sizes, KeyframePages,
                         testing::Combine(testing::Values(0, 1, 2000), testing::Values(0, 1, 500),
                                          testing::Values(1200, 60'000)));

TEST(KeyframeAssembler, RefusesPagesOutOfPlace) {
  const auto pages = CutIntoPages(KeyframeOf(3, 100, 100), 1200);
  ASSERT_GT(pages.size(), 3U);
  KeyframeAssembler assembler;
  EXPECT_EQ(assembler.Add(pages[1]), Outcome::kPassedOver) << "does not begin with page 0";
  EXPECT_EQ(assembler.Add(pages[0]), Outcome::kTaken);
  EXPECT_EQ(assembler.Add(pages[2]), Outcome::kPassedOver) << "page 1 is missing";
  EXPECT_EQ(assembler.Add(pages[1]), Outcome::kPassedOver) << "what had come is dropped";
  EXPECT_EQ(assembler.Add(pages[0]), Outcome::kTaken);
  keyframe_t other = pages[1];
  other.keyframe_id = 4;
  EXPECT_EQ(assembler.Add(other), Outcome::kPassedOver);
}

TEST(KeyframeAssembler, RefusesHostilePages) {
  KeyframeAssembler assembler;
  keyframe_t page = CutIntoPages(KeyframeOf(3, 1, 1), 60'000)[0];
  const auto expect_refused = [&](auto change) {
    keyframe_t hostile = page;
    change(hostile);
    EXPECT_EQ(assembler.Add(hostile), Outcome::kNonsense);
  };
  expect_refused([](keyframe_t& p) { p.n_pages = 0; });
  expect_refused([](keyframe_t& p) { p.n_pages = 2'000'000'000; });
  expect_refused([](keyframe_t& p) { p.page = -1; });
  expect_refused([](keyframe_t& p) { p.keyframe_id = -1; });
  expect_refused([](keyframe_t& p) { p.previous_keyframe_id = p.keyframe_id; });
  expect_refused([](keyframe_t& p) { p.state = 17; });
  expect_refused([](keyframe_t& p) { p.covariance[0] = -1.0; });
  expect_refused([](keyframe_t& p) { p.T_odom_kf.q_wxyz[0] = 5.0; });
  expect_refused([](keyframe_t& p) { p.up_kf[0] = 0.5; });
  expect_refused([](keyframe_t& p) { p.up_sigma_rad = -1.0; });
  expect_refused([](keyframe_t& p) { p.lockstep = 2; });
  expect_refused([](keyframe_t& p) { p.imu.to_ns = p.imu.from_ns - 1; });
  expect_refused([](keyframe_t& p) { p.imu.to_ns = std::numeric_limits<int64_t>::max(); });
  expect_refused([](keyframe_t& p) { p.imu.T_kf_imu.q_wxyz[0] = 5.0; });
  expect_refused([](keyframe_t& p) { p.imu.accelerometer_m_s2_sqrt_hz = 0.0; });
  expect_refused([](keyframe_t& p) { p.imu.force_bias_sigma_m_s2 = -1.0; });
  expect_refused([](keyframe_t& p) { p.imu.rate_bias_rad_s[1] = std::nan(""); });
  expect_refused([](keyframe_t& p) { p.imu_samples[1].t_ns = p.imu_samples[0].t_ns; });
  expect_refused([](keyframe_t& p) { p.imu_samples[0].force_m_s2[2] = std::nan(""); });
  expect_refused([](keyframe_t& p) { p.points[0].u_px = 1e30F; });
  expect_refused([](keyframe_t& p) { p.points[0].map_id = -2; });
  expect_refused([](keyframe_t& p) { p.lines[0].map_id = -2; });
  EXPECT_EQ(assembler.Add(page), Outcome::kComplete);
}

TEST(CutIntoPages, RefusesListsOfIdsOfAnotherLength) {
  Keyframe keyframe = KeyframeOf(0, 2, 2);
  keyframe.line_landmark_ids.pop_back();
  EXPECT_THROW(CutIntoPages(keyframe, 60'000), std::invalid_argument);
  keyframe = KeyframeOf(0, 2, 2);
  keyframe.point_map_ids.pop_back();
  EXPECT_THROW(CutIntoPages(keyframe, 60'000), std::invalid_argument);
}

TEST(CutIntoPages, NoIdsOfTheMapArriveAsNone) {
  Keyframe keyframe = KeyframeOf(0, 2, 3);
  keyframe.point_map_ids.clear();
  keyframe.line_map_ids.clear();
  KeyframeAssembler assembler;
  ASSERT_EQ(assembler.Add(CutIntoPages(keyframe, 60'000)[0]), Outcome::kComplete);
  const Keyframe received = assembler.Take();
  EXPECT_EQ(received.point_map_ids, std::vector<LandmarkId>(2, -1));
  EXPECT_EQ(received.line_map_ids, std::vector<LandmarkId>(3, -1));
}

TEST(KeyframeChannel, LateReaderGetsAllKeyframesOverALossyNetwork) {
  BusOptions options;
  options.url = test::PrivateUrl();
  options.max_message_bytes = 1200;
  options.drop_fraction = 0.05;
  test::Waiter received;
  std::vector<Keyframe> keyframes;
  test::RunningBus publisher(options, "vo");
  KeyframePublisher pages(*publisher);
  for (int id = 0; id < 10; ++id) pages.Publish(KeyframeOf(id, 200, 50));
  test::RunningBus reader(options, "viewer");
  KeyframeSubscriber subscriber(*reader, [&](const Keyframe& keyframe) {
    keyframes.push_back(keyframe);
    received.Add();
  });
  reader.Start();
  ASSERT_TRUE(received.Reaches(10)) << received.value();
  reader.Join();
  for (int id = 0; id < 10; ++id) {
    ExpectEqual(keyframes[static_cast<size_t>(id)], KeyframeOf(id, 200, 50));
    EXPECT_EQ(keyframes[static_cast<size_t>(id)].source, SourceId(publisher->source()));
  }
  EXPECT_EQ(reader->counters().rejected, 0);
}

}  // namespace
}  // namespace plslam::bus
