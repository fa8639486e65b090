// SPDX-License-Identifier: BSD-3-Clause
#include "core/map/keyframe_features.h"

#include <cstdlib>
#include <string>

#include <gtest/gtest.h>

namespace plslam {
namespace {

StereoFeatures FeaturesOf(int n_points, int n_lines) {
  StereoFeatures features;
  for (int i = 0; i < n_points; ++i) {
    StereoPoint point;
    point.left.px = {i, 2.0 * i};
    point.left.descriptor = {1, 2, 3, static_cast<uint64_t>(i)};
    features.points.push_back(point);
  }
  for (int i = 0; i < n_lines; ++i) {
    StereoLine line;
    line.left.segment = {{i, 0.0}, {i, 1.0 / (1 + i)}};
    features.lines.push_back(line);
  }
  return features;
}

void ExpectAsMade(const FeaturesView& features, int n_points, int n_lines) {
  ASSERT_EQ(features.points.size(), static_cast<size_t>(n_points));
  ASSERT_EQ(features.lines.size(), static_cast<size_t>(n_lines));
  const StereoFeatures made = FeaturesOf(n_points, n_lines);
  for (size_t i = 0; i < made.points.size(); ++i) {
    EXPECT_EQ(features.points[i].left.px, made.points[i].left.px);
    EXPECT_EQ(features.points[i].left.descriptor, made.points[i].left.descriptor);
  }
  for (size_t i = 0; i < made.lines.size(); ++i) {
    EXPECT_EQ(features.lines[i].left.segment.q, made.lines[i].left.segment.q);
  }
}

TEST(KeptFeatures, AreTheSameInMemoryAndInAFile) {
  for (const auto& [n_points, n_lines] : {std::pair{300, 70}, {300, 0}, {0, 70}, {0, 0}}) {
    KeptFeatures kept(FeaturesOf(n_points, n_lines));
    kept.image = TakenImage{1, 2, 3, 4, 5.0};
    const KeptFeatures before = kept;
    ASSERT_TRUE(KeptFeatures::MoveToFile({&kept}));
    EXPECT_TRUE(kept.IsInFile());
    kept.LeaveMemory();
    ExpectAsMade(kept, n_points, n_lines);
    ExpectAsMade(before, n_points, n_lines);
    EXPECT_EQ(kept.image->f_px, 5.0);
    const KeptFeatures copy = kept;
    kept = {};
    EXPECT_TRUE(kept.points.empty());
    ExpectAsMade(copy, n_points, n_lines);
    EXPECT_TRUE(KeptFeatures(copy).IsInFile());
  }
}

TEST(MoveOldToFiles, LeavesTheNewestInMemory) {
  KeyframeFeatures features;
  for (int id = 0; id < 200; id += 2) features[id] = FeaturesOf(id, 5);
  for (int round = 0; round < 2; ++round) {
    ASSERT_TRUE(MoveOldToFiles(features));
    int n_in_file = 0;
    for (const auto& [id, of_keyframe] : features) {
      n_in_file += of_keyframe.IsInFile() ? 1 : 0;
      ExpectAsMade(of_keyframe, static_cast<int>(id.value), 5);
    }
    EXPECT_EQ(n_in_file, 36);
    EXPECT_TRUE(features.begin()->second.IsInFile());
    EXPECT_FALSE(features.rbegin()->second.IsInFile());
  }
}

TEST(MoveOldToFiles, AllStayInMemoryWithoutAFolder) {
  const char* was = std::getenv("TMPDIR");
  const std::string before = was != nullptr ? was : "";
  ::setenv("TMPDIR", "/no/such/folder", 1);
  KeyframeFeatures features;
  for (int id = 0; id < 70; ++id) features[id] = FeaturesOf(id, 5);
  EXPECT_FALSE(MoveOldToFiles(features));
  for (const auto& [id, of_keyframe] : features) ExpectAsMade(of_keyframe, static_cast<int>(id.value), 5);
  EXPECT_NE(CannotLeaveMemory().find("/no/such/folder"), std::string::npos);
  if (was != nullptr) {
    ::setenv("TMPDIR", before.c_str(), 1);
  } else {
    ::unsetenv("TMPDIR");
  }
}

}  // namespace
}  // namespace plslam
