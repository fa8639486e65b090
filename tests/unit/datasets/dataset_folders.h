// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace plslam::test {

/// A new folder under the temporary folder, removed with its content at the end.
class TemporaryFolder {
 public:
  TemporaryFolder();
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

inline constexpr int kTinyWidth_px = 48;
inline constexpr int kTinyHeight_px = 32;

/// Tiny valid datasets of three frames each, 100 ms apart, with ground truth. Pixels are those of `TinyPixel`.
void MakeKittiFolder(const std::filesystem::path& folder);
void MakeEurocFolder(const std::filesystem::path& folder, std::string_view image_extension = ".png");
/// `folder` should have "fr1" in its name, or get a camera.yaml. Without one the size is that of TUM's cameras.
void MakeTumFolder(const std::filesystem::path& folder, int width_px = 640, int height_px = 480);
void MakeVslamLabFolder(const std::filesystem::path& folder);
void MakeImagesFolder(const std::filesystem::path& folder);

/// Grey value of a tiny image: `camera` 0 or 1.
int TinyPixel(int frame, int camera, int x, int y);

void WriteText(const std::filesystem::path& path, std::string_view text);
std::string ReadText(const std::filesystem::path& path);
/// Replaces the first `from`, which must be there.
void ReplaceText(const std::filesystem::path& path, std::string_view from, std::string_view to);

}  // namespace plslam::test
