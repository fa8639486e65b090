// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <optional>
#include <ostream>
#include <string>
#include <vector>

#include "tests/integration/whole_run.h"
#include "tests/support/data_folder.h"

namespace plslam {
namespace {

using test::WholeRun;

/// A recorded sequence, the warnings that its user should act on, and a bound of the error of orientation (none: it has
/// no true orientations, or they were measured for another body).
struct Sequence {
  const char* name;
  std::vector<std::string> warnings;
  std::optional<double> rotation_deg;
};

void PrintTo(const Sequence& sequence, std::ostream* to) { *to << sequence.name; }

class RealSequence : public testing::TestWithParam<Sequence> {};

/// Runs the dataset, and checks that its warnings are these. Returns the summary.
nlohmann::json ExpectWarnings(const std::string& dataset, const std::vector<std::string>& warnings) {
  WholeRun run;
  EXPECT_EQ(run.Run({"run", dataset, "--strict"}), warnings.empty() ? 0 : 2) << run.Logs();
  const nlohmann::json summary = run.Summary();
  std::vector<std::string> codes;
  for (const nlohmann::json& warning : summary["warnings"]) codes.push_back(warning["code"]);
  EXPECT_THAT(codes, testing::UnorderedElementsAreArray(warnings)) << summary["warnings"].dump(1);
  return summary;
}

TEST_P(RealSequence, WarnsOnlyOfWhatIsWrong) {
  const Sequence& sequence = GetParam();
  PLSLAM_REQUIRE_DATA(folder, sequence.name);
  const nlohmann::json summary = ExpectWarnings(folder.string(), sequence.warnings);
  if (!sequence.rotation_deg) return;
  EXPECT_LT(summary["accuracy"]["ate_rotation_deg"]["rmse"].get<double>(), *sequence.rotation_deg);
}

TEST(BuiltInWorld, WarnsOnlyOfWhatIsWrong) {
  ExpectWarnings("synthetic:whitewall?frames=150", {});
  ExpectWarnings("synthetic:street?frames=150&size=376x240", {});
  ExpectWarnings("synthetic:room?frames=150&right_late_ms=10", {"cameras_out_of_step"});
}

INSTANTIATE_TEST_SUITE_P(
    All, RealSequence,
    testing::Values(Sequence{"kitti_03", {}, 0.3}, Sequence{"euroc_MH_01_a", {}, 0.12},
                    Sequence{"tum_fr1_xyz", {}, 0.8}, Sequence{"kitti_01", {"disparities_off"}, 0.5},
                    Sequence{"eisats_bridge_a", {}, std::nullopt},
                    Sequence{"euroc_V1_01_sparse", {"covariance_not_consistent"}, std::nullopt},
                    Sequence{"euroc_V1_01_static", {"dataset"}, std::nullopt},
                    Sequence{"sand_rand", {}, std::nullopt}, Sequence{"tsukuba_lamps_a", {}, std::nullopt},
                    Sequence{"tartanair2_10", {}, std::nullopt}, Sequence{"tumvi_room1_imu", {}, std::nullopt},
                    Sequence{"tumvi_room1_static", {}, std::nullopt}),
    [](const auto& chosen) { return std::string(chosen.param.name); });

}  // namespace
}  // namespace plslam
