// SPDX-License-Identifier: BSD-3-Clause
#include "tools/export/picture_check.h"

#include <gtest/gtest.h>

#include <memory>

#include "core/datasets/open_dataset.h"
#include "core/features/points/orb_extractor.h"

namespace plslam::exports {
namespace {

/// Features of a keyframe that was made from this image.
StereoFeatures FeaturesOf(const cv::Mat& image) {
  StereoFeatures features;
  for (const PointFeature& point : OrbExtractor(OrbOptions()).Extract(image)) {
    StereoPoint stereo;
    stereo.left = point;
    features.points.push_back(stereo);
  }
  return features;
}

TEST(PictureCheck, OnlyTheImageOfTheKeyframe) {
  const auto room = OpenDataset("synthetic:room?size=376x240&frames=60", "");
  const auto street = OpenDataset("synthetic:street?size=376x240&frames=2", "");
  const StereoFeatures features = FeaturesOf(room->Read(0).left);
  ASSERT_GT(features.points.size(), 100U);
  EXPECT_TRUE(ShowsKeyframe(room->Read(0).left, features));
  EXPECT_FALSE(ShowsKeyframe(room->Read(59).left, features)) << "another place";
  EXPECT_FALSE(ShowsKeyframe(street->Read(0).left, features)) << "another world, same time";
  StereoFeatures few = features;
  few.points.resize(10);
  EXPECT_FALSE(ShowsKeyframe(room->Read(0).left, few)) << "not enough to decide";
}

}  // namespace
}  // namespace plslam::exports
