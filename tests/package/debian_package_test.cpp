// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <gmock/gmock.h>

#include "tests/package/installed_tree.h"
#include "tests/support/python.h"

namespace plslam::test {
namespace {

using testing::HasSubstr;
using DebianPackage = InstalledTree;

TEST_F(DebianPackage, DependenciesAndRunFromAnUnpackedRoot) {
  for (const char* program : {"dpkg-deb", "dpkg-shlibdeps", "strip"}) {
    if (!Has(program)) GTEST_SKIP() << "no " << program << " here";
  }
  const std::string packages = Packages();
  ASSERT_EQ(Shell(fmt::format("dpkg-deb --field '{}'/plslam_*.deb", packages)), 0) << output();
  for (const char* part : {"Package: plslam\n", "liblcm1", "libopencv-core406", "libpng16-16", "libjpeg62-turbo",
                           "libcairo2", "libyaml-cpp0.7", "libsodium23"}) {
    EXPECT_THAT(output(), HasSubstr(part));
  }
  ASSERT_EQ(Shell(fmt::format("dpkg-deb --extract '{}'/plslam_*.deb root", packages)), 0) << output();
  ExpectThatItRuns(folder() / "root" / "usr" / "bin");
  ASSERT_EQ(Shell("grep -h ^ExecStart=/usr/bin/vo_process root/usr/share/plslam/systemd/plslam-vo@.service"), 0)
      << output();
}

TEST_F(DebianPackage, LintianFindsNoErrorInAnyOfThem) {
  for (const char* program : {"lintian", "dpkg-deb", "dpkg-shlibdeps", "strip"}) {
    if (!Has(program)) GTEST_SKIP() << "no " << program << " here";
  }
  const std::string packages = Packages();
  ASSERT_EQ(Shell(fmt::format("cd '{}' && ls plslam_*.deb libplslam-dev_*.deb python3-plslam_*.deb", packages)), 0)
      << output();
  EXPECT_EQ(Shell(fmt::format("lintian --allow-root --fail-on error --tag-display-limit 0 '{}'/*.deb", packages)), 0)
      << output();
}

TEST_F(DebianPackage, PythonIsAPackageOfItsOwn) {
  if (!Has("dpkg-deb")) GTEST_SKIP() << "no dpkg-deb here";
  const std::string packages = Packages();
  ASSERT_EQ(Shell(fmt::format("dpkg-deb --field '{}'/python3-plslam_*_all.deb", packages)), 0) << output();
  EXPECT_THAT(output(), testing::AllOf(HasSubstr("Architecture: all\n"), HasSubstr("python3-numpy")));
  ASSERT_EQ(Shell(fmt::format("dpkg-deb --extract '{}'/python3-plslam_*.deb root", packages)), 0) << output();
  ASSERT_EQ(
      Shell("ls root/usr/share/doc/python3-plslam/copyright root/usr/share/doc/python3-plslam/examples/to_ros2.py"),
      0)
      << output();
  const std::string python = PythonWithNumpy();
  if (python.empty()) GTEST_SKIP() << "no Python with numpy here";
  EXPECT_EQ(Shell("PYTHONDONTWRITEBYTECODE=1 PYTHONPATH=root/usr/lib/python3/dist-packages " + python +
                  " -c 'import plslam; print(plslam.pose_t().frame_id, plslam.load_map.__module__)'"),
            0)
      << output();
  EXPECT_EQ(output(), "0 plslam.map_file\n");
}

}  // namespace
}  // namespace plslam::test
