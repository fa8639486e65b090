// SPDX-License-Identifier: BSD-3-Clause
#include "tests/package/installed_tree.h"

#include <fmt/format.h>

#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>

#include "tests/support/data_folder.h"

namespace plslam::test {

namespace fs = std::filesystem;

InstalledTree::InstalledTree() {
  std::string pattern = testing::TempDir() + "package-XXXXXX";
  folder_ = mkdtemp(pattern.data());
}

InstalledTree::~InstalledTree() { fs::remove_all(folder_); }

void InstalledTree::Install(const std::string& component) {
  ASSERT_EQ(Shell(fmt::format("'{}' --install '{}' --prefix '{}' --component {} --strip", CMAKE_PROGRAM,
                              PLSLAM_BUILD_DIR, prefix().string(), component)),
            0)
      << output();
}

std::string InstalledTree::Packages() {
  const std::string packages = (fs::path(PLSLAM_BUILD_DIR) / "tests" / "packages").string();
  // The tests of this program run one by one.
  EXPECT_EQ(Shell(fmt::format(
                "cd '{0}'\n"
                "if [ -e '{1}/made' ] && [ -z \"$(find bin share python CPackConfig.cmake cmake_install.cmake "
                "copyright changelog.gz '{2}/core' '{2}/tools' -newer '{1}/made' -print -quit)\" ]; then "
                "exit 0; fi\n"
                "rm -rf '{1}' && '{3}' -B '{1}' -D CPACK_DEBIAN_COMPRESSION_TYPE=gzip && touch '{1}/made'",
                PLSLAM_BUILD_DIR, packages, SourceFolder().string(), CPACK_PROGRAM)),
            0)
      << output();
  return packages;
}

int InstalledTree::Shell(const std::string& script) {
  std::ofstream(folder_ / "script") << "cd '" << folder_.string() << "'\n" << script << "\n";
  const std::string line = fmt::format("sh '{0}/script' >'{0}/output' 2>&1", folder_.string());
  return WEXITSTATUS(std::system(line.c_str()));  // NOLINT: the test runs programs
}

std::string InstalledTree::Text(const std::string& file) const {
  std::ifstream stream(folder_ / file);
  return {std::istreambuf_iterator<char>(stream), {}};
}

bool InstalledTree::Has(const std::string& program) {
  return std::system(("command -v " + program + " >/dev/null").c_str()) == 0;  // NOLINT
}

void InstalledTree::ExpectThatItRuns(const fs::path& bin) {
  EXPECT_EQ(Shell(fmt::format("PATH='{}':/usr/bin:/bin\n"
                              "plslam run 'synthetic:room?frames=5&size=376x240' --out run --quiet",
                              bin.string())),
            0)
      << output();
  const auto summary = nlohmann::json::parse(Text("run/summary.json"), nullptr, false);
  ASSERT_FALSE(summary.is_discarded()) << output();
  EXPECT_EQ(summary["frames"], 5);
  EXPECT_TRUE(summary["processes"].contains("loop")) << "it needs the vocabularies: " << summary["processes"];
}

}  // namespace plslam::test
