// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <sstream>

#include "tests/package/installed_tree.h"
#include "tests/support/data_folder.h"

namespace plslam::test {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using Notice = InstalledTree;

std::string TextOf(const fs::path& path) {
  std::ifstream stream(path);
  return {std::istreambuf_iterator<char>(stream), {}};
}

/// Licences by library, from the table of section 3: "libfmt.so" -> "Expat".
std::map<std::string, std::string> LicencesOfNotice() {
  std::map<std::string, std::string> licences;
  std::istringstream lines(TextOf(SourceFolder() / "NOTICE"));
  static const std::regex kRow(R"(  (lib\S+\.so) +(\S+).*)");
  std::smatch match;
  for (std::string line; std::getline(lines, line);) {
    if (std::regex_match(line, match, kRow)) licences[match[1]] = match[2];
  }
  return licences;
}

/// Libraries of a program that is not built everywhere.
std::set<std::string> LibrariesOnlyOf(const std::string& program) {
  std::set<std::string> libraries;
  std::istringstream lines(TextOf(SourceFolder() / "NOTICE"));
  const std::regex row(R"(  (lib\S+\.so) +\S+ +)" + program + "( and plslam_film)? only.*");
  std::smatch match;
  for (std::string line; std::getline(lines, line);) {
    if (std::regex_match(line, match, row)) libraries.insert(match[1]);
  }
  return libraries;
}

/// "libfmt.so.9" -> "libfmt.so", and "libopencv_core.so.406" -> "libopencv_core.so".
std::string WithoutVersion(const std::string& soname) { return soname.substr(0, soname.find(".so") + 3); }

/// Returns all words in the lines of `text`.
std::set<std::string> Words(const std::string& text) {
  std::istringstream stream(text);
  return {std::istream_iterator<std::string>(stream), {}};
}

TEST_F(Notice, NamesEveryLibraryThatAnInstalledProgramLinks) {
  if (!Has("readelf")) GTEST_SKIP() << "no readelf here";
  Install("runtime");
  if (fs::exists(BinaryFolder() / "dense_process")) Install("dense");
  if (fs::exists(BinaryFolder() / "plslam_bridge")) Install("bridge");
  if (fs::exists(BinaryFolder() / "plslam_ros2")) Install("ros2");
  ASSERT_EQ(
      Shell(fmt::format("readelf -d '{}'/bin/* | sed -n 's/.*(NEEDED).*\\[\\(.*\\)\\]/\\1/p'", prefix().string())), 0)
      << output();
  std::set<std::string> linked;
  // The sanitizers' libraries, and the loader, are of the compiler.
  for (const std::string& soname : Words(output())) {
    if (!std::regex_match(soname, std::regex("(ld-linux|lib[a-z]+san).*"))) linked.insert(WithoutVersion(soname));
  }
  EXPECT_GT(linked.size(), 10U) << output();
  const auto licences = LicencesOfNotice();
  for (const std::string& library : linked) EXPECT_TRUE(licences.contains(library)) << library << " is not in NOTICE";
  std::set<std::string> optional;
  for (const char* program : {"camera", "dense_process", "plslam_bridge", "plslam_ros2"}) {
    if (!fs::exists(prefix() / "bin" / program)) optional.merge(LibrariesOnlyOf(program));
  }
  for (const auto& [library, licence] : licences) {
    EXPECT_TRUE(linked.contains(library) || optional.contains(library))
        << library << " is in NOTICE, and no program links it";
  }
}

TEST_F(Notice, StatesTheLicencesThatDebianStates) {
  if (!Has("dpkg-query") || !Has("ldconfig")) GTEST_SKIP() << "no Debian here";
  int compared = 0;
  for (const auto& [library, licence] : LicencesOfNotice()) {
    // Finds the file of the library, its package (which may list the file without /usr), and that package's copyright.
    const std::string find = fmt::format(
        "file=$(ldconfig -p | sed -n 's|^\\s*{0}\\.[0-9a-z]* .*=> ||p' | head -n 1)\n"
        "file=$(readlink -f \"$file\")\n"
        "package=$(dpkg-query --search \"$file\" \"${{file#/usr}}\" 2>/dev/null | head -n 1 | cut -d: -f1)\n"
        "cat \"/usr/share/doc/$package/copyright\" 2>/dev/null",
        library);
    if (Shell(find) != 0) continue;  // Debian's, but not installed from a package, or without documents.
    // Upper or lower case, and the Apache licence of LAPACK's builds aside, Debian's words are ours.
    std::string text = output();
    std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return std::tolower(c); });
    text = std::regex_replace(text, std::regex("license: +"), "license: ");
    std::string wanted = licence;
    std::transform(wanted.begin(), wanted.end(), wanted.begin(), [](unsigned char c) { return std::tolower(c); });
    // Copyright files that predate the common format have the full names.
    static const std::map<std::string, std::string> kInFull{{"lgpl-2.1+", "lesser general public license"},
                                                            {"lgpl-2.1", "common-licenses/lgpl-2.1"},
                                                            {"gpl-3+", "general public license"}};
    const auto full = kInFull.find(wanted);
    EXPECT_TRUE(text.find("license: " + wanted) != std::string::npos ||
                (text.find("\nlicense:") == std::string::npos && full != kInFull.end() &&
                 text.find(full->second) != std::string::npos))
        << library << ": NOTICE says " << licence << ", and Debian's copyright file does not";
    ++compared;
  }
  EXPECT_GT(compared, 10);
}

TEST_F(Notice, IsInstalled) {
  Install("runtime");
  for (const char* file : {"LICENSE", "NOTICE", "CITATION.cff", "copyright"}) {
    EXPECT_TRUE(fs::exists(prefix() / "share/doc/plslam" / file)) << file;
  }
  const std::string copyright = TextOf(prefix() / "share/doc/plslam/copyright");
  for (const char* part : {"copyright-format/1.0/", "License: BSD-3-Clause", "License: Expat", "three.js", "uPlot"}) {
    EXPECT_THAT(copyright, HasSubstr(part));
  }
  Install("dev");
  EXPECT_TRUE(fs::exists(prefix() / "share/doc/libplslam-dev/copyright"));
}

TEST_F(Notice, NamesTheVersionsOfTheLicenceOfThePage) {
  const std::string notice = TextOf(SourceFolder() / "NOTICE");
  const std::string lock = TextOf(SourceFolder() / "viewer_headless/page/package.json");
  std::istringstream lines(lock.substr(lock.find("\"dependencies\"")));
  static const std::regex kPackage(R"re(\s+"([a-z]+)": "[0-9.]+",?)re");
  const std::map<std::string, std::string> names{{"three", "three.js"}, {"uplot", "uPlot"}};
  std::smatch match;
  for (std::string line; std::getline(lines, line);) {
    // The bundler, esbuild, leaves none of its own code in the page.
    if (!std::regex_match(line, match, kPackage) || match[1] == "esbuild") continue;
    ASSERT_TRUE(names.contains(match[1])) << match[1] << " is bundled into the page: name it in NOTICE and here";
    EXPECT_THAT(notice, HasSubstr("\n  " + names.at(match[1]) + " "));
  }
}

}  // namespace
}  // namespace plslam::test
