// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <optional>
#include <string>

namespace plslam::test {

/// Returns the folder of a real sequence under PLSLAM_DATA (or the default beside the checkout); nullopt if it is
/// absent.
std::optional<std::filesystem::path> DataFolder(const std::string& sequence);

/// Root of the source tree, and folder of the built executables.
std::filesystem::path SourceFolder();
std::filesystem::path BinaryFolder();

}  // namespace plslam::test

/// Leaves the test, visibly skipped, where the real sequence is absent. Declares `folder`.
#define PLSLAM_REQUIRE_DATA(folder, sequence)                                                    \
  const auto folder##_or_none = plslam::test::DataFolder(sequence);                              \
  if (!folder##_or_none) GTEST_SKIP() << "no real data: set PLSLAM_DATA to find " << (sequence); \
  const std::filesystem::path& folder = *folder##_or_none
