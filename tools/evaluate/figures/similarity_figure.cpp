// SPDX-License-Identifier: BSD-3-Clause
#include "tools/evaluate/figures/similarity_figure.h"

#include <fmt/format.h>

#include <algorithm>
#include <opencv2/imgproc.hpp>

#include "core/places/place_recogniser.h"
#include "tools/evaluate/figures/axes.h"
#include "tools/evaluate/figures/keyframe_similarities.h"
#include "tools/evaluate/places/grey_similarities.h"

namespace plslam {
namespace {

constexpr double kMatrixGap_pt = 6.0;
constexpr double kMatrix_pt = (kColumn_pt - 4.0 - 2.0 * kMatrixGap_pt) / 3.0;
constexpr double kMatrixTop_pt = 30.0;
constexpr int kMostKeyframes = 400;

cv::Mat Coloured(const SimilarityMatrix& matrix, float scale) {
  cv::Mat coloured;
  cv::applyColorMap(GreySimilarities(matrix, scale), coloured, cv::COLORMAP_VIRIDIS);
  return coloured;
}

void DrawMatrix(const SimilarityMatrix& matrix, const std::string& name, double left, int step, Drawing& drawing) {
  const float scale = FullScale(matrix);
  AddText(drawing, {left, kMatrixTop_pt - 4.0}, fmt::format("{}: 0 to {:.2g}", name, scale));
  const Place corner(left, kMatrixTop_pt), size(kMatrix_pt, kMatrix_pt);
  if (matrix.size > 0) drawing.shapes.emplace_back(DrawnImage{corner, size, Coloured(matrix, scale)});
  const Range range{0.0, std::max(1.0, static_cast<double>(matrix.size * step))};
  Axes axes(drawing, {corner, size}, range, range);
  axes.DrawFrame();
  AddText(drawing, {left, kMatrixTop_pt + kMatrix_pt + 9.0}, "0");
  AddText(drawing, {left + kMatrix_pt, kMatrixTop_pt + kMatrix_pt + 9.0}, fmt::format("{:g}", range.max), 1.0);
  AddText(drawing, {left + 0.5 * kMatrix_pt, kMatrixTop_pt + kMatrix_pt + 9.0}, "keyframes", 0.5);
}

}  // namespace

Drawing SimilarityFigure(const std::string& title, const StoredMap& stored, const std::string& point_vocabulary,
                         const std::string& line_vocabulary) {
  const PlaceRecogniser recogniser(Vocabulary::Load(point_vocabulary), Vocabulary::Load(line_vocabulary),
                                   PlaceOptions{});
  const KeyframeSimilarities similarities = SimilaritiesOf(stored, recogniser, kMostKeyframes);
  Drawing drawing;
  drawing.size = {kColumn_pt, kMatrixTop_pt + kMatrix_pt + 14.0};
  AddTitle(drawing, title);
  DrawMatrix(similarities.points, "points", 2.0, similarities.step, drawing);
  DrawMatrix(similarities.lines, "lines", 2.0 + kMatrix_pt + kMatrixGap_pt, similarities.step, drawing);
  DrawMatrix(similarities.merged, "both", 2.0 + 2.0 * (kMatrix_pt + kMatrixGap_pt), similarities.step, drawing);
  return drawing;
}

}  // namespace plslam
