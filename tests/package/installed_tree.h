// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <string>

namespace plslam::test {

/// A temporary folder with the installed tree in `prefix()`, and a shell in it.
class InstalledTree : public testing::Test {
 protected:
  InstalledTree();
  ~InstalledTree() override;

  const std::filesystem::path& folder() const { return folder_; }
  std::filesystem::path prefix() const { return folder_ / "prefix"; }
  /// Runs `cmake --install` of "runtime" or "dev".
  void Install(const std::string& component);
  /// Returns the exit code of a shell script, run in `folder()`; its output is in `output()`.
  int Shell(const std::string& script);
  std::string output() const { return Text("output"); }
  std::string Text(const std::string& file) const;
  static bool Has(const std::string& program);

  /// Makes all Debian packages, unless those of an earlier test are newer than the build, and returns their folder.
  std::string Packages();

  /// Runs a short world with the programs of `bin`, found only by PATH, and checks the results.
  void ExpectThatItRuns(const std::filesystem::path& bin);

 private:
  std::filesystem::path folder_;
};

}  // namespace plslam::test
