// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <string>

namespace plslam::test {

/// A folder of its own with the installed tree in `prefix()`, and a shell in it.
class InstalledTree : public testing::Test {
 protected:
  InstalledTree();
  ~InstalledTree() override;

  const std::filesystem::path& folder() const { return folder_; }
  std::filesystem::path prefix() const { return folder_ / "prefix"; }
  /// `cmake --install` of "runtime" or "dev".
  void Install(const std::string& component);
  /// Exit code of a shell script, run in `folder()`; what it says is in `output()`.
  int Shell(const std::string& script);
  std::string output() const { return Text("output"); }
  std::string Text(const std::string& file) const;
  static bool Has(const std::string& program);

  /// Runs a short world with the programs of `bin`, found by PATH alone, and checks what came out.
  void ExpectThatItRuns(const std::filesystem::path& bin);

 private:
  std::filesystem::path folder_;
};

}  // namespace plslam::test
