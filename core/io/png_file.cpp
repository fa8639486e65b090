#include "core/io/png_file.h"

#include <opencv2/imgcodecs.hpp>
#include <string_view>

#include "core/io/atomic_file.h"

namespace plslam {

void WritePng(const std::string& path, const cv::Mat& image, const std::vector<int>& parameters) {
  std::vector<uchar> png;
  cv::imencode(".png", image, png, parameters);
  WriteFileAtomically(path, std::string_view(reinterpret_cast<const char*>(png.data()), png.size()));
}

}  // namespace plslam
