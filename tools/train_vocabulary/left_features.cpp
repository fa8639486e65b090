#include "tools/train_vocabulary/left_features.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "core/features/feature_extractor.h"
#include "core/geometry/rectifier.h"
#include "core/io/image_file.h"
#include "core/io/image_folder.h"
#include "player/open_dataset.h"

namespace plslam {
namespace {

// Descriptors and gradients reach this far around a feature; as in vo_process.
constexpr int kMaskMargin_px = 8;

cv::Mat Shrink(const cv::Mat& mask) {
  if (mask.empty()) return mask;
  cv::Mat shrunk;
  const int size = 2 * kMaskMargin_px + 1;
  cv::erode(mask, shrunk, cv::Mat::ones(size, size, CV_8U), cv::Point(-1, -1), 1, cv::BORDER_CONSTANT,
            cv::Scalar(255));
  return shrunk;
}

bool IsMasked(const cv::Mat& mask, const Eigen::Vector2d& px) {
  const cv::Point at(static_cast<int>(std::lround(px.x())), static_cast<int>(std::lround(px.y())));
  return !at.inside(cv::Rect(0, 0, mask.cols, mask.rows)) || mask.at<uchar>(at) == 0;
}

void RemoveMasked(const cv::Mat& mask, ImageFeatures& features) {
  if (mask.empty()) return;
  std::erase_if(features.points, [&](const PointFeature& point) { return IsMasked(mask, point.px); });
  std::erase_if(features.lines, [&](const LineFeature& line) {
    const Eigen::Vector2d middle = 0.5 * (line.segment.p + line.segment.q);
    return IsMasked(mask, line.segment.p) || IsMasked(mask, line.segment.q) || IsMasked(mask, middle);
  });
}

/// Full names of the images in the folder itself; none where it is no such folder.
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
  const cv::Mat mask = Shrink(rectifier.left_mask());
  FeatureExtractor extractor(options);
  for (int i = 0; i < dataset.size(); i += stride) {
    ImageFeatures features = extractor.Extract(rectifier.RectifyLeft(dataset.Read(i).left));
    RemoveMasked(mask, features);
    use(i, features);
    progress(i + 1, dataset.size());
  }
}

void ForEachImageOf(const std::string& source, int stride, const FeatureOptions& options,
                    const std::function<void(const ImageFeatures&)>& use, const ImageProgress& progress) {
  const std::vector<std::string> images = ImagesIn(source);
  if (images.empty()) {
    const auto dataset = OpenDataset(source, "");
    return ForEachLeftImage(
        *dataset, stride, options, [&](int, const ImageFeatures& f) { use(f); }, progress);
  }
  FeatureExtractor extractor(options);
  for (size_t i = 0; i < images.size(); i += static_cast<size_t>(stride)) {
    use(extractor.Extract(ReadGreyImage(images[i], ReadImageSize(images[i]))));
    progress(static_cast<int>(i) + 1, static_cast<int>(images.size()));
  }
}

}  // namespace plslam
