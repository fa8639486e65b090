// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <unistd.h>

#include "tests/package/installed_tree.h"
#include "tests/support/data_folder.h"

namespace plslam::test {
namespace {

using testing::HasSubstr;
using CleanRoot = InstalledTree;

/// Everything that the programs need is in the package or its dependencies: the root has no files of a developer's
/// machine.
TEST_F(CleanRoot, PackageInstallsAndRuns) {
  if (geteuid() != 0) GTEST_SKIP() << "a root of its own can be made by root only";
  for (const char* program : {"mmdebstrap", "unshare", "chroot", "dpkg-shlibdeps", "strip"}) {
    if (!Has(program)) GTEST_SKIP() << "no " << program << " here";
  }
  if (Shell("python3 -c 'import os, urllib.request as u; "
            "u.urlopen(os.environ.get(\"DEBIAN_MIRROR\", \"http://deb.debian.org/debian\") + "
            "\"/dists/bookworm/Release\", timeout=20)'") != 0) {
    GTEST_SKIP() << "no mirror of Debian can be reached: " << output();
  }
  ASSERT_EQ(Shell(fmt::format("'{}' --config '{}/CPackConfig.cmake' -B packages -D CPACK_COMPONENTS_ALL=runtime "
                              "-D CPACK_DEBIAN_COMPRESSION_TYPE=none",
                              CPACK_PROGRAM, PLSLAM_BUILD_DIR)),
            0)
      << output();
  const std::string script = (SourceFolder() / "tests/package/clean_root.sh").string();
  EXPECT_EQ(Shell(fmt::format("'{}' packages/plslam_*.deb \"$PWD/root\"", script)), 0) << output();
  EXPECT_THAT(output(), HasSubstr("clean root: installed and run"));
}

}  // namespace
}  // namespace plslam::test
