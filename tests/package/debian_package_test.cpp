#include <fmt/format.h>
#include <gmock/gmock.h>

#include "tests/package/installed_tree.h"

namespace plslam::test {
namespace {

using testing::HasSubstr;
using DebianPackage = InstalledTree;

TEST_F(DebianPackage, KnowsWhatItNeedsAndRunsFromAnUnpackedRoot) {
  for (const char* program : {"dpkg-deb", "dpkg-shlibdeps", "strip"}) {
    if (!Has(program)) GTEST_SKIP() << "no " << program << " here";
  }
  ASSERT_EQ(Shell(fmt::format("'{}' --config '{}/CPackConfig.cmake' -B packages -D CPACK_COMPONENTS_ALL=runtime "
                              "-D CPACK_DEBIAN_COMPRESSION_TYPE=none",
                              CPACK_PROGRAM, PLSLAM_BUILD_DIR)),
            0)
      << output();
  ASSERT_EQ(Shell("dpkg-deb --field packages/plslam_*.deb"), 0) << output();
  for (const char* part : {"Package: plslam\n", "liblcm1", "libopencv-core406", "libpng16-16", "libjpeg62-turbo",
                           "libyaml-cpp0.7", "libsodium23"}) {
    EXPECT_THAT(output(), HasSubstr(part));
  }
  ASSERT_EQ(Shell("dpkg-deb --extract packages/plslam_*.deb root"), 0) << output();
  ExpectThatItRuns(folder() / "root" / "usr" / "bin");
  ASSERT_EQ(Shell("grep -h ^ExecStart=/usr/bin/vo_process root/usr/share/plslam/systemd/plslam-vo@.service"), 0)
      << output();
}

}  // namespace
}  // namespace plslam::test
