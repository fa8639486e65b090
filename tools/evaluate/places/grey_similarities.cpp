// SPDX-License-Identifier: BSD-3-Clause
#include "tools/evaluate/places/grey_similarities.h"

#include <algorithm>
#include <vector>

namespace plslam {

float FullScale(const SimilarityMatrix& matrix) {
  std::vector<float> values;
  for (int row = 0; row < matrix.size; ++row) {
    for (int column = 0; column < row; ++column) values.push_back(matrix.At(row, column));
  }
  if (values.empty()) return 1.0F;
  const auto place = values.begin() + static_cast<std::ptrdiff_t>(values.size() * 199 / 200);
  std::nth_element(values.begin(), place, values.end());
  return std::max(*place, 1e-6F);
}

cv::Mat GreySimilarities(const SimilarityMatrix& matrix, float scale) {
  cv::Mat grey(matrix.size, matrix.size, CV_8UC1);
  for (int row = 0; row < matrix.size; ++row) {
    for (int column = 0; column < matrix.size; ++column) {
      grey.at<uchar>(row, column) = cv::saturate_cast<uchar>(255.0F * matrix.At(row, column) / scale);
    }
  }
  return grey;
}

}  // namespace plslam
