// SPDX-License-Identifier: BSD-3-Clause
#include "tools/evaluate/accuracy.h"

#include <gmock/gmock.h>

#include "tests/unit/evaluate/pairs.h"

namespace plslam::evaluate {
namespace {

using testing::HasSubstr;
using testing::Not;

TEST(Accuracy, PerfectEstimateInAnotherFrame) {
  const Trajectory truth = SomePath(200);
  Trajectory estimate = truth;
  const SE3 move = SE3::Exp((Vector6d() << 4, 4, 4, 1, 1, 1).finished());
  for (TrajectoryPose& pose : estimate) pose.T_a_b = move * pose.T_a_b;
  const Accuracy a = EvaluateTrajectory(estimate, truth, {});
  EXPECT_EQ(a.coverage_percent, 100.0);
  EXPECT_LT(a.ate_m.max, 1e-9);
  EXPECT_LT(a.ate_deg.max, 1e-6);
  EXPECT_GT(a.kitti.segments, 0);
  EXPECT_LT(a.kitti.t_rel_percent, 1e-9);
  EXPECT_EQ(a.note, "");
}

// Errors of position across a straight path rotate the alignment of positions about it, by any angle.
TEST(Accuracy, RollOfAStraightPathIsNoError) {
  Trajectory truth;
  Trajectory estimate;
  for (int i = 0; i < 100; ++i) {
    const SE3 rolled(ExpSO3({0.0, 0.0, 0.001 * std::sin(i)}), Eigen::Vector3d(0.05 * std::sin(0.2 * i), 0.0, i));
    truth.push_back({i * 100'000'000LL, Translation(0.0, 0.05 * std::sin(0.2 * i), i)});
    estimate.push_back({i * 100'000'000LL, rolled});
  }
  const Accuracy a = EvaluateTrajectory(estimate, truth, {});
  EXPECT_LT(a.ate_m.max, 1e-3) << "positions fit after a quarter turn";
  EXPECT_LT(a.ate_deg.max, 0.1);
  EXPECT_NEAR(EvaluateTrajectory(truth, truth, {}).roll_sigma_deg.value(), 0.0, 1e-6);
  for (TrajectoryPose& pose : estimate)
    pose.T_a_b = SE3(pose.T_a_b.rotation(), {0.0, 0.0, pose.T_a_b.translation().z()});
  EXPECT_NEAR(EvaluateTrajectory(estimate, truth, {}).roll_sigma_deg.value(), 45.0, 1.0);
  EXPECT_NEAR(EvaluateTrajectory(truth, estimate, {}).roll_sigma_deg.value(), 90.0, 1e-9);
}

TEST(Accuracy, OrientationsFollowTheChosenAlignment) {
  const Trajectory truth = SomePath(50);
  Trajectory estimate = truth;
  const SE3 turn(ExpSO3({0.0, 0.2, 0.0}), Eigen::Vector3d::Zero());
  for (TrajectoryPose& pose : estimate) pose.T_a_b = turn * pose.T_a_b;
  EvaluateOptions options;
  options.alignment = Alignment::kNone;
  EXPECT_NEAR(EvaluateTrajectory(estimate, truth, options).ate_deg.mean, 0.2 * 180.0 / M_PI, 1e-9);
  EXPECT_FALSE(EvaluateTrajectory(estimate, truth, options).roll_sigma_deg.has_value());
  options.alignment = Alignment::kFirst;
  EXPECT_LT(EvaluateTrajectory(estimate, truth, options).ate_deg.max, 1e-6);
}

TEST(Accuracy, LostFramesShowInTheCoverage) {
  const Trajectory truth = SomePath(100);
  Trajectory estimate(truth.begin(), truth.begin() + 75);
  EXPECT_DOUBLE_EQ(EvaluateTrajectory(estimate, truth, {}).coverage_percent, 75.0);
  EvaluateOptions options;
  options.n_frames = 150;
  EXPECT_DOUBLE_EQ(EvaluateTrajectory(estimate, truth, options).coverage_percent, 50.0);
}

TEST(Accuracy, DegenerateInputsGiveASentenceAndNoNan) {
  const Trajectory path = SomePath(10);
  Trajectory later = path;
  for (TrajectoryPose& pose : later) pose.t_ns += 3'600'000'000'000;
  const Trajectory one(path.begin(), path.begin() + 1);
  const Trajectory still{{0, SE3()}, {100'000'000, SE3()}, {200'000'000, SE3()}};
  const std::vector<std::tuple<Trajectory, Trajectory, std::string>> cases{
      {{}, path, "the estimate has no pose"},
      {path, {}, "the truth has no pose"},
      {path, later, "no pose of the estimate is within 0.02 s of a true one"},
      {one, one, "only one pose: no motion can be evaluated"},
      {still, still, "the true path has length 0: no error per metre can be computed"}};
  for (const auto& [estimate, truth, note] : cases) {
    for (const auto kind : {Alignment::kNone, Alignment::kFirst, Alignment::kSe3, Alignment::kSim3}) {
      EvaluateOptions options;
      options.alignment = kind;
      options.keyframe_t_ns = {0, 100'000'000};
      options.covariances = {{0, Matrix6d::Zero()}};
      options.motion_covariances = options.covariances;
      const Accuracy a = EvaluateTrajectory(estimate, truth, options);
      EXPECT_EQ(a.note, note);
      // JSON has no NaN: the library writes null.
      auto json = ToJson(a);
      if (a.pairs.empty()) json.erase("ate_m");  // null, and means it
      EXPECT_THAT(json.dump(), Not(HasSubstr("null")));
      EXPECT_THAT(AccuracyTable(a), Not(HasSubstr("nan")));
    }
  }
}

TEST(Accuracy, WithoutAPairTheErrorIsNull) {
  const auto json = nlohmann::json::parse(ToJson(EvaluateTrajectory({}, SomePath(5), {})).dump());
  EXPECT_TRUE(json["ate_m"].is_null()) << json.dump();
  EXPECT_EQ(json["poses"]["associated"], 0);
}

TEST(Accuracy, JsonHasTheNumbersByName) {
  const Trajectory truth = SomePath(200);
  EvaluateOptions options;
  options.alignment = Alignment::kFirst;
  options.keyframe_t_ns = {0, 5'000'000'000};
  const Accuracy a = EvaluateTrajectory(WithDrift(truth, Translation(0, 0, 0.01)), truth, options);
  const auto json = nlohmann::json::parse(ToJson(a).dump());
  EXPECT_EQ(json["ate_m"], a.ate_m.rmse);
  EXPECT_EQ(json["poses"]["associated"], 200);
  EXPECT_EQ(json["alignment"]["kind"], "first");
  EXPECT_EQ(json["rpe"][0]["delta"], "1f");
  EXPECT_NEAR(json["rpe"][0]["translation_m"]["rmse"].get<double>(), 0.01, 1e-9);
  EXPECT_EQ(json["kitti"]["lengths"][0]["length_m"], 100.0);
  EXPECT_EQ(json["keyframes"]["motions"], 1);
  EXPECT_FALSE(json.contains("nees_pose"));
}

TEST(Accuracy, TableIsAligned) {
  Trajectory truth;
  Trajectory estimate;
  for (int i = 0; i <= 100; ++i) {
    truth.push_back({i * 100'000'000LL, Translation(0, 0, 2.0 * i)});
    estimate.push_back({i * 100'000'000LL, Translation(0, 0, 2.02 * i)});
  }
  EvaluateOptions options;
  options.alignment = Alignment::kNone;
  options.deltas = {{1.0, Delta::Unit::kSeconds}};
  options.keyframe_t_ns = {0, 1'000'000'000, 2'000'000'000};
  const std::string table = AccuracyTable(EvaluateTrajectory(estimate, truth, options));
  EXPECT_EQ(table.substr(0, table.find("KITTI's")),
            "poses       101 estimated, 101 true, 101 associated; coverage 100.0 %\n"
            "true path   200.000 m in 10.000 s\n"
            "alignment   none\n"
            "\n"
            "                                 n        rmse        mean      median         max\n"
            "ATE position [m]               101      1.1576      1.0000      1.0000      2.0000\n"
            "ATE orientation [deg]          101      0.0000      0.0000      0.0000      0.0000\n"
            "RPE 1s translation [m]          91      0.2000      0.2000      0.2000      0.2000\n"
            "RPE 1s rotation [deg]           91      0.0000      0.0000      0.0000      0.0000\n"
            "\n"
            "KITTI                            n   t_rel [%]  r_rel [deg/100m]\n"
            "100 m                            5      1.0200            0.0000\n"
            "mean of all                      5      1.0200            0.0000\n"
            "\n");
  EXPECT_THAT(table,
              HasSubstr("between keyframes         n 2, translation rmse 0.2000 m, rotation rmse 0.0000 deg\n"
                        "  relative to distance    n 2, rmse 0.0100, t_rel 1.0000 %, R_rel 0.0000 deg/100m\n"));
}

}  // namespace
}  // namespace plslam::evaluate
