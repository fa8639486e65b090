// SPDX-License-Identifier: BSD-3-Clause
#include "tools/evaluate/places/similarity_figure.h"

#include <fmt/format.h>

#include <algorithm>
#include <opencv2/imgproc.hpp>

#include "tools/evaluate/drawing/axes.h"

namespace plslam::evaluate {
namespace {

constexpr double kMatrixGap_pt = 6.0;
constexpr double kMatrix_pt = (kColumn_pt - 4.0 - 2.0 * kMatrixGap_pt) / 3.0;
constexpr double kMatrixTop_pt = 30.0;

/// One matrix of the figure.
struct Panel {
  const char* name;
  double left_pt;
};

/// A pixel for each pair, 8 bits, `scale` and above white.
cv::Mat GreySimilarities(const SimilarityMatrix& matrix, float scale) {
  cv::Mat grey(matrix.size, matrix.size, CV_8UC1);
  for (int row = 0; row < matrix.size; ++row) {
    for (int column = 0; column < matrix.size; ++column) {
      grey.at<uchar>(row, column) = cv::saturate_cast<uchar>(255.0F * matrix.At(row, column) / scale);
    }
  }
  return grey;
}

cv::Mat Coloured(const SimilarityMatrix& matrix, float scale) {
  cv::Mat coloured;
  cv::applyColorMap(GreySimilarities(matrix, scale), coloured, cv::COLORMAP_VIRIDIS);
  return coloured;
}

void DrawMatrix(const SimilarityMatrix& matrix, const Panel& panel, const std::string& images, int step,
                Drawing& drawing) {
  const float scale = FullScale(matrix);
  const double left = panel.left_pt;
  AddText(drawing, {left, kMatrixTop_pt - 4.0}, fmt::format("{}: 0 to {:.2g}", panel.name, scale));
  const Place corner(left, kMatrixTop_pt), size(kMatrix_pt, kMatrix_pt);
  if (matrix.size > 0) drawing.shapes.emplace_back(DrawnImage{corner, size, Coloured(matrix, scale)});
  const Range range{0.0, std::max(1.0, static_cast<double>(matrix.size * step))};
  Axes axes(drawing, {corner, size}, range, range);
  axes.DrawFrame();
  AddText(drawing, {left, kMatrixTop_pt + kMatrix_pt + 9.0}, "0");
  AddText(drawing, {left + kMatrix_pt, kMatrixTop_pt + kMatrix_pt + 9.0}, fmt::format("{:g}", range.max), 1.0);
  AddText(drawing, {left + 0.5 * kMatrix_pt, kMatrixTop_pt + kMatrix_pt + 9.0}, images, 0.5);
}

}  // namespace

Similarities KeyframeSimilarities(const StoredMap& stored, const PlaceRecogniser& recogniser, int most) {
  Similarities result;
  const int n = static_cast<int>(stored.features.size());
  result.step = std::max(1, (n + most - 1) / most);
  std::vector<PlaceDescription> places;
  int i = 0;
  for (const auto& [id, features] : stored.features) {
    if (i++ % result.step == 0) places.push_back(recogniser.Describe(features));
  }
  const int size = static_cast<int>(places.size());
  for (SimilarityMatrix* matrix : {&result.points, &result.lines, &result.merged}) matrix->size = size;
  for (const PlaceDescription& row : places) {
    for (const PlaceDescription& column : places) {
      const PlaceMatch match = recogniser.Compare(row, column);
      result.points.values.push_back(static_cast<float>(match.score_points));
      result.lines.values.push_back(static_cast<float>(match.score_lines));
      result.merged.values.push_back(static_cast<float>(match.score));
    }
  }
  return result;
}

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

Drawing SimilarityFigure(const std::string& title, const Similarities& similarities, const std::string& images) {
  constexpr double kStep_pt = kMatrix_pt + kMatrixGap_pt;
  const int step = similarities.step;
  Drawing drawing;
  drawing.size = {kColumn_pt, kMatrixTop_pt + kMatrix_pt + 14.0};
  AddTitle(drawing, title);
  DrawMatrix(similarities.points, {"points", 2.0}, images, step, drawing);
  DrawMatrix(similarities.lines, {"lines", 2.0 + kStep_pt}, images, step, drawing);
  DrawMatrix(similarities.merged, {"both", 2.0 + 2.0 * kStep_pt}, images, step, drawing);
  return drawing;
}

}  // namespace plslam::evaluate
