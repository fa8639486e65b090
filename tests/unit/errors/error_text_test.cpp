// SPDX-License-Identifier: BSD-3-Clause
#include <unistd.h>

#include <sys/stat.h>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <new>
#include <stdexcept>
#include <system_error>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/errors/error_text.h"
#include "tests/support/text_file.h"

namespace plslam {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

TEST(Shown, BytesOfABinaryFileDoNotReachTheTerminal) {
  EXPECT_EQ(Shown("fx = 1.5"), "fx = 1.5");
  EXPECT_EQ(Shown(std::string_view("\x1b[2J\0\xff\t", 7)), "\\x1b[2J\\x00\\xff\\x09");
}

TEST(Shown, SixtyCharactersAreShownAndNoMore) {
  EXPECT_EQ(Shown(std::string(60, 'a')), std::string(60, 'a'));
  EXPECT_EQ(Shown(std::string(61, 'a')), std::string(57, 'a') + "...");
  EXPECT_EQ(Shown(std::string(55, 'a') + std::string(1000, '\x01')), std::string(55, 'a') + "...")
      << "no half of an escape";
}

TEST(SentenceOf, OwnErrorsAreUnchanged) {
  EXPECT_EQ(SentenceOf(std::runtime_error("a.txt:3: no number")), "a.txt:3: no number");
}

TEST(SentenceOf, ErrorsOfFilesNameThePathFirst) {
  const auto denied = std::make_error_code(std::errc::permission_denied);
  EXPECT_EQ(SentenceOf(fs::filesystem_error("status", "/data/x", denied)),
            "/data/x: cannot be read: Permission denied");
  EXPECT_EQ(SentenceOf(fs::filesystem_error("directory iterator cannot open directory", "/data", denied)),
            "/data: cannot be read: Permission denied");
  EXPECT_EQ(SentenceOf(fs::filesystem_error("cannot create directories", "/out/a", denied)),
            "/out/a: the folder cannot be created: Permission denied");
  EXPECT_EQ(SentenceOf(fs::filesystem_error("cannot copy file", "/a", "/b", denied)),
            "/a: cannot copy file: Permission denied");
}

/// As the library throws it: a loop of links cannot be followed.
TEST(SentenceOf, ErrorsThatTheLibraryThrows) {
  const fs::path loop = fs::path(testing::TempDir()) / "plslam_loop";
  fs::remove(loop);
  fs::create_symlink(loop, loop);
  std::string sentence;
  try {
    static_cast<void>(fs::exists(loop / "x"));
  } catch (const std::exception& error) {
    sentence = SentenceOf(error);
  }
  fs::remove(loop);
  EXPECT_EQ(sentence, (loop / "x").string() + ": cannot be read: Too many levels of symbolic links");
}

TEST(SentenceOf, ThreadsAndMemoryNameTheLimitAndItsCommand) {
  const std::system_error threads(std::make_error_code(std::errc::resource_unavailable_try_again));
  EXPECT_THAT(SentenceOf(threads), AllOf(HasSubstr("Resource temporarily unavailable"), HasSubstr("ulimit -u")));
  EXPECT_THAT(SentenceOf(std::bad_alloc()),
              AllOf(HasSubstr("not enough memory"), HasSubstr(" MB"), Not(HasSubstr("bad_alloc"))));
  EXPECT_THAT(ReasonOf(EMFILE), AllOf(HasSubstr("Too many open files"), HasSubstr("ulimit -n")));
}

TEST(WithMemoryFor, NamesTheTooLargeObject) {
  const auto too_much = [] { return WithMemoryFor("room.plmap: 3000 MB", []() -> int { throw std::bad_alloc(); }); };
  EXPECT_THAT(too_much, testing::ThrowsMessage<std::runtime_error>(
                            testing::StartsWith("room.plmap: 3000 MB: not enough memory")));
  EXPECT_EQ(WithMemoryFor("x", [] { return 3; }), 3);
  const auto other = [] { return WithMemoryFor("x", []() -> int { throw std::invalid_argument("y"); }); };
  EXPECT_THROW(other(), std::invalid_argument);
}

TEST(YamlComplaint, TabIsFoundIfTheParserBlamesAnotherLine) {
  EXPECT_EQ(YamlComplaint("rig.yaml", "vo:\n\tseed: 1\n  x: 2\n", 2, "illegal map value"),
            "rig.yaml:2: is indented by a tab; YAML requires spaces");
  EXPECT_EQ(YamlComplaint("rig.yaml", "vo:\n  \tseed: 1\n", 1, "x"),
            "rig.yaml:2: is indented by a tab; YAML requires spaces");
  EXPECT_EQ(YamlComplaint("rig.yaml", "\t# a comment may\na: b: c\n", 1, "illegal map value"),
            "rig.yaml:2: not valid YAML: illegal map value ('a: b: c')");
}

TEST(YamlComplaint, LineWithoutAKeyIsFoundIfTheNextIsBlamed) {
  EXPECT_EQ(YamlComplaint("rig.yaml", "a: 1\nb 2\n\n# c\nd: 3\n", 4, "illegal map value"),
            "rig.yaml:2: not valid YAML: no `key: value` ('b 2')");
}

TEST(YamlComplaint, BinaryFileIsRecognised) {
  EXPECT_EQ(YamlComplaint("a.png", std::string_view("\x89PNG\r\n\0\0", 8), 0, "x"),
            "a.png: is not YAML, but binary: \\x89PNG\\x0d\\x0a\\x00\\x00");
}

}  // namespace

namespace {

using testing::ThrowsMessage;

TEST(OpenInput, ReadsAFile) {
  const ScratchFolder folder;
  std::string word;
  OpenInput(folder.Write("a", "one two")) >> word;
  EXPECT_EQ(word, "one");
  EXPECT_EQ(WhyUnreadable(folder.Path("a")), "");
}

TEST(OpenInput, ReportsTheReason) {
  const ScratchFolder folder;
  EXPECT_THAT([&] { OpenInput(folder.Path("none")); },
              ThrowsMessage<std::runtime_error>(folder.Path("none") + ": cannot be read: No such file or directory"));
  EXPECT_THAT([&] { OpenInput(folder.Path("")); },
              ThrowsMessage<std::runtime_error>(folder.Path("") + ": cannot be read: it is a folder, not a file"));
  EXPECT_THAT([&] { OpenInput(folder.Write("a", "") + "/b"); },
              ThrowsMessage<std::runtime_error>(folder.Path("a") + "/b: cannot be read: Not a directory"));
}

TEST(OpenInput, PermissionIsNamed) {
  const ScratchFolder folder;
  const std::string secret = folder.Write("secret", "x");
  chmod(secret.c_str(), 0);
  // Root may read everything; dropping its privileges here is irreversible.
  const auto as_a_user = [&](const std::string& path) {
    if (geteuid() == 0 && setuid(65534) != 0) std::exit(2);
    std::fputs(WhyUnreadable(path).c_str(), stderr);
    std::exit(0);
  };
  EXPECT_EXIT(as_a_user(secret), testing::ExitedWithCode(0), "^cannot be read: Permission denied$");
  std::filesystem::create_directory(folder.Path("closed"));
  const std::string within = folder.Write("closed/a", "x");
  chmod(folder.Path("closed").c_str(), 0);
  EXPECT_EXIT(as_a_user(within), testing::ExitedWithCode(0),
              "Permission denied .this user cannot access the folder .*closed");
  chmod(folder.Path("closed").c_str(), 0700);
}

}  // namespace
}  // namespace plslam
