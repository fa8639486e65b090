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

TEST_P(RealSequence, WarnsOnlyOfWhatIsWrong) {
  const Sequence& sequence = GetParam();
  PLSLAM_REQUIRE_DATA(folder, sequence.name);
  WholeRun run;
  EXPECT_EQ(run.Run({"run", folder.string(), "--strict"}), sequence.warnings.empty() ? 0 : 2) << run.Logs();
  const nlohmann::json summary = run.Summary();
  std::vector<std::string> codes;
  for (const nlohmann::json& warning : summary["warnings"]) codes.push_back(warning["code"]);
  EXPECT_THAT(codes, testing::UnorderedElementsAreArray(sequence.warnings)) << summary["warnings"].dump(1);
  if (!sequence.rotation_deg) return;
  EXPECT_LT(summary["accuracy"]["ate_rotation_deg"]["rmse"].get<double>(), *sequence.rotation_deg);
}

INSTANTIATE_TEST_SUITE_P(All, RealSequence,
                         testing::Values(Sequence{"kitti_03", {}, 0.3}, Sequence{"euroc_MH_01_a", {}, 0.12},
                                         Sequence{"tum_fr1_xyz", {}, 0.8},
                                         Sequence{"kitti_01", {"disparities_off"}, 0.5},
                                         Sequence{"eisats_bridge_a", {}, std::nullopt}),
                         [](const auto& chosen) { return std::string(chosen.param.name); });

}  // namespace
}  // namespace plslam
