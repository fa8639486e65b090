// Mutates g2o files: they are refused with file and line, or what comes of solving them is finite.
//
// PLSLAM_FUZZ_SECONDS sets the duration (default 2), PLSLAM_FUZZ_SEED the first seed (default 1). Each case is made from
// its seed alone, which a failure names.
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <random>
#include <string>

#include <gtest/gtest.h>

#include "tests/unit/io/dataset_folders.h"
#include "tools/pose_graph/solve.h"

namespace plslam {
namespace {

using Random = std::mt19937_64;

double EnvironmentNumber(const char* name, double fallback) {
  const char* text = std::getenv(name);
  return text == nullptr ? fallback : std::atof(text);
}

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

TEST(G2oFuzz, DamagedFilesAreRefusedOrSolvedWithFiniteNumbers) {
  using Clock = std::chrono::steady_clock;
  const test::TemporaryFolder folder;
  const std::string path = (folder.path() / "graph.g2o").string();
  const auto end = Clock::now() + std::chrono::duration<double>(EnvironmentNumber("PLSLAM_FUZZ_SECONDS", 2.0));
  int cases = 0;
  int solved = 0;
  for (auto seed = static_cast<uint64_t>(EnvironmentNumber("PLSLAM_FUZZ_SEED", 1.0));
       Clock::now() < end && !HasFailure(); ++seed, ++cases) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Random random(seed);
    std::string text = kGraphs[random() % std::size(kGraphs)];
    Mutate(text, random);
    test::WriteText(path, text);
    try {
      G2oFile file = ReadG2o(path);
      SolveOptions options;
      options.graph.max_iterations = 20;
      options.initial = random() % 2 == 0 ? "file" : "chordal";
      options.reject = random() % 2 == 0;
      const SolveReport report = SolveG2o(file, options);
      EXPECT_EQ(report.ok, report.reason.empty()) << text;
      EXPECT_TRUE(std::isfinite(report.chi2_before) && std::isfinite(report.chi2_after)) << text;
      std::visit(
          [&](const auto& graph) {
            for (const auto& node : graph.graph.poses) EXPECT_TRUE(node.T_w_kf.IsFinite()) << text;
          },
          file.content);
      if (report.ok) ++solved;
    } catch (const std::runtime_error& error) {
      EXPECT_NE(std::string(error.what()).find("graph.g2o:"), std::string::npos) << error.what();
    }
  }
  std::printf("  %d cases, %d solved\n", cases, solved);
  EXPECT_GT(solved, 0);
}

}  // namespace
}  // namespace plslam
