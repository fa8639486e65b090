// SPDX-License-Identifier: BSD-3-Clause
#include "tools/export/surface_files.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <sstream>
#include <stdexcept>
#include <utility>

#include <fmt/format.h>

#include "core/files/shared_file.h"
#include "core/process/argument_vector.h"

namespace plslam::exports {
namespace {

constexpr const char* kProgram = "plslam_surfaces";

/// Output of a program, standard error included.
struct Output {
  std::string text;
  int status = 0;  ///< of waitpid
};

/// Throws std::runtime_error if the program cannot be started.
Output RunProgram(std::vector<std::string> words) {
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0) throw std::runtime_error(fmt::format("no pipe: {}", std::strerror(errno)));
  posix_spawn_file_actions_t files;
  posix_spawn_file_actions_init(&files);
  posix_spawn_file_actions_adddup2(&files, ends[1], STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&files, ends[1], STDERR_FILENO);
  const std::vector<char*> arguments = ArgumentVector(words);
  pid_t pid = -1;
  const int error = posix_spawn(&pid, arguments[0], &files, nullptr, arguments.data(), environ);
  posix_spawn_file_actions_destroy(&files);
  close(ends[1]);
  Output output;
  char bytes[4096];
  for (ssize_t n = 0; error == 0;) {
    n = read(ends[0], bytes, sizeof(bytes));
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) break;
    output.text.append(bytes, static_cast<size_t>(n));
  }
  close(ends[0]);
  if (error != 0) {
    throw std::runtime_error(fmt::format("{} cannot be started ({}): it is in the Debian package plslam-dense",
                                         words[0], std::strerror(error)));
  }
  while (waitpid(pid, &output.status, 0) < 0 && errno == EINTR) {
  }
  return output;
}

}  // namespace

bool HasSurfaces(const std::string& map_path) {
  return !map_path.empty() && std::filesystem::exists(map_path + ".surfaces");
}

std::vector<std::string> WriteSurfaceFiles(const std::string& map_path, const std::string& out,
                                           const std::vector<std::string>& kinds) {
  std::vector<std::string> words{ProgramFolder() / kProgram, map_path, "--out", out, "--format"};
  words.insert(words.end(), kinds.begin(), kinds.end());
  const Output output = RunProgram(std::move(words));
  std::istringstream text(output.text);
  std::vector<std::string> lines;
  for (std::string line; std::getline(text, line);) lines.push_back(line);
  if (output.status == 0) return lines;
  const std::string prefix = fmt::format("{}: error: ", kProgram);
  const std::string last = lines.empty() ? fmt::format("{} ended without a message", kProgram) : lines.back();
  throw std::runtime_error(last.starts_with(prefix) ? last.substr(prefix.size()) : last);
}

}  // namespace plslam::exports
