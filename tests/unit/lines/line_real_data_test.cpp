// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "core/features/lines/line_extractor.h"
#include "core/features/matching/line_matcher.h"
#include "core/io/images/image_file.h"
#include "tests/support/data_folder.h"
#include "vo_process/stereo/line_stereo.h"

namespace plslam::vo {
namespace {

size_t CountLong(const std::vector<LineFeature>& lines) {
  size_t count = 0;
  for (const LineFeature& l : lines) count += l.segment.Length() >= 30.0 ? 1 : 0;
  return count;
}

std::vector<LineFeature> ExtractAll(Segments detector, const cv::Mat& image) {
  LineOptions options;
  options.detector = detector;
  options.max_lines = 5000;
  return LineExtractor(options).Extract(image);
}

TEST(LinesOnRealImages, EdgeChainFindsAtLeastAsManyAsLsd) {
  PLSLAM_REQUIRE_DATA(folder, "kitti_03");
  const cv::Mat image = ReadGreyImage(folder / "image_0/000010.png");
  ASSERT_FALSE(image.empty());
  const size_t own = CountLong(ExtractAll(Segments::kEdgeChain, image));
  const size_t lsd = CountLong(ExtractAll(Segments::kLsd, image));
  EXPECT_GE(own, lsd);
  EXPECT_GE(own, 60U);
}

TEST(LinesOnRealImages, StereoAndTrackingFindMostLines) {
  PLSLAM_REQUIRE_DATA(folder, "tsukuba_lamps_a");
  const auto read = [&](const char* name) { return ReadGreyImage(folder / name); };
  const cv::Mat left = read("image_0/000000.png");
  const cv::Mat right = read("image_1/000000.png");
  ASSERT_FALSE(left.empty() || right.empty());
  LineExtractor extractor{LineOptions()};
  std::vector<StereoLine> lines = WithoutDepth(extractor.Extract(left));
  MatchLinesStereo(lines, extractor.Extract(right), left, right, RowField(), StereoOptions());
  int with_depth = 0;
  std::vector<PredictedLine> predicted;
  for (const StereoLine& l : lines) {
    with_depth += l.HasDepth() ? 1 : 0;
    predicted.push_back({l.left.segment, l.left.descriptor});
  }
  EXPECT_GE(with_depth, 50);
  const auto match = MatchLinesByProjection(predicted, lines, LineMatchOptions());
  int wrong = 0;
  for (size_t i = 0; i < match.size(); ++i) wrong += match[i] >= 0 && match[i] != static_cast<int>(i) ? 1 : 0;
  EXPECT_EQ(wrong, 0) << "of " << match.size() << " lines with themselves";
}

}  // namespace
}  // namespace plslam::vo
