// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <unistd.h>

#include "tests/package/installed_tree.h"
#include "tests/support/data_folder.h"
#include "tests/support/long_tests.h"

namespace plslam::test {
namespace {

using testing::HasSubstr;

class Containerfile : public InstalledTree {
 protected:
  int Play(const std::string& options) {
    return Shell(
        fmt::format("python3 '{0}/tests/package/play_containerfile.py' '{0}/Containerfile' \"$PWD/stages\" {1}",
                    SourceFolder().string(), options));
  }
};

TEST_F(Containerfile, IsParsed) {
  EXPECT_EQ(Play("--check"), 0) << output();
  EXPECT_THAT(output(), HasSubstr("containerfile: 2 stages"));
}

/// Builds everything from scratch in one Debian and installs the package in another one: takes some tens of minutes.
TEST_F(Containerfile, BuildsAndRuns) {
  PLSLAM_REQUIRE_LONG_TESTS();
  if (geteuid() != 0) GTEST_SKIP() << "a root of its own can be made by root only";
  for (const char* program : {"mmdebstrap", "unshare", "chroot"}) {
    if (!Has(program)) GTEST_SKIP() << "no " << program << " here";
  }
  EXPECT_EQ(Play(""), 0) << output();
  EXPECT_THAT(output(), HasSubstr("containerfile: 2 stages"));
}

}  // namespace
}  // namespace plslam::test
