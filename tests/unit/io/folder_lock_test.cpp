// SPDX-License-Identifier: BSD-3-Clause
#include "core/files/folder_lock.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <functional>
#include <memory>
#include <stdexcept>

#include "tests/support/text_file.h"

namespace plslam {
namespace {

using testing::HasSubstr;

std::string WhyNot(const std::string& folder) {
  try {
    const FolderLock lock(folder);
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "";
}

/// A process that has the folder, and waits.
class Holder {
 public:
  explicit Holder(const std::string& folder, const std::function<bool()>& meanwhile = nullptr) {
    int ready[2];
    if (pipe(ready) != 0) throw std::runtime_error("no pipe");
    pid_ = fork();
    if (pid_ == 0) {
      const FolderLock lock(folder);
      const char well = !meanwhile || meanwhile() ? 'y' : 'n';
      if (write(ready[1], &well, 1) != 1) _exit(1);
      pause();
      _exit(0);
    }
    close(ready[1]);
    char well = 'n';
    well_ = read(ready[0], &well, 1) == 1 && well == 'y';
    close(ready[0]);
  }
  ~Holder() {
    kill(pid_, SIGKILL);
    waitpid(pid_, nullptr, 0);
  }
  Holder(const Holder&) = delete;
  Holder& operator=(const Holder&) = delete;

  pid_t pid() const { return pid_; }
  bool well() const { return well_; }

 private:
  pid_t pid_ = -1;
  bool well_ = false;
};

TEST(FolderLock, HeldUntilItsProcessEnds) {
  const ScratchFolder folder;
  {
    const Holder holder(folder.Path(""));
    ASSERT_TRUE(holder.well());
    EXPECT_THAT(WhyNot(folder.Path("")), HasSubstr("process " + std::to_string(holder.pid()) + " ("));
    EXPECT_THAT(WhyNot(folder.Path("")), HasSubstr("io_test")) << "its command line";
  }
  EXPECT_EQ(WhyNot(folder.Path("")), "");
  EXPECT_TRUE(std::filesystem::is_empty(folder.Path(""))) << "no litter";
}

TEST(FolderLock, SharedWithChildProcesses) {
  const ScratchFolder folder;
  const Holder holder(folder.Path(""), [&] {
    const pid_t child = fork();
    if (child == 0) _exit(WhyNot(folder.Path("")).empty() ? 0 : 1);
    int status = -1;
    return waitpid(child, &status, 0) == child && WIFEXITED(status) && WEXITSTATUS(status) == 0;
  });
  EXPECT_TRUE(holder.well());
}

TEST(FolderLock, MissingFolderIsNamed) { EXPECT_THAT(WhyNot("/no/such/folder"), HasSubstr("/no/such/folder: ")); }

}  // namespace
}  // namespace plslam
