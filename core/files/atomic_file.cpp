// SPDX-License-Identifier: BSD-3-Clause
#include "core/files/atomic_file.h"

#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <stdexcept>
#include <system_error>
#include <utility>

namespace plslam {
namespace {

/// A device, a pipe or a socket: renaming a file over it would destroy it for all other programs.
bool IsStream(const std::string& path) {
  struct stat status = {};
  return stat(path.c_str(), &status) == 0 && !S_ISREG(status.st_mode) && !S_ISDIR(status.st_mode);
}

}  // namespace

AtomicFile::AtomicFile(std::string path)
    : path_(std::move(path)), part_path_(IsStream(path_) ? path_ : path_ + ".part") {
  file_ = std::fopen(part_path_.c_str(), "wb");
  if (file_ == nullptr) Fail("created");
}

AtomicFile::~AtomicFile() {
  if (file_ == nullptr) return;
  std::fclose(file_);
  RemovePart();
}

void AtomicFile::RemovePart() {
  if (part_path_ != path_) std::remove(part_path_.c_str());
}

void AtomicFile::Fail(const char* what, const std::string& besides) {
  const int reason = errno;
  if (file_ != nullptr) std::fclose(file_);
  file_ = nullptr;
  RemovePart();
  throw std::runtime_error(path_ + ": cannot be " + what + ": " + std::strerror(reason) + besides);
}

void AtomicFile::Append(std::string_view bytes) {
  size_ += bytes.size();
  if (std::fwrite(bytes.data(), 1, bytes.size(), file_) != bytes.size())
    Fail("written", " (it has " + std::to_string(size_) + " bytes)");
}

void AtomicFile::OverwriteBeginning(std::string_view bytes) {
  const bool done = std::fseek(file_, 0, SEEK_SET) == 0 &&
                    std::fwrite(bytes.data(), 1, bytes.size(), file_) == bytes.size() &&
                    std::fseek(file_, 0, SEEK_END) == 0;
  if (!done) Fail("written", " (it has " + std::to_string(size_) + " bytes)");
}

void AtomicFile::Sync() {
  const bool done = std::fflush(file_) == 0 && fsync(fileno(file_)) == 0;
  if (!done && errno != EINVAL && errno != EROFS) Fail("written", " (it has " + std::to_string(size_) + " bytes)");
}

void AtomicFile::PutInPlace() {
  // A full disk may be reported only when the last buffer is written.
  if (std::fclose(std::exchange(file_, nullptr)) != 0)
    Fail("written", " (it has " + std::to_string(size_) + " bytes)");
  if (part_path_ != path_ && std::rename(part_path_.c_str(), path_.c_str()) != 0) Fail("put in place");
}

void WriteFileAtomically(const std::string& path, std::string_view content) { WriteFileAtomically(path, {content}); }

void WriteFileAtomically(const std::string& path, std::initializer_list<std::string_view> parts) {
  AtomicFile file(path);
  for (const std::string_view part : parts) file.Append(part);
  file.PutInPlace();
}

void MakeFolder(const std::string& folder) {
  if (folder.empty()) return;
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) throw std::runtime_error(folder + ": the folder cannot be created: " + error.message());
}

}  // namespace plslam
