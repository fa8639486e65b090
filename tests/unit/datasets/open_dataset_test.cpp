// SPDX-License-Identifier: BSD-3-Clause
#include "core/datasets/open_dataset.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/unit/datasets/dataset_folders.h"
#include "tests/unit/datasets/dataset_matchers.h"

namespace plslam {
namespace {

using test::ErrorOf;
using testing::AllOf;
using testing::HasSubstr;

TEST(OpenDataset, EveryKindIsFoundByLookingAndByName) {
  const test::TemporaryFolder folder;
  test::MakeKittiFolder(folder.path() / "kitti");
  test::MakeEurocFolder(folder.path() / "euroc");
  test::MakeTumFolder(folder.path() / "tum_fr1");
  test::MakeImagesFolder(folder.path() / "images");
  for (const auto& [name, kind] :
       {std::pair{"kitti", "kitti"}, {"euroc", "euroc"}, {"tum_fr1", "tum"}, {"images", "images"}}) {
    const std::string location = (folder.path() / name).string();
    EXPECT_EQ(OpenDataset(location, "")->size(), 3) << name;
    EXPECT_EQ(OpenDataset(location, kind)->size(), 3) << name;
  }
}

TEST(OpenDataset, SyntheticWorldByName) {
  const auto world = OpenDataset("synthetic:room", "");
  EXPECT_GT(world->size(), 0);
  EXPECT_TRUE(world->GroundTruth(0));
}

TEST(OpenDataset, ErrorsNameWhatIsKnown) {
  const test::TemporaryFolder folder;
  EXPECT_THAT(
      ErrorOf([&] { OpenDataset(folder.path().string(), ""); }),
      AllOf(HasSubstr(folder.path().string()), HasSubstr("kitti: calib.txt"), HasSubstr("images: camera.yaml")));
  EXPECT_THAT(ErrorOf([] { OpenDataset("/nowhere/at/all", ""); }), HasSubstr("/nowhere/at/all: there is no such"));
  EXPECT_THAT(ErrorOf([&] { OpenDataset(folder.path().string(), "rosbag"); }),
              AllOf(HasSubstr("'rosbag'"), HasSubstr("kitti, euroc, tum, images")));
  EXPECT_THAT(ErrorOf([] { OpenDataset("/nowhere/at/all", "euroc"); }), HasSubstr("/nowhere/at/all"));
}

}  // namespace
}  // namespace plslam
