// SPDX-License-Identifier: BSD-3-Clause
#include "tools/evaluate/places/place_pictures.h"

#include <fmt/format.h>

#include <opencv2/imgproc.hpp>

#include "tools/evaluate/chart.h"
#include "tools/evaluate/places/grey_similarities.h"

namespace plslam {
namespace {

constexpr int kMatrix_px = 480;
constexpr int kTitle_px = 40;
constexpr int kGap_px = 16;
// Charts are drawn at twice the size and halved.
const cv::Size kCharts(2800, 1300);
const cv::Rect kBestMatchArea(190, 190, 1080, 920);
const cv::Rect kAllPairsArea(1610, 190, 1080, 920);

const std::vector<cv::Scalar> kColours{{40, 40, 40},  {200, 110, 20}, {60, 160, 60},  {30, 150, 220},
                                       {50, 60, 200}, {170, 60, 150}, {150, 150, 150}};

cv::Mat DrawMatrix(const SimilarityMatrix& matrix, const std::string& name) {
  cv::Mat picture(kMatrix_px + kTitle_px, kMatrix_px, CV_8UC3, cv::Scalar::all(255));
  const float scale = FullScale(matrix);
  if (matrix.size > 0) {
    cv::Mat grey = GreySimilarities(matrix, scale);
    const bool shrink = matrix.size > kMatrix_px;
    cv::resize(grey, grey, {kMatrix_px, kMatrix_px}, 0, 0, shrink ? cv::INTER_AREA : cv::INTER_NEAREST);
    cv::applyColorMap(grey, picture.rowRange(kTitle_px, picture.rows), cv::COLORMAP_JET);
  }
  cv::putText(picture, fmt::format("{}: red = {:.3f}", name, scale), {2, kTitle_px - 14}, cv::FONT_HERSHEY_SIMPLEX,
              0.6, cv::Scalar::all(40), 1, cv::LINE_AA);
  return picture;
}

std::vector<cv::Point2d> CurveOf(const PrecisionRecall& result) {
  std::vector<cv::Point2d> points;
  if (!result.curve.empty()) points.emplace_back(0.0, result.curve.front().precision);
  for (const PrecisionRecallPoint& p : result.curve) points.emplace_back(p.recall, p.precision);
  return points;
}

void DrawCurves(const PlaceEvaluation& evaluation, PrecisionRecall MergeEvaluation::*which, const cv::Rect& area,
                const std::string& name, cv::Mat& picture) {
  Chart chart(picture, area, {0.0, 1.0}, {0.0, 1.02});
  chart.DrawGrid("recall, " + name, "precision");
  // The default comes first, and is drawn on top.
  for (size_t i = evaluation.merges.size(); i-- > 0;) {
    chart.DrawLine(CurveOf(evaluation.merges[i].*which), kColours[i % kColours.size()], i == 0 ? 3.0 : 2.0);
  }
}

}  // namespace

cv::Mat DrawSimilarities(const PlaceEvaluation& evaluation) {
  const cv::Mat gap(kMatrix_px + kTitle_px, kGap_px, CV_8UC3, cv::Scalar::all(255));
  cv::Mat picture;
  cv::hconcat(std::vector<cv::Mat>{DrawMatrix(evaluation.points, "points"), gap,
                                   DrawMatrix(evaluation.lines, "lines"), gap, DrawMatrix(evaluation.merged, "both")},
              picture);
  return picture;
}

cv::Mat DrawPrecisionRecall(const PlaceEvaluation& evaluation) {
  cv::Mat picture(kCharts, CV_8UC3, cv::Scalar::all(255));
  DrawCurves(evaluation, &MergeEvaluation::best_match, kBestMatchArea, "best match of each frame", picture);
  DrawCurves(evaluation, &MergeEvaluation::all_pairs, kAllPairsArea, "all pairs", picture);
  std::vector<std::pair<std::string, cv::Scalar>> legend;
  for (size_t i = 0; i < evaluation.merges.size(); ++i) {
    legend.emplace_back(evaluation.merges[i].merge, kColours[i % kColours.size()]);
  }
  const cv::Rect whole(kBestMatchArea.tl() - cv::Point(0, 60), kAllPairsArea.br());
  Chart(picture, whole, {0.0, 1.0}, {0.0, 1.0}).DrawLegend(legend);
  cv::resize(picture, picture, {}, 0.5, 0.5, cv::INTER_AREA);
  return picture;
}

}  // namespace plslam
