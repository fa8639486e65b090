// SPDX-License-Identifier: BSD-3-Clause
#include "core/io/files/atomic_file.h"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <stdexcept>
#include <system_error>

namespace plslam {
namespace {

[[noreturn]] void Fail(const std::string& path, const char* what, const std::string& besides = "") {
  const int reason = errno;
  std::remove((path + ".part").c_str());
  throw std::runtime_error(path + ": cannot be " + what + ": " + std::strerror(reason) + besides);
}

}  // namespace

void WriteFileAtomically(const std::string& path, std::string_view content) { WriteFileAtomically(path, {content}); }

void WriteFileAtomically(const std::string& path, std::initializer_list<std::string_view> parts) {
  const std::string part_path = path + ".part";
  std::FILE* file = std::fopen(part_path.c_str(), "wb");
  if (file == nullptr) Fail(path, "created");
  bool written = true;
  size_t bytes = 0;
  for (const std::string_view part : parts) {
    bytes += part.size();
    written = written && std::fwrite(part.data(), 1, part.size(), file) == part.size();
  }
  // A full disk may show only when the last buffer goes out.
  const bool closed = std::fclose(file) == 0;
  if (!written || !closed) Fail(path, "written", " (it has " + std::to_string(bytes) + " bytes)");
  if (std::rename(part_path.c_str(), path.c_str()) != 0) Fail(path, "put in place");
}

void MakeFolder(const std::string& folder) {
  if (folder.empty()) return;
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) throw std::runtime_error(folder + ": cannot be made a folder: " + error.message());
}

}  // namespace plslam
