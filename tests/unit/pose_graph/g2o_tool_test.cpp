// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "core/io/trajectories/trajectory.h"
#include "tests/unit/datasets/dataset_folders.h"
#include "tests/unit/map_file/stored_maps.h"
#include "tools/pose_graph/command_line.h"
#include "tools/pose_graph/g2o.h"

namespace plslam::pose_graph {
namespace {

using testing::HasSubstr;

const char* const kSquare =
    "EDGE_SE2 0 1 1 0 1.57 100 0 0 100 0 100\n"
    "EDGE_SE2 1 2 1 0 1.57 100 0 0 100 0 100\n"
    "EDGE_SE2 2 3 1 0 1.57 100 0 0 100 0 100\n"
    "EDGE_SE2 3 0 1 0 1.57 100 0 0 100 0 100\n";

struct Outcome {
  int code = 0;
  std::string out;
  std::string error;
};

Outcome Call(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), "pose_graph");
  std::vector<char*> argv;
  argv.reserve(arguments.size());
  for (std::string& argument : arguments) argv.push_back(argument.data());
  testing::internal::CaptureStdout();
  testing::internal::CaptureStderr();
  Outcome outcome;
  outcome.code = RunPoseGraph(static_cast<int>(argv.size()), argv.data());
  outcome.out = testing::internal::GetCapturedStdout();
  outcome.error = testing::internal::GetCapturedStderr();
  return outcome;
}

class PoseGraphProgram : public testing::Test {
 protected:
  std::string Path(const std::string& name) const { return (folder_.path() / name).string(); }

 private:
  test::TemporaryFolder folder_;
};

TEST_F(PoseGraphProgram, SolvesAndWritesTheGraphAndThePoses) {
  test::WriteText(Path("square.g2o"), kSquare);
  for (const char* initial : {"file", "odometry", "chordal"}) {
    const Outcome outcome = Call({Path("square.g2o"), "--json", "--initial", initial, "--out", Path("out.g2o"),
                                  "--tum", Path("out.tum"), "--perturb", "0.05", "--seed", "3"});
    ASSERT_EQ(outcome.code, 0) << outcome.error;
    const auto report = nlohmann::json::parse(outcome.out);
    EXPECT_EQ(report["poses"], 4);
    EXPECT_EQ(report["edges"], 4);
    EXPECT_LT(report["chi2_after"].get<double>(), 1e-2);
    EXPECT_LT(report["chi2_after"].get<double>(), report["chi2_before"].get<double>());
    EXPECT_EQ(ReadTrajectory(Path("out.tum")).size(), 4U);
    const G2oFile solved = ReadG2o(Path("out.g2o"));
    EXPECT_EQ(std::get<G2oGraph<SE2>>(solved.content).given, std::vector<bool>(4, true));
  }
}

TEST_F(PoseGraphProgram, RejectsWrongEdgesOnRequest) {
  test::WriteText(Path("square.g2o"), std::string(kSquare) + "EDGE_SE2 0 2 5 5 0 1000 0 0 1000 0 1000\n");
  const Outcome outcome = Call({Path("square.g2o"), "--json", "--reject", "50"});
  ASSERT_EQ(outcome.code, 0) << outcome.error;
  const auto report = nlohmann::json::parse(outcome.out);
  EXPECT_EQ(report["rejected_edges"], 1);
  EXPECT_LT(report["chi2_after"].get<double>(), 1e-2);
}

TEST_F(PoseGraphProgram, ExportsThePoseGraphOfAMap) {
  WriteMapFile(Path("a.plmap"), test::RandomStoredMap(4, 300));
  const Map map = ReadMapFile(Path("a.plmap")).map;
  const Outcome outcome = Call({"--from-map", Path("a.plmap"), "--out", Path("a.g2o"), "--tum", Path("a.tum")});
  ASSERT_EQ(outcome.code, 0) << outcome.error;
  const G2oFile file = ReadG2o(Path("a.g2o"));
  const auto& graph = std::get<G2oGraph<SE3>>(file.content);
  EXPECT_EQ(graph.ids.size(), map.keyframes().size());
  EXPECT_EQ(ReadTrajectory(Path("a.tum")).size(), map.keyframes().size());
  EXPECT_EQ(graph.graph.poses[0].T_w_kf.translation(), map.keyframes().begin()->second.T_w_kf.translation());
}

TEST_F(PoseGraphProgram, ErrorsAreOneSentence) {
  EXPECT_NE(Call({}).code, 0);
  EXPECT_NE(Call({"a", "--from-map", "b"}).code, 0);
  EXPECT_NE(Call({"a", "--initial", "guess"}).code, 0);
  const Outcome missing = Call({Path("none.g2o")});
  EXPECT_EQ(missing.code, 1);
  EXPECT_THAT(missing.error, HasSubstr("none.g2o: cannot be read: No such file or directory"));
  test::WriteText(Path("bad.g2o"), "EDGE_SE2 0 1 1 0 0\n");
  const Outcome bad = Call({Path("bad.g2o")});
  EXPECT_EQ(bad.code, 1);
  EXPECT_THAT(bad.error, HasSubstr("bad.g2o:1:"));
  test::WriteText(Path("bad.plmap"), "not a map");
  const Outcome map = Call({"--from-map", Path("bad.plmap")});
  EXPECT_EQ(map.code, 1);
  EXPECT_THAT(map.error, HasSubstr("bad.plmap: is not a map file"));
}

}  // namespace
}  // namespace plslam::pose_graph
