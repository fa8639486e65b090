// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <pty.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <cstdlib>

#include "core/process/process_arguments.h"

namespace plslam {
namespace {

/// Returns whether log lines would have colours with the current standard error.
bool HasColours() {
  bus::SetUpLogging("test");
  auto* const sink = dynamic_cast<spdlog::sinks::stderr_color_sink_mt*>(spdlog::default_logger()->sinks()[0].get());
  return sink != nullptr && sink->should_color();
}

TEST(Logging, ColoursOnlyOnATerminalWithoutNoColor) {
  int master = -1, slave = -1;
  if (openpty(&master, &slave, nullptr, nullptr, nullptr) != 0) GTEST_SKIP() << "no terminals can be made here";
  const int kept = dup(STDERR_FILENO);
  setenv("TERM", "xterm", 1);
  unsetenv("NO_COLOR");
  dup2(slave, STDERR_FILENO);
  const bool terminal = HasColours();
  setenv("NO_COLOR", "1", 1);
  const bool unwanted = HasColours();
  setenv("NO_COLOR", "", 1);
  const bool empty = HasColours();
  unsetenv("NO_COLOR");
  dup2(kept, STDERR_FILENO);
  int pipe_ends[2];
  ASSERT_EQ(pipe(pipe_ends), 0);
  dup2(pipe_ends[1], STDERR_FILENO);
  const bool piped = HasColours();
  dup2(kept, STDERR_FILENO);
  for (const int fd : {kept, master, slave, pipe_ends[0], pipe_ends[1]}) close(fd);
  EXPECT_TRUE(terminal);
  EXPECT_FALSE(unwanted);
  EXPECT_TRUE(empty) << "an empty NO_COLOR counts as none";
  EXPECT_FALSE(piped);
}

}  // namespace
}  // namespace plslam
