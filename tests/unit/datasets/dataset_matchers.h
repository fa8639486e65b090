// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <gtest/gtest.h>

#include <functional>
#include <string>

#include "core/datasets/dataset.h"
#include "core/datasets/open_dataset.h"
#include "tests/unit/datasets/dataset_folders.h"

namespace plslam::test {

/// Returns the one sentence with which `f` fails; the test fails if it does not throw DatasetError, or in several
/// lines.
inline std::string ErrorOf(const std::function<void()>& f) {
  try {
    f();
  } catch (const DatasetError& error) {
    const std::string what = error.what();
    EXPECT_EQ(what.find('\n'), std::string::npos) << what;
    return what;
  } catch (const std::exception& error) {
    ADD_FAILURE() << "not a DatasetError: " << error.what();
    return "";
  }
  ADD_FAILURE() << "no error";
  return "";
}

/// A tiny recording in a temporary folder.
class RecordingFileTest : public testing::Test {
 protected:
  explicit RecordingFileTest(const std::string& name) : path_((folder_.path() / name).string()) {}

  const std::string& path() const { return path_; }
  /// Returns the error of opening it with these options and reading its first frame.
  std::string Error(const std::string& options = "") const {
    return ErrorOf([&] { OpenDataset(path_ + options, "")->Read(0); });
  }
  /// Checks that it has the original three frames and truth.
  void ExpectItsFrames(const std::string& compression) const {
    EXPECT_TRUE(OpenDataset(path_, "")->Notes().empty());
    ExpectFrames(3, compression);
  }
  /// The first of them.
  void ExpectFrames(int n, const std::string& what) const {
    SCOPED_TRACE(what);
    const auto dataset = OpenDataset(path_, "");
    ASSERT_EQ(dataset->size(), n);
    for (int i = 0; i < n; ++i) {
      EXPECT_EQ(dataset->t_ns(i), 1'000'000'000 + 100'000'000 * i);
      const StereoImages images = dataset->Read(i);
      EXPECT_EQ(images.left.at<uint8_t>(5, 7), TinyPixel(i, 0, 7, 5));
      EXPECT_EQ(images.right.at<uint8_t>(5, 7), TinyPixel(i, 1, 7, 5));
      ASSERT_TRUE(dataset->GroundTruth(i));
      EXPECT_EQ(dataset->GroundTruth(i)->translation(), Eigen::Vector3d(i, 0, 0));
    }
  }
  /// Its only note, of either kind.
  std::string Note() const {
    const Notes notes = OpenDataset(path_, "")->Notes();
    EXPECT_EQ(notes.warnings.size() + notes.remarks.size(), 1U);
    if (notes.empty()) return "";
    return notes.warnings.empty() ? notes.remarks.front() : notes.warnings.front();
  }

 private:
  TemporaryFolder folder_;
  std::string path_;
};

}  // namespace plslam::test
