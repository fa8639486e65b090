// SPDX-License-Identifier: BSD-3-Clause
// The small ones of the public pose graphs; all of them are in docs/lab/pose_graph.md.
#include <gtest/gtest.h>

#include <utility>

#include "tests/support/data_folder.h"
#include "tests/unit/datasets/dataset_folders.h"
#include "tools/pose_graph/export.h"
#include "tools/pose_graph/solve.h"

namespace plslam::pose_graph {
namespace {

struct PublicGraph {
  const char* name;
  int poses;
  int edges;
};

class PublicPoseGraphs : public testing::TestWithParam<PublicGraph> {};

SolveReport SolveFrom(const std::string& path, InitialPoses initial, double perturb) {
  G2oFile file = ReadG2o(path);
  SolveOptions options;
  options.initial = initial;
  options.perturb = perturb;
  return SolveG2o(file, options);
}

TEST_P(PublicPoseGraphs, EndInTheSameMinimumFromEveryStart) {
  PLSLAM_REQUIRE_DATA(folder, "posegraphs");
  const std::string path = (folder / (std::string(GetParam().name) + ".g2o")).string();
  const SolveReport chordal = SolveFrom(path, InitialPoses::kChordal, 0.0);
  ASSERT_TRUE(chordal.ok) << chordal.reason;
  EXPECT_EQ(chordal.poses, GetParam().poses);
  EXPECT_EQ(chordal.edges, GetParam().edges);
  const std::pair<InitialPoses, double> starts[] = {
      {InitialPoses::kFile, 0.0}, {InitialPoses::kOdometry, 0.0}, {InitialPoses::kFile, 0.1}};
  for (const auto& [initial, perturb] : starts) {
    const SolveReport report = SolveFrom(path, initial, perturb);
    ASSERT_TRUE(report.ok) << report.reason;
    EXPECT_NEAR(report.chi2_after, chordal.chi2_after, 1e-6 * chordal.chi2_after)
        << NameOf(initial) << " " << perturb;
    EXPECT_LT(report.chi2_after, report.chi2_before);
  }
}

TEST_P(PublicPoseGraphs, SolvedWrittenAndReadAgainAreAtTheMinimum) {
  PLSLAM_REQUIRE_DATA(folder, "posegraphs");
  G2oFile file = ReadG2o((folder / (std::string(GetParam().name) + ".g2o")).string());
  const SolveReport report = SolveG2o(file, {.initial = InitialPoses::kChordal});
  ASSERT_TRUE(report.ok) << report.reason;
  const test::TemporaryFolder out;
  const std::string path = (out.path() / "solved.g2o").string();
  std::visit([&](const auto& graph) { WriteG2o(path, graph); }, file.content);
  G2oFile again = ReadG2o(path);
  SolveOptions options;
  options.graph.start = GraphStart::kGiven;
  const SolveReport second = SolveG2o(again, options);
  ASSERT_TRUE(second.ok) << second.reason;
  EXPECT_NEAR(second.chi2_before, report.chi2_after, 1e-12 * report.chi2_after);
  EXPECT_NEAR(second.chi2_after, report.chi2_after, 1e-9 * report.chi2_after);
  const Trajectory trajectory = std::visit([](const auto& graph) { return TrajectoryOf(graph); }, again.content);
  EXPECT_EQ(trajectory.size(), static_cast<size_t>(report.poses));
}

INSTANTIATE_TEST_SUITE_P(Small, PublicPoseGraphs,
                         testing::Values(PublicGraph{"tinyGrid3D", 9, 11}, PublicGraph{"smallGrid3D", 125, 297},
                                         PublicGraph{"MIT", 808, 827}, PublicGraph{"intel", 1728, 2512}),
                         [](const auto& instance) { return std::string(instance.param.name); });

}  // namespace
}  // namespace plslam::pose_graph
