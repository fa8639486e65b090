// SPDX-License-Identifier: BSD-3-Clause
// Mutates g2o files: they are rejected with file and line, or their solution is finite.
#include <cmath>
#include <random>
#include <string>

#include <gtest/gtest.h>

#include "tests/support/fuzzing.h"
#include "tests/unit/datasets/dataset_folders.h"
#include "tools/pose_graph/solve.h"

namespace plslam::pose_graph {
namespace {

using Random = std::mt19937_64;

const std::string kGraphs[] = {
    "VERTEX_SE2 0 0 0 0\nVERTEX_SE2 1 1 0 0.1\nFIX 0\n"
    "EDGE_SE2 0 1 1 0 0.1 10 0 0 10 0 40\nEDGE_SE2 1 2 1 0 0.1 10 0 0 10 0 40\nEDGE_SE2 2 0 -2 0 -0.3 10 0 0 10 0 "
    "40\n",
    "VERTEX_SE3:QUAT 0 0 0 0 0 0 0 1\nVERTEX_SE3:QUAT 1 1 0 0 0 0 0.6 0.8\n"
    "EDGE_SE3:QUAT 0 1 1 0 0 0 0 0 1 9 0 0 0 0 1 9 0 0 0 0 9 0 0 0 4 0 0 4 0 4\n"
    "EDGE_SE3:QUAT 1 2 1 0 0 0 0.6 0 0.8 9 0 0 0 0 1 9 0 0 0 0 9 0 0 0 4 0 0 4 0 4\n"
    "EDGE_SE3:QUAT 2 0 1 0 0 0 0 0 1 9 0 0 0 0 1 9 0 0 0 0 9 0 0 0 4 0 0 4 0 4\n"};

void Mutate(std::string& text, Random& random) {
  static const std::string kPieces[] = {"-",          "e300",
                                        "1e-320",     "nan",
                                        "inf",        "0",
                                        "-1",         " ",
                                        "\n",         "FIX 1\n",
                                        "9999999999", ",",
                                        "#",          std::string(1, '\0'),
                                        "EDGE_SE2 ",  "VERTEX_SE3:QUAT "};
  for (uint64_t n = 1 + random() % 3; n > 0; --n) {
    const size_t at = random() % text.size();
    switch (random() % 4) {
      case 0:
        text[at] = static_cast<char>('0' + random() % 10);
        break;
      case 1:
        text[at] = static_cast<char>(random());
        break;
      case 2:
        text.insert(at, kPieces[random() % std::size(kPieces)]);
        break;
      default:
        text.erase(at, 1 + random() % 8);
    }
    if (text.empty()) text.push_back(' ');
  }
}

/// Returns true if there was a solution.
bool IsRefusedOrFinite(const std::string& path, const std::string& text, const SolveOptions& options) {
  test::WriteText(path, text);
  try {
    G2oFile file = ReadG2o(path);
    const SolveReport report = SolveG2o(file, options);
    EXPECT_EQ(report.ok, report.reason.empty()) << text;
    EXPECT_TRUE(std::isfinite(report.chi2_before) && std::isfinite(report.chi2_after)) << text;
    std::visit(
        [&](const auto& graph) {
          for (const auto& node : graph.graph.poses) EXPECT_TRUE(node.T_w_kf.IsFinite()) << text;
        },
        file.content);
    return report.ok;
  } catch (const std::runtime_error& error) {
    EXPECT_NE(std::string(error.what()).find("graph.g2o:"), std::string::npos) << error.what();
    return false;
  }
}

TEST(G2oFuzz, DamagedFilesAreRefusedOrSolved) {
  const test::TemporaryFolder folder;
  const std::string path = (folder.path() / "graph.g2o").string();
  const test::FuzzCounts counts = test::Fuzz([&](Random& random) {
    std::string text = kGraphs[random() % std::size(kGraphs)];
    Mutate(text, random);
    SolveOptions options;
    options.graph.max_iterations = 20;
    options.initial = random() % 2 == 0 ? InitialPoses::kFile : InitialPoses::kChordal;
    options.reject = random() % 2 == 0;
    return IsRefusedOrFinite(path, text, options);
  });
  EXPECT_GT(counts.accepted, 0U);
}

}  // namespace
}  // namespace plslam::pose_graph
