// SPDX-License-Identifier: BSD-3-Clause
#include "core/bus/messages/loop_channel.h"

#include <limits>

#include <gtest/gtest.h>

#include "tests/unit/bus/bus_fixture.h"

namespace plslam::bus {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

SE3 PoseOf(int64_t i) {
  Vector6d twist;
  twist << 0.1, -0.2, 0.3, 0.01, 0.02, -0.03;
  return SE3::Exp(static_cast<double>(i) * twist);
}

LoopClosure ClosureOf(int64_t keyframe_id, int n_poses) {
  LoopClosure closure;
  closure.kind = LoopClosure::Kind::kLoop;
  closure.keyframe.session = 5;
  closure.keyframe.number = keyframe_id;
  closure.t_ns = 77 * keyframe_id;
  closure.map_version = {{-4, 2}, -3, 12};
  closure.more = true;
  closure.score = 0.25;
  closure.detect_ms = 1.5;
  closure.correct_ms = 33.0;
  closure.edges.push_back({2, 40, PoseOf(3), 1e-4 * Matrix6d::Identity(), 80, 9});
  for (int i = 0; i < n_poses; ++i) {
    closure.points.push_back({2 * i, 2 * i + 1});
    closure.lines.push_back({i + 1, i});
    closure.poses.push_back({3 * i, PoseOf(i)});
    closure.names.push_back({3 * i, {i % 2 - 7, i}});
  }
  return closure;
}

void ExpectEqual(const LoopClosure& a, const LoopClosure& b) {
  EXPECT_EQ(a.kind, b.kind);
  EXPECT_EQ(a.keyframe, b.keyframe);
  EXPECT_EQ(a.t_ns, b.t_ns);
  EXPECT_EQ(a.map_version, b.map_version);
  EXPECT_EQ(a.more, b.more);
  EXPECT_EQ(a.score, b.score);
  EXPECT_EQ(a.detect_ms, b.detect_ms);
  EXPECT_EQ(a.correct_ms, b.correct_ms);
  EXPECT_EQ(a.points, b.points);
  EXPECT_EQ(a.lines, b.lines);
  EXPECT_EQ(a.names, b.names);
  ASSERT_EQ(a.edges.size(), b.edges.size());
  for (size_t i = 0; i < a.edges.size(); ++i) {
    EXPECT_EQ(a.edges[i].old_keyframe_id, b.edges[i].old_keyframe_id);
    EXPECT_EQ(a.edges[i].keyframe_id, b.edges[i].keyframe_id);
    EXPECT_EQ(a.edges[i].covariance, b.edges[i].covariance);
    EXPECT_LT((a.edges[i].T_old_kf.Inverse() * b.edges[i].T_old_kf).Log().norm(), 1e-15);
    EXPECT_EQ(a.edges[i].n_points, b.edges[i].n_points);
    EXPECT_EQ(a.edges[i].n_lines, b.edges[i].n_lines);
  }
  ASSERT_EQ(a.poses.size(), b.poses.size());
  for (size_t i = 0; i < a.poses.size(); ++i) {
    EXPECT_EQ(a.poses[i].keyframe_id, b.poses[i].keyframe_id);
    EXPECT_EQ(a.poses[i].T_w_kf.translation(), b.poses[i].T_w_kf.translation());
  }
}

class LoopClosurePages : public testing::TestWithParam<std::tuple<int, int>> {};

TEST_P(LoopClosurePages, AreSmallEnoughAndGiveTheSameClosure) {
  const auto [n_poses, page_bytes] = GetParam();
  const LoopClosure closure = ClosureOf(41, n_poses);
  const auto pages = CutIntoPages(closure, page_bytes);
  LoopClosureAssembler assembler;
  for (size_t i = 0; i < pages.size(); ++i) {
    EXPECT_LE(pages[i].getEncodedSize(), page_bytes);
    ASSERT_EQ(assembler.Add(pages[i]), i + 1 == pages.size() ? PageOutcome::kComplete : PageOutcome::kTaken) << i;
  }
  ExpectEqual(assembler.Take(), closure);
}

INSTANTIATE_TEST_SUITE_P(Sizes, LoopClosurePages,
                         testing::Combine(testing::Values(0, 1, 3000), testing::Values(1200, 60'000)));

TEST(LoopClosurePages, InvalidClosuresAreNotSent) {
  LoopClosure closure = ClosureOf(41, 3);
  closure.poses[1].T_w_kf = SE3(Eigen::Quaterniond::Identity(), {kNaN, 0.0, 0.0});
  EXPECT_THROW(CutIntoPages(closure, 60'000), std::invalid_argument);
  closure = ClosureOf(41, 3);
  std::swap(closure.poses[0], closure.poses[1]);
  EXPECT_THROW(CutIntoPages(closure, 60'000), std::invalid_argument);
  closure = ClosureOf(41, 0);
  closure.edges[0].old_keyframe_id = 41;
  EXPECT_THROW(CutIntoPages(closure, 60'000), std::invalid_argument);
}

TEST(LoopClosurePages, HostilePagesAreRefused) {
  const loop_closure_t page = CutIntoPages(ClosureOf(41, 2), 60'000)[0];
  LoopClosureAssembler assembler;
  const auto expect_refused = [&](auto change) {
    loop_closure_t hostile = page;
    change(hostile);
    EXPECT_EQ(assembler.Add(hostile), PageOutcome::kNonsense);
  };
  expect_refused([](loop_closure_t& p) { p.kind = 3; });
  expect_refused([](loop_closure_t& p) { p.more = 2; });
  expect_refused([](loop_closure_t& p) { p.session_keyframe_id = -1; });
  expect_refused([](loop_closure_t& p) { p.score = kNaN; });
  expect_refused([](loop_closure_t& p) { p.n_pages = 0; });
  expect_refused([](loop_closure_t& p) { p.edges[0].covariance[0] = -1.0; });
  expect_refused([](loop_closure_t& p) { p.edges[0].T_old_kf.q_wxyz[0] = 3.0; });
  expect_refused([](loop_closure_t& p) { p.points[0].a = p.points[0].b; });
  expect_refused([](loop_closure_t& p) { p.poses[1].keyframe_id = p.poses[0].keyframe_id; });
  expect_refused([](loop_closure_t& p) { p.names[1].keyframe_id = p.names[0].keyframe_id; });
  expect_refused([](loop_closure_t& p) { p.names[0].session_keyframe_id = -1; });
  EXPECT_EQ(assembler.Add(page), PageOutcome::kComplete);
}

TEST(Relocalisation, RoundTripThroughAMessage) {
  Relocalisation there;
  there.session = 9;
  there.frame_id = 4;
  there.t_ns = 123;
  there.found = true;
  there.map_version = {{76, 1}, 77, 5};
  there.keyframe_id = 3;
  there.T_w_c = PoseOf(2);
  there.covariance = 1e-3 * Matrix6d::Identity();
  there.n_points = 50;
  there.n_lines = 7;
  const auto back = FromMessage(ToMessage(there));
  ASSERT_TRUE(back);
  EXPECT_EQ(back->session, there.session);
  EXPECT_EQ(back->frame_id, there.frame_id);
  EXPECT_EQ(back->t_ns, there.t_ns);
  EXPECT_EQ(back->found, there.found);
  EXPECT_EQ(back->map_version, there.map_version);
  EXPECT_EQ(back->keyframe_id, there.keyframe_id);
  EXPECT_EQ(back->T_w_c.translation(), there.T_w_c.translation());
  EXPECT_EQ(back->covariance, there.covariance);
  EXPECT_EQ(back->n_points, there.n_points);
  relocalisation_t hostile = ToMessage(there);
  hostile.T_w_c.position_m[1] = kNaN;
  EXPECT_FALSE(FromMessage(hostile));
  hostile = ToMessage(there);
  hostile.found = 5;
  EXPECT_FALSE(FromMessage(hostile));
}

TEST(LoopClosureChannel, LateReaderGetsAllOverALossyNetwork) {
  BusOptions options;
  options.url = test::PrivateUrl();
  options.max_message_bytes = 1200;
  options.drop_fraction = 0.05;
  test::Waiter received;
  std::vector<LoopClosure> closures;
  test::RunningBus publisher(options, "loop");
  LoopClosurePublisher pages(*publisher);
  for (int id = 0; id < 20; ++id) pages.Publish(ClosureOf(id + 41, 10 * id));
  test::RunningBus reader(options, "mapping");
  LoopClosureSubscriber subscriber(*reader, [&](const LoopClosure& closure) {
    closures.push_back(closure);
    received.Add();
  });
  reader.Start();
  ASSERT_TRUE(received.Reaches(20)) << received.value();
  reader.Join();
  for (int id = 0; id < 20; ++id) ExpectEqual(closures[static_cast<size_t>(id)], ClosureOf(id + 41, 10 * id));
  EXPECT_EQ(reader->counters().rejected, 0);
}

}  // namespace
}  // namespace plslam::bus
