// SPDX-License-Identifier: BSD-3-Clause
#include "core/errors/standard_streams.h"

#include <signal.h>

#include <cerrno>
#include <cstdio>
#include <cstring>

namespace plslam {

void IgnoreFileSizeSignal() { signal(SIGXFSZ, SIG_IGN); }

void PrintError(const std::string& line) { std::fputs((line + "\n").c_str(), stderr); }

int FlushOutput(const std::string& program, int exit_code) {
  // An earlier write may have failed, too; its bytes are still in the buffer.
  errno = 0;
  if (std::fflush(stdout) == 0 && std::ferror(stdout) == 0) return exit_code;
  const int reason = errno;
  if (reason == EPIPE || reason == EIO) return exit_code;
  PrintError(program + ": error: standard output: cannot be written" +
             (reason == 0 ? "" : std::string(": ") + std::strerror(reason)));
  return 1;
}

}  // namespace plslam
