#include "core/io/atomic_file.h"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <stdexcept>
#include <system_error>

namespace plslam {
namespace {

[[noreturn]] void Fail(const std::string& path, const char* what) {
  const int reason = errno;
  std::remove((path + ".part").c_str());
  throw std::runtime_error(path + ": cannot be " + what + ": " + std::strerror(reason));
}

}  // namespace

void WriteFileAtomically(const std::string& path, std::string_view content) {
  const std::string part = path + ".part";
  std::FILE* file = std::fopen(part.c_str(), "wb");
  if (file == nullptr) Fail(path, "created");
  const bool written = std::fwrite(content.data(), 1, content.size(), file) == content.size();
  // A full disk may show only when the last buffer goes out.
  const bool closed = std::fclose(file) == 0;
  if (!written || !closed) Fail(path, "written");
  if (std::rename(part.c_str(), path.c_str()) != 0) Fail(path, "put in place");
}

void MakeFolder(const std::string& folder) {
  if (folder.empty()) return;
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) throw std::runtime_error(folder + ": cannot be made a folder: " + error.message());
}

}  // namespace plslam
