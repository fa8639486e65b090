// SPDX-License-Identifier: BSD-3-Clause
#include "core/errors/error_text.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <stdexcept>

#include "tests/support/text_file.h"

namespace plslam {
namespace {

using testing::ThrowsMessage;

TEST(OpenInput, ReadsAFile) {
  const ScratchFolder folder;
  std::string word;
  OpenInput(folder.Write("a", "one two")) >> word;
  EXPECT_EQ(word, "one");
  EXPECT_EQ(WhyUnreadable(folder.Path("a")), "");
}

TEST(OpenInput, SaysWhyNot) {
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
  // Root may read everything; what it turns into here does not come back.
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
              "Permission denied .the folder .*closed is closed to this user");
  chmod(folder.Path("closed").c_str(), 0700);
}

}  // namespace
}  // namespace plslam
