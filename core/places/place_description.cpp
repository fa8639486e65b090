// SPDX-License-Identifier: BSD-3-Clause
#include "core/places/place_description.h"

#include <algorithm>
#include <cmath>

namespace plslam {

float BagSimilarity(const BagOfWords& a, const BagOfWords& b) {
  return BagSimilarity(a, std::vector<float>(a.words.size(), 1.0F), b);
}

float BagSimilarity(const BagOfWords& a, const std::vector<float>& word_weights, const BagOfWords& b) {
  float common = 0.0F;
  auto in_b = b.words.begin();
  for (size_t i = 0; i < a.words.size(); ++i) {
    const auto& [word, weight] = a.words[i];
    while (in_b != b.words.end() && in_b->first < word) ++in_b;
    if (in_b == b.words.end()) break;
    if (in_b->first == word) common += word_weights[i] * std::min(weight, in_b->second);
  }
  return common;
}

namespace {

using Pixels = std::vector<Eigen::Vector2d>;

double Dispersion(Pixels px) {
  std::erase_if(px, [](const Eigen::Vector2d& p) { return !p.allFinite(); });
  if (px.size() < 2) return 0.0;
  const double n = static_cast<double>(px.size());
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (const Eigen::Vector2d& p : px) mean += p / n;
  double variance = 0.0;
  for (const Eigen::Vector2d& p : px) variance += (p - mean).squaredNorm() / n;
  return std::sqrt(variance);
}

PlaceDescription Describe(const Pixels& points, const Pixels& lines) {
  PlaceDescription description;
  description.n_points = static_cast<int>(points.size());
  description.n_lines = static_cast<int>(lines.size());
  description.dispersion_points_px = Dispersion(points);
  description.dispersion_lines_px = Dispersion(lines);
  return description;
}

Eigen::Vector2d Middle(const Segment2& segment) { return 0.5 * (segment.p + segment.q); }

}  // namespace

PlaceDescription DescribeLayout(const ImageFeatures& features) {
  Pixels points;
  Pixels lines;
  for (const PointFeature& point : features.points) points.push_back(point.px);
  for (const LineFeature& line : features.lines) lines.push_back(Middle(line.segment));
  return Describe(points, lines);
}

PlaceDescription DescribeLayout(const FeaturesView& features) {
  Pixels points;
  Pixels lines;
  for (const StereoPoint& point : features.points) points.push_back(point.left.px);
  for (const StereoLine& line : features.lines) lines.push_back(Middle(line.left.segment));
  return Describe(points, lines);
}

}  // namespace plslam
