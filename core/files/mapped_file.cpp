// SPDX-License-Identifier: BSD-3-Clause
#include "core/files/mapped_file.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <stdexcept>

#include "core/errors/error_text.h"
#include "core/files/nameless_file.h"

namespace plslam {
namespace {

bool Write(int file, std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const ssize_t n = ::write(file, bytes.data(), bytes.size());
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return false;
    bytes = bytes.subspan(static_cast<size_t>(n));
  }
  return true;
}

bool Write(int file, const std::vector<std::span<const std::byte>>& parts) {
  for (const auto& part : parts) {
    if (!Write(file, part)) return false;
  }
  return true;
}

}  // namespace

std::string TemporaryRoot() {
  const char* root = std::getenv("TMPDIR");
  if (root != nullptr && *root != '\0') return root;
  return ::access("/var/tmp", W_OK) == 0 ? "/var/tmp" : "/tmp";
}

std::shared_ptr<const MappedFile> MappedFile::Map(int file, size_t size) {
  // An empty file cannot be mapped.
  void* data = size > 0 ? ::mmap(nullptr, size, PROT_READ, MAP_SHARED, file, 0) : nullptr;
  if (data == MAP_FAILED) return nullptr;
  return std::shared_ptr<const MappedFile>(new MappedFile(static_cast<const std::byte*>(data), size));
}

std::shared_ptr<const MappedFile> MappedFile::Open(const std::string& path) {
  const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  struct stat status {};
  const bool is_file = file >= 0 && ::fstat(file, &status) == 0 && S_ISREG(status.st_mode);
  auto mapped = is_file ? Map(file, static_cast<size_t>(status.st_size)) : nullptr;
  const int reason = errno;
  if (file >= 0) ::close(file);
  if (file >= 0 && !is_file) throw std::runtime_error("is not a regular file");
  if (mapped == nullptr) throw std::runtime_error("cannot be read: " + ReasonOf(reason));
  return mapped;
}

std::shared_ptr<const MappedFile> MappedFile::Temporary(const std::vector<std::span<const std::byte>>& parts) {
  size_t size = 0;
  for (const auto& part : parts) size += part.size();
  const int file = OpenNameless(TemporaryRoot());
  if (file < 0) return nullptr;
  auto mapped = Write(file, parts) ? Map(file, size) : nullptr;
  // A full disk of another machine may show only now.
  return ::close(file) == 0 ? mapped : nullptr;
}

MappedFile::~MappedFile() {
  if (size_ > 0) ::munmap(const_cast<std::byte*>(data_), size_);
}

void MappedFile::LeaveMemory(size_t begin, size_t size) const {
  // Pages may be larger than `kPage`; partial pages at the borders are kept.
  const auto page = static_cast<size_t>(::sysconf(_SC_PAGESIZE));
  const size_t first = (begin + page - 1) / page * page;
  if (first < begin + size) ::madvise(const_cast<std::byte*>(data_) + first, begin + size - first, MADV_DONTNEED);
}

}  // namespace plslam
