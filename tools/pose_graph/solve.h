// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "core/config/choices.h"
#include "tools/pose_graph/g2o.h"

namespace plslam::pose_graph {

/// Initial poses: the file's (chained if it has none), chained along the edges, or by chordal relaxation.
enum class InitialPoses { kFile, kOdometry, kChordal };
constexpr auto ChoicesOf(InitialPoses) {
  return std::array{Choice{"file", InitialPoses::kFile}, Choice{"odometry", InitialPoses::kOdometry},
                    Choice{"chordal", InitialPoses::kChordal}};
}

struct SolveOptions {
  InitialPoses initial = InitialPoses::kFile;
  /// Standard deviation, m and rad, of noise on these poses.
  double perturb = 0.0;
  uint64_t seed = 1;
  /// Tight: any start ends in the same minimum to nine digits.
  PoseGraphOptions graph{
      .start = GraphStart::kBest, .max_iterations = 1000, .function_tolerance = 1e-13, .rejection_chi2 = 1e12};
  /// All edges but those between poses that follow each other may be rejected.
  bool reject = false;
};

struct SolveReport {
  bool ok = false;
  std::string reason;
  int poses = 0;
  int edges = 0;
  int rejected = 0;
  int iterations = 0;
  double chi2_before = 0.0;
  double chi2_after = 0.0;
  double seconds = 0.0;
};

/// Solves the graph in place.
SolveReport SolveG2o(G2oFile& file, const SolveOptions& options);

}  // namespace plslam::pose_graph
