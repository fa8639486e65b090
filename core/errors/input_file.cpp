// SPDX-License-Identifier: BSD-3-Clause
#include "core/errors/input_file.h"

#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <stdexcept>

#include "core/errors/error_text.h"

namespace plslam {

std::string WhyUnreadable(const std::string& path) {
  struct stat status {};
  if (stat(path.c_str(), &status) != 0) return "cannot be read: " + ReasonOf(errno, path);
  if (S_ISDIR(status.st_mode)) return "cannot be read: it is a folder, not a file";
  // Not opened to see: a pipe would have lost its reader when it is closed again.
  if (access(path.c_str(), R_OK) != 0) return "cannot be read: " + ReasonOf(errno, path);
  return "";
}

std::ifstream OpenInput(const std::string& path) {
  const std::string why = WhyUnreadable(path);
  if (!why.empty()) throw std::runtime_error(path + ": " + why);
  std::ifstream file(path, std::ios::binary);
  if (!file) throw std::runtime_error(path + ": cannot be read: " + ReasonOf(errno, path));
  return file;
}

}  // namespace plslam
