// SPDX-License-Identifier: BSD-3-Clause
#include "tools/rectify_check/length_error.h"

#include <gmock/gmock.h>

#include "core/datasets/open_dataset.h"
#include "core/run/run_warnings.h"

namespace plslam::rectify_check {
namespace {

using testing::HasSubstr;

TEST(LengthError, SentenceIsThatOfTheWarning) {
  RunFindings findings;
  findings.length_error_percent = 15.11;
  findings.length_sigma_percent = 1.12;
  ASSERT_EQ(WarningsOf(findings).size(), 1U);
  EXPECT_EQ(Sentence({15.11, 1.12, 50, 51}), WarningsOf(findings)[0].sentence);
  EXPECT_EQ(Sentence({2.13, 0.21, 75, 75}),
            "disparities have an offset that would change lengths at the median depth by 2 % (sigma 0.2 %): it is "
            "corrected");
  EXPECT_THAT(Sentence({std::nullopt, 0.31, 75, 75}), HasSubstr("no offset of the disparities was found"));
  EXPECT_THAT(Sentence({std::nullopt, 0.0, 1, 12}), HasSubstr("only 1 of 12 frames could be tracked"));
}

TEST(LengthError, OffsetOfAWorldIsMeasured) {
  const auto dataset = OpenDataset("synthetic:street?frames=60&size=376x240&disparity_bias=2,0,0", "");
  const LengthError error = MeasureLengthError(*dataset, dataset->rig());
  EXPECT_EQ(error.tracked, 60);
  ASSERT_TRUE(error.percent.has_value());
  EXPECT_GT(*error.percent, 5.0);
  EXPECT_LT(error.sigma_percent, *error.percent / 3.0);
}

}  // namespace
}  // namespace plslam::rectify_check
