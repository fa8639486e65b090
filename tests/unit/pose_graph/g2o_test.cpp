// SPDX-License-Identifier: BSD-3-Clause
#include "tools/pose_graph/g2o.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>

#include "tests/unit/datasets/dataset_folders.h"
#include "tools/pose_graph/pose_graph_chain.h"

namespace plslam::pose_graph {
namespace {

using testing::HasSubstr;

class G2o : public testing::Test {
 protected:
  std::string Path() const { return (folder_.path() / "graph.g2o").string(); }
  G2oFile Read(const std::string& text) const {
    test::WriteText(Path(), text);
    return ReadG2o(Path());
  }
  std::string ErrorOf(const std::string& text) const {
    try {
      Read(text);
    } catch (const std::runtime_error& error) {
      return error.what();
    }
    return "no error";
  }

 private:
  test::TemporaryFolder folder_;
};

const char* const kPlane =
    "VERTEX_SE2 7 1 2 0.5\n"
    "FIX 7\n"
    "\n"
    "# a comment\n"
    "EDGE_SE2 7 9 1 0 0.1  10 1 2 20 3 30 \r\n";

const char* const kSpace =
    "VERTEX_SE3:QUAT 0 1 2 3 0 0 0 1\n"
    "VERTEX_SE3:QUAT 1 2 2 3 0 0 0.6 0.8\n"
    "PARAMS_SE3OFFSET 0 0 0 0 0 0 0 1\n"
    "EDGE_SE3:QUAT 0 1 1.5 0 0 0 0 0 1  100 0 0 0 0 4  100 0 0 0 0  100 0 0 0  40 0 0  40 0  40\n";

TEST_F(G2o, GraphsInThePlane) {
  const G2oFile file = Read(kPlane);
  const auto& graph = std::get<G2oGraph<SE2>>(file.content);
  EXPECT_EQ(graph.ids, (std::vector<int64_t>{7, 9}));
  EXPECT_EQ(graph.given, (std::vector<bool>{true, false}));
  EXPECT_TRUE(graph.graph.poses[0].fixed);
  EXPECT_FALSE(graph.graph.poses[1].fixed);
  EXPECT_EQ(graph.graph.poses[0].T_w_kf.angle(), 0.5);
  ASSERT_EQ(graph.graph.edges.size(), 1U);
  Eigen::Matrix3d information;
  information << 10.0, 1.0, 2.0, 1.0, 20.0, 3.0, 2.0, 3.0, 30.0;
  EXPECT_EQ(graph.graph.edges[0].information, information);
  const auto chained = ChainedPoses(graph.graph, graph.given);
  EXPECT_NEAR(chained[1].translation().x(), 1.0 + std::cos(0.5), 1e-12);
  EXPECT_NEAR(chained[1].angle(), 0.6, 1e-12);
}

// The error of g2o by its definition: translation and vector part of the quaternion of Z^-1 (A^-1 B), w >= 0.
TEST_F(G2o, ChiSquareIn3dAgreesWithG2o) {
  const G2oFile file = Read(kSpace);
  const auto& graph = std::get<G2oGraph<SE3>>(file.content);
  EXPECT_EQ(file.skipped, (std::map<std::string, int>{{"PARAMS_SE3OFFSET", 1}}));
  std::vector<SE3> poses = {graph.graph.poses[0].T_w_kf, graph.graph.poses[1].T_w_kf};
  // e = (1 - 1.5, 0, 0, 0, 0, 0.6)
  const double expected = 100.0 * 0.25 + 40.0 * 0.36 + 2.0 * 4.0 * -0.5 * 0.6;
  EXPECT_NEAR(PoseGraphChi2(graph.graph, poses), expected, 1e-12);
  const Eigen::Quaterniond& q = poses[1].rotation();
  poses[1] = SE3::FromUnit(Eigen::Quaterniond(-q.coeffs()), poses[1].translation());
  EXPECT_NEAR(PoseGraphChi2(graph.graph, poses), expected, 1e-12);
}

TEST_F(G2o, ChiSquareIn2dAgreesWithG2o) {
  const G2oFile file = Read(
      "VERTEX_SE2 0 0 0 3\n"
      "VERTEX_SE2 1 0 0 -3\n"
      "EDGE_SE2 0 1 1 0 0.1  10 0 2 20 0 30\n");
  const auto& graph = std::get<G2oGraph<SE2>>(file.content);
  const std::vector<SE2> poses = {graph.graph.poses[0].T_w_kf, graph.graph.poses[1].T_w_kf};
  const double turn = -6.0 - 0.1 + 2.0 * std::numbers::pi;
  const double x = -std::cos(0.1);
  const double y = std::sin(0.1);
  EXPECT_NEAR(PoseGraphChi2(graph.graph, poses),
              10.0 * x * x + 20.0 * y * y + 30.0 * turn * turn + 2.0 * 2.0 * x * turn, 1e-12);
}

TEST_F(G2o, RoundTripKeepsEveryBit) {
  for (const char* text : {kPlane, kSpace}) {
    const G2oFile file = Read(text);
    std::visit([&](const auto& graph) { WriteG2o(Path(), graph); }, file.content);
    const std::string first = test::ReadText(Path());
    std::visit([&](const auto& graph) { WriteG2o(Path(), graph); }, ReadG2o(Path()).content);
    EXPECT_EQ(test::ReadText(Path()), first);
    EXPECT_THAT(first, HasSubstr("EDGE_SE"));
  }
}

TEST_F(G2o, NumbersWithManyDigitsSurvive) {
  G2oGraph<SE3> graph;
  graph.ids = {3, 1'000'000'000'000};
  graph.given = {true, true};
  const SE3 odd(Eigen::Quaterniond(0.3, 0.1, -0.7, 0.2), {1.0 / 3.0, -1e-17, 2e20});
  Matrix6d information = Matrix6d::Identity() / 3.0;
  information(1, 4) = information(4, 1) = 0.01 / 7.0;
  graph.graph.poses = {{SE3(), true}, {odd, false}};
  graph.graph.edges = {{0, 1, odd.Inverse(), information, false}};
  WriteG2o(Path(), graph);
  const G2oFile file = ReadG2o(Path());
  const auto& read = std::get<G2oGraph<SE3>>(file.content);
  EXPECT_EQ(read.ids, graph.ids);
  EXPECT_EQ(read.graph.poses[1].T_w_kf.translation(), odd.translation());
  EXPECT_EQ(read.graph.poses[1].T_w_kf.rotation().coeffs(), odd.rotation().coeffs());
  EXPECT_EQ(read.graph.edges[0].information, information);
  EXPECT_TRUE(read.graph.poses[0].fixed);
}

TEST_F(G2o, ErrorsNameFileLineAndCulprit) {
  EXPECT_THAT(ErrorOf(""), HasSubstr("graph.g2o: has no edge"));
  EXPECT_THAT(ErrorOf("VERTEX_SE2 0 0 0 0\n"), HasSubstr("has no edge"));
  EXPECT_THAT(ErrorOf("VERTEX_XY 0 0 0\n"), HasSubstr("graph.g2o:1: 'VERTEX_XY' is not one of"));
  EXPECT_THAT(ErrorOf("\nVERTEX_SE2 0 0 0\n"),
              HasSubstr("graph.g2o:2: VERTEX_SE2 has 3 fields after it, and must have 4"));
  EXPECT_THAT(ErrorOf("VERTEX_SE2 0 0 0 x\n"), HasSubstr("'x' is not a finite number"));
  EXPECT_THAT(ErrorOf("VERTEX_SE2 0 0 0 nan\n"), HasSubstr("'nan' is not a finite number"));
  EXPECT_THAT(ErrorOf("VERTEX_SE2 -1 0 0 0\n"), HasSubstr("'-1' is not the number of a vertex"));
  EXPECT_THAT(ErrorOf("VERTEX_SE2 1.5 0 0 0\n"), HasSubstr("'1.5' is not the number of a vertex"));
  EXPECT_THAT(ErrorOf("VERTEX_SE2 99999999999999999999 0 0 0\n"), HasSubstr("is not the number of a vertex"));
  EXPECT_THAT(ErrorOf("VERTEX_SE2 0 0 0 0\nVERTEX_SE2 0 0 0 0\n"), HasSubstr(":2: vertex 0 is defined twice"));
  EXPECT_THAT(ErrorOf("VERTEX_SE3:QUAT 0 0 0 0 0 0 0 2\n"), HasSubstr("the norm of the quaternion is 2"));
  EXPECT_THAT(ErrorOf("VERTEX_SE3:QUAT 0 0 0 0 0 0 0 0\n"), HasSubstr("the norm of the quaternion is 0"));
  EXPECT_THAT(ErrorOf(std::string(kPlane) + kSpace), HasSubstr("cannot contain both 2D and 3D"));
  EXPECT_THAT(ErrorOf("EDGE_SE2 3 3 0 0 0 1 0 0 1 0 1\n"), HasSubstr("joins vertex 3 to itself"));
  EXPECT_THAT(ErrorOf("EDGE_SE2 0 1 0 0 0 1 2 0 1 0 1\n"), HasSubstr("not positive definite"));
  EXPECT_THAT(ErrorOf("EDGE_SE2 0 1 0 0 0 1 0 0 1 0 0\n"), HasSubstr("not positive definite"));
  EXPECT_THAT(ErrorOf(std::string(kPlane) + "FIX 8\n"),
              HasSubstr(":6: FIX names vertex 8, which no other line defines"));
  EXPECT_THAT(ErrorOf("EDGE_SE2 0 1 " + std::string(5000, '0')), HasSubstr("more than 4096 characters"));
}

TEST(G2oFiles, MissingFileThrows) { EXPECT_THROW(ReadG2o("/no/such/file.g2o"), std::runtime_error); }

}  // namespace
}  // namespace plslam::pose_graph
