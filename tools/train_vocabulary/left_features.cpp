// SPDX-License-Identifier: BSD-3-Clause
#include "tools/train_vocabulary/left_features.h"

#include <algorithm>
#include <filesystem>
#include <vector>

#include "core/datasets/open_dataset.h"
#include "core/features/feature_extractor.h"
#include "core/geometry/rectifier.h"
#include "core/io/images/image_file.h"
#include "core/io/images/image_folder.h"

namespace plslam::train_vocabulary {
namespace {

/// Returns the full names of the images in the folder itself; empty if there is no such folder.
std::vector<std::string> ImagesIn(const std::string& folder) {
  std::vector<std::string> images;
  if (!std::filesystem::is_directory(folder)) return images;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    static const std::vector<std::string> kEndings{".png", ".jpg", ".jpeg", ".pgm"};
    const std::string ending = entry.path().extension();
    if (std::find(kEndings.begin(), kEndings.end(), ending) != kEndings.end()) images.push_back(entry.path());
  }
  std::sort(images.begin(), images.end());
  return images;
}

}  // namespace

void ForEachLeftImage(const Dataset& dataset, int stride, const FeatureOptions& options,
                      const std::function<void(int, const ImageFeatures&)>& use, const ImageProgress& progress) {
  const Rectifier rectifier(dataset.rig());
  const FeatureMask mask(rectifier.left_mask());
  FeatureExtractor extractor(options);
  for (int i = 0; i < dataset.size(); i += stride) {
    ImageFeatures features = extractor.Extract(rectifier.RectifyLeft(dataset.Read(i).left));
    mask.RemoveOutside(features);
    use(i, features);
    progress(i + 1, dataset.size());
  }
}

void ForEachImageOf(const std::string& source, int stride, const FeatureOptions& options,
                    const std::function<void(const ImageFeatures&)>& use, const ImageProgress& progress) {
  const std::vector<std::string> images = ImagesIn(source);
  if (images.empty()) {
    const auto dataset = OpenDatasetAndWarn(source, "");
    return ForEachLeftImage(
        *dataset, stride, options, [&](int, const ImageFeatures& f) { use(f); }, progress);
  }
  FeatureExtractor extractor(options);
  for (size_t i = 0; i < images.size(); i += static_cast<size_t>(stride)) {
    use(extractor.Extract(ReadGreyImage(images[i])));
    progress(static_cast<int>(i) + 1, static_cast<int>(images.size()));
  }
}

}  // namespace plslam::train_vocabulary
