// SPDX-License-Identifier: BSD-3-Clause
#include "core/files/nameless_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <stdexcept>
#include <utility>

namespace plslam {

int OpenNameless(const std::string& folder) {
  const int descriptor = open(folder.c_str(), O_TMPFILE | O_RDWR | O_CLOEXEC, 0600);
  if (descriptor >= 0) return descriptor;
  std::string pattern = folder + "/plslam-XXXXXX";
  const int named = mkostemp(pattern.data(), O_CLOEXEC);
  if (named >= 0) unlink(pattern.c_str());
  return named;
}

NamelessFile::~NamelessFile() {
  if (descriptor_ >= 0) close(descriptor_);
}

NamelessFile::NamelessFile(NamelessFile&& other) noexcept
    : folder_(std::move(other.folder_)),
      descriptor_(std::exchange(other.descriptor_, -1)),
      failure_(std::move(other.failure_)) {}

NamelessFile& NamelessFile::operator=(NamelessFile&& other) noexcept {
  std::swap(folder_, other.folder_);
  std::swap(descriptor_, other.descriptor_);
  std::swap(failure_, other.failure_);
  return *this;
}

bool NamelessFile::Fail(int reason) {
  failure_ = folder_ + ": a temporary file cannot be written: " + std::strerror(reason);
  return false;
}

bool NamelessFile::Write(int64_t at, const void* bytes, size_t n) {
  if (descriptor_ < 0) descriptor_ = OpenNameless(folder_);
  if (descriptor_ < 0) return Fail(errno);
  const char* from = static_cast<const char*>(bytes);
  while (n > 0) {
    const ssize_t written = pwrite(descriptor_, from, n, at);
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return Fail(written < 0 ? errno : ENOSPC);
    from += written;
    at += written;
    n -= static_cast<size_t>(written);
  }
  return true;
}

void NamelessFile::Read(int64_t at, void* bytes, size_t n) const {
  char* to = static_cast<char*>(bytes);
  while (n > 0) {
    const ssize_t read = pread(descriptor_, to, n, at);
    if (read < 0 && errno == EINTR) continue;
    if (read <= 0) {
      throw std::runtime_error(folder_ +
                               ": a temporary file cannot be read: " + std::strerror(read < 0 ? errno : EIO));
    }
    to += read;
    at += read;
    n -= static_cast<size_t>(read);
  }
}

}  // namespace plslam
