// SPDX-License-Identifier: BSD-3-Clause
#include "core/files/atomic_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <string>

#include <gtest/gtest.h>

#include "tests/support/text_file.h"

namespace plslam {
namespace {

// `--out /dev/null` by root once replaced the device by a file, for all programs.
TEST(AtomicFile, PipesAndDevicesAreNotReplaced) {
  const ScratchFolder folder;
  const std::string pipe = folder.Path("pipe");
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  const int end = open(pipe.c_str(), O_RDWR);
  ASSERT_GE(end, 0);
  WriteFileAtomically(pipe, "abc");
  char bytes[3] = {};
  ASSERT_EQ(read(end, bytes, 3), 3);
  close(end);
  EXPECT_EQ(std::string(bytes, 3), "abc");
  EXPECT_TRUE(std::filesystem::is_fifo(pipe));
  EXPECT_FALSE(std::filesystem::exists(pipe + ".part"));
}

}  // namespace
}  // namespace plslam
