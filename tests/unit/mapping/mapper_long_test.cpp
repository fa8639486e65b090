// SPDX-License-Identifier: BSD-3-Clause
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <iostream>
#include <string>

#include <gtest/gtest.h>

#include "mapping_process/mapper.h"
#include "tests/support/long_tests.h"
#include "tests/unit/mapping/mapping_world.h"

namespace plslam::mapping {
namespace {

using test::FeatureWorld;
using test::Walk;

constexpr double kStep_m = 0.2;
constexpr double kInView_m = 8.0;

int64_t ResidentBytes() {
  std::ifstream statm("/proc/self/statm");
  int64_t all = 0;
  int64_t resident = 0;
  statm >> all >> resident;
  return resident * sysconf(_SC_PAGESIZE);
}

// The complete promise of the project takes half a minute; everyday tests run a part.
int Keyframes() { return test::LongTests() ? 2000 : 300; }

/// Cost of a walk down a corridor.
struct Cost {
  size_t most_changed_landmarks = 0;
  size_t most_changed_keyframes = 0;
  int64_t features_in_view = 0;
  int64_t bytes_after_warm_up = 0;
  int64_t bytes = 0;
};

struct Culled {
  const char* name;
  double redundant_share;
  /// Limits of the error of odometry, and of memory.
  double most_error;
  double most_kib;
};

void PrintTo(const Culled& culled, std::ostream* stream) { *stream << culled.name; }

class MapperLong : public testing::TestWithParam<Culled> {};

TEST_P(MapperLong, CorridorIsMappedWithinBounds) {
  const int n = Keyframes();
  const int warm_up = n / 4;
  const FeatureWorld world = test::MakeCorridor(n * kStep_m + kInView_m, 12.0, 3.0, 5);
  // Only the necessary parts of the walk are kept, so that memory is the mapper's.
  Walk walk = test::MakeWalk(world, test::CorridorPath(n, kStep_m), {.with_ids = false});
  const WindowOptions window = MappingOptions().window;
  MappingOptions options;
  options.culling.redundant_share = GetParam().redundant_share;
  Mapper mapper(FeatureWorld::Camera(), options);
  Cost cost;
  for (int i = 0; i < n; ++i) {
    const Keyframe& keyframe = walk.keyframes[static_cast<size_t>(i)];
    cost.features_in_view += static_cast<int64_t>(keyframe.features.points.size() + keyframe.features.lines.size());
    ASSERT_TRUE(test::MapOne(keyframe, mapper));
    const MapUpdate update = mapper.TakeUpdate();
    cost.most_changed_landmarks = std::max(cost.most_changed_landmarks, update.points.size() + update.lines.size());
    cost.most_changed_keyframes = std::max(cost.most_changed_keyframes, update.keyframes.size());
    const AdjustmentFigures& figures = mapper.figures();
    ASSERT_LE(figures.n_keyframes, window.keyframes) << i;
    ASSERT_LE(figures.n_fixed_keyframes, window.fixed_keyframes + 1) << i;
    ASSERT_LE(figures.n_points, window.max_points) << i;
    ASSERT_LE(figures.n_lines, window.max_lines) << i;
    ASSERT_GE(mapper.map().Neighbours(mapper.map().keyframes().rbegin()->first, 1).size(), i == 0 ? 0U : 1U) << i;
    if (i == warm_up) cost.bytes_after_warm_up = ResidentBytes();
  }
  cost.bytes = ResidentBytes();
  ASSERT_EQ(test::WrongWith(mapper.map()), "");
  EXPECT_EQ(test::ExactlyKnown(mapper.map()), 0);

  const MapTotals totals = mapper.map().Totals();
  const double in_view = static_cast<double>(cost.features_in_view) / n;
  const double slope = static_cast<double>(cost.bytes - cost.bytes_after_warm_up) / (n - warm_up);
  const double error_m = test::PositionError_m(mapper.map(), walk.T_w_c);
  std::cout << n << " keyframes, " << in_view << " features each: " << totals.keyframes << " kept, " << totals.points
            << " points, " << totals.lines << " lines, " << totals.point_observations + totals.line_observations
            << " observations; an update changes at most " << cost.most_changed_keyframes << " keyframes and "
            << cost.most_changed_landmarks << " landmarks; " << slope / 1024.0 << " KiB a keyframe; error " << error_m
            << " m after " << n * kStep_m << " m, odometry " << test::OdometryError_m(walk) << " m\n";

  EXPECT_LE(totals.keyframes, n);
  // Each landmark of the world once, with a margin for recent landmarks that may still be culled and for duplicates.
  EXPECT_LT(totals.points, 1.1 * static_cast<double>(world.points().size()));
  EXPECT_LT(totals.lines, 1.1 * static_cast<double>(world.lines().size()));
  EXPECT_GT(totals.points, 0.7 * static_cast<double>(world.points().size()));
  const double seen_by_window = in_view * (window.keyframes + window.fixed_keyframes);
  EXPECT_LT(static_cast<double>(cost.most_changed_landmarks), seen_by_window);
  EXPECT_LT(slope, GetParam().most_kib * 1024.0);
  EXPECT_LT(error_m, GetParam().most_error * test::OdometryError_m(walk));
}

std::string NameOfCulled(const testing::TestParamInfo<Culled>& culled) { return culled.param.name; }

INSTANTIATE_TEST_SUITE_P(Keyframes, MapperLong,
                         testing::Values(Culled{"AreCulled", CullingOptions().redundant_share, 1.0, 60.0},
                                         Culled{"AreAllKept", 1.01, 0.1, 60.0}),
                         NameOfCulled);

}  // namespace
}  // namespace plslam::mapping
