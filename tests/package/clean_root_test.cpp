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
TEST_F(CleanRoot, EachPackageInstallsAndRuns) {
  if (geteuid() != 0) GTEST_SKIP() << "a root of its own can be made by root only";
  for (const char* program : {"mmdebstrap", "unshare", "chroot", "dpkg-shlibdeps", "strip"}) {
    if (!Has(program)) GTEST_SKIP() << "no " << program << " here";
  }
  if (Shell("python3 -c 'import os, urllib.request as u; "
            "u.urlopen(os.environ.get(\"DEBIAN_MIRROR\", \"http://deb.debian.org/debian\") + "
            "\"/dists/bookworm/Release\", timeout=20)'") != 0) {
    GTEST_SKIP() << "no mirror of Debian can be reached: " << output();
  }
  const std::string packages = Packages();
  const std::string scripts = (SourceFolder() / "tests/package").string();
  ASSERT_EQ(Shell(fmt::format("'{}/clean_root.sh' '{}'/plslam_*.deb \"$PWD/root\"", scripts, packages)), 0)
      << output();
  EXPECT_THAT(output(), HasSubstr("clean root: installed and run"));

  // Each of the others on top of it alone, within a minute.
  for (const auto& [package, commands] : {
           std::pair("plslam-dense_",
                     "plslam run 'synthetic:room?frames=30' --dense --out dense --quiet\n"
                     "test -s dense/cloud.ply && test -s dense/map.pgm && test -s dense/map.bt"),
           std::pair("plslam-bridge_",
                     "timeout --preserve-status -s INT 2 plslam bridge --url memq:// >log 2>&1\n"
                     "grep -q 'ws://' log"),
           std::pair("plslam-ros2_", "plslam topics ros2: >log 2>&1 || grep -q 'no publisher of ROS 2' log"),
           std::pair("python3-plslam_", "python3 -c 'import plslam; plslam.load_map(\"room.plmap\")'"),
       }) {
    if (Shell(fmt::format("ls '{}'/{}*.deb", packages, package)) != 0) continue;  // built without its libraries
    EXPECT_EQ(Shell(fmt::format("'{}/also_in_root.sh' \"$PWD/root\" '{}'/{}*.deb \"$(cat <<'END'\n{}\nEND\n)\"",
                                scripts, packages, package, commands)),
              0)
        << package << '\n'
        << output();
  }
  // The 250 packages of OpenCV that it asks for can be installed, but not within a minute.
  EXPECT_EQ(
      Shell(fmt::format("cp '{}'/libplslam-dev_*.deb root/tmp/dev.deb && chroot root apt-get install --simulate -qq "
                        "--no-install-recommends /tmp/dev.deb",
                        packages)),
      0)
      << output();
}

}  // namespace
}  // namespace plslam::test
