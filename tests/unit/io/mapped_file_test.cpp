// SPDX-License-Identifier: BSD-3-Clause
#include "core/files/mapped_file.h"

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace plslam {
namespace {

std::string TextOf(const MappedFile& file) { return {file.bytes().begin(), file.bytes().end()}; }

std::span<const std::byte> BytesOf(const std::string& text) { return std::as_bytes(std::span(text)); }

/// TMPDIR is a folder of the test.
class MappedFileTest : public testing::Test {
 protected:
  MappedFileTest() {
    std::filesystem::create_directory(folder_);
    ::setenv("TMPDIR", folder_.c_str(), 1);
  }
  ~MappedFileTest() override {
    if (was_.empty()) {
      ::unsetenv("TMPDIR");
    } else {
      ::setenv("TMPDIR", was_.c_str(), 1);
    }
    std::filesystem::remove_all(folder_);
  }

  const std::string was_ = std::getenv("TMPDIR") != nullptr ? std::getenv("TMPDIR") : "";
  const std::filesystem::path folder_ =
      std::filesystem::temp_directory_path() / ("mapped_file_" + std::to_string(reinterpret_cast<uintptr_t>(this)));
};

TEST_F(MappedFileTest, TemporaryFileHasThePartsAndNoName) {
  const std::string first = "first ", large(3'000'000, 'x');
  const auto file = MappedFile::Temporary({BytesOf(first), BytesOf(large)});
  ASSERT_NE(file, nullptr);
  EXPECT_EQ(TextOf(*file), first + large);
  EXPECT_TRUE(std::filesystem::is_empty(folder_));
  file->LeaveMemory(0, file->bytes().size());
  EXPECT_EQ(TextOf(*file), first + large) << "it is read again";
}

TEST_F(MappedFileTest, TemporaryFileOfNoPartsIsEmpty) {
  const auto file = MappedFile::Temporary({});
  ASSERT_NE(file, nullptr);
  EXPECT_TRUE(file->bytes().empty());
  file->LeaveMemory(0, file->bytes().size());
}

TEST_F(MappedFileTest, TemporaryFileNeedsAFolder) {
  ::setenv("TMPDIR", (folder_ / "not there").c_str(), 1);
  EXPECT_EQ(MappedFile::Temporary({BytesOf("text")}), nullptr);
}

TEST_F(MappedFileTest, ExistingFileIsRead) {
  const std::string path = (folder_ / "file").string();
  std::ofstream(path) << "text";
  EXPECT_EQ(TextOf(*MappedFile::Open(path)), "text");
  std::ofstream(path, std::ios::trunc).flush();
  EXPECT_TRUE(MappedFile::Open(path)->bytes().empty());
}

TEST_F(MappedFileTest, UnreadableFileIsReported) {
  const auto why = [](const std::string& path) {
    try {
      MappedFile::Open(path);
    } catch (const std::runtime_error& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_THAT(why((folder_ / "not there").string()), testing::StartsWith("cannot be read: "));
  EXPECT_EQ(why(folder_.string()), "is not a regular file");
}

TEST(TemporaryRoot, IsTmpdirOrADiskFolder) {
  const char* was = std::getenv("TMPDIR");
  const std::string before = was != nullptr ? was : "";
  ::setenv("TMPDIR", "/some/where", 1);
  EXPECT_EQ(TemporaryRoot(), "/some/where");
  ::unsetenv("TMPDIR");
  EXPECT_THAT(TemporaryRoot(), testing::AnyOf("/var/tmp", "/tmp"));
  if (was != nullptr) ::setenv("TMPDIR", before.c_str(), 1);
}

}  // namespace
}  // namespace plslam
