// SPDX-License-Identifier: BSD-3-Clause
#include "core/io/images/image_folder.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <filesystem>
#include <string_view>

#include "core/files/dataset_error.h"

namespace plslam {
namespace {

namespace fs = std::filesystem;

constexpr std::array<std::string_view, 4> kImageExtensions = {".png", ".jpg", ".jpeg", ".pgm"};
constexpr std::string_view kDigits = "0123456789";

bool IsImage(const fs::path& path) {
  if (path.filename().string().starts_with('.')) return false;
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return std::find(kImageExtensions.begin(), kImageExtensions.end(), extension) != kImageExtensions.end();
}

// The characters of `set` that end at `last`.
std::string RunBefore(const std::string& text, size_t last, std::string_view set) {
  const size_t before = text.find_last_not_of(set, last);
  const size_t first = before == std::string::npos ? 0 : before + 1;
  return text.substr(first, last + 1 - first);
}

std::string WithoutZeros(std::string number) {
  number.erase(0, std::min(number.find_first_not_of('0'), number.size() - 1));
  return number;
}

}  // namespace

ImageKey KeyOfImage(const std::string& file_name) {
  const std::string stem = fs::path(file_name).stem().string();
  const size_t last = stem.find_last_of(kDigits);
  if (last == std::string::npos) return {false, "", "", stem};
  std::string number = RunBefore(stem, last, "0123456789.");
  number.erase(0, number.find_first_of(kDigits));
  const size_t point = number.find('.');
  if (point != number.rfind('.')) return {true, WithoutZeros(RunBefore(stem, last, kDigits)), "", ""};
  if (point == std::string::npos) return {true, WithoutZeros(number), "", ""};
  return {true, WithoutZeros(number.substr(0, point)), number.substr(point + 1), ""};
}

std::map<ImageKey, std::string> ListImages(const std::string& folder) {
  std::map<ImageKey, std::string> images;
  std::error_code error;
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
    if (!IsImage(it->path())) continue;
    const auto [other, is_new] = images.emplace(KeyOfImage(it->path().filename().string()), it->path().string());
    if (!is_new) throw DatasetError(it->path().string() + ": has the same number as " + other->second);
  }
  if (error) throw DatasetError(folder + ": the folder cannot be read (" + error.message() + ")");
  if (images.empty()) throw DatasetError(folder + ": the folder has no images (png, jpg, jpeg, pgm)");
  return images;
}

}  // namespace plslam
