// SPDX-License-Identifier: BSD-3-Clause
#include "core/features/lines/coarse_lines.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/features/image/image_pyramid.h"
#include "core/features/lines/line_select.h"
#include "core/features/lines/line_sigma.h"

namespace plslam {
namespace {

/// Widest edge that is located in its own image.
constexpr int kMaxSharp_px = 5;
/// Number of sharp lines that suffice: this, or this share of the maximum.
constexpr double kEnoughSharp = 50.0;
constexpr double kEnoughShare = 0.25;
/// A coarse line is known already if lines of finer images run along this share of it, within this distance in pixels
/// of its own image.
constexpr double kKnownShare = 0.3;
constexpr double kKnownWithin_px = 2.5;
constexpr double kMinCosine = 0.98;
constexpr int kMinSize_px = 16;

double Scale(int octave) { return 1 << octave; }

/// Length of the part of `coarse` that `fine` runs along.
double SharedLength(const DetectedSegment& coarse, const Segment2& fine) {
  const double length = coarse.segment.Length();
  const Eigen::Vector2d along = (coarse.segment.q - coarse.segment.p) / length;
  const Eigen::Vector2d p = fine.p - coarse.segment.p;
  const Eigen::Vector2d q = fine.q - coarse.segment.p;
  const double from = along.dot(p);
  const double to = along.dot(q);
  if (to - from < kMinCosine * fine.Length()) return 0.0;
  const double first = std::max(from, 0.0);
  const double last = std::min(to, length);
  if (last <= first) return 0.0;
  const double middle = (0.5 * (first + last) - from) / (to - from);
  const double across = Eigen::Vector2d(-along.y(), along.x()).dot(p + middle * (q - p));
  return std::abs(across) <= kKnownWithin_px * Scale(coarse.octave) ? last - first : 0.0;
}

bool IsKnown(const DetectedSegment& coarse, const std::vector<DetectedSegment>& segments, size_t finer) {
  double shared = 0.0;
  for (size_t i = 0; i < finer; ++i) shared += SharedLength(coarse, segments[i].segment);
  return shared > kKnownShare * coarse.segment.Length();
}

}  // namespace

void CoarseLines::Complete(const cv::Mat& image, const Gradients& gradients, std::vector<DetectedSegment>& segments) {
  if (options_.levels <= 1) return;
  const double enough = std::min(kEnoughSharp, kEnoughShare * options_.max_lines);
  std::vector<DetectedSegment> sharp;
  for (const DetectedSegment& s : segments) {
    if (EdgeWidth_px(gradients, s.segment) <= kMaxSharp_px) sharp.push_back(s);
    if (static_cast<double>(sharp.size()) >= enough) return;
  }
  segments = std::move(sharp);
  cv::Mat level = image;
  for (int octave = 1; octave < options_.levels; ++octave) {
    level = Halved(level);
    if (std::min(level.cols, level.rows) < kMinSize_px) break;
    AddLevel(level, octave, segments);
  }
  segments = LongestFirst(segments);
}

void CoarseLines::AddLevel(const cv::Mat& level, int octave, std::vector<DetectedSegment>& segments) {
  ComputeGradients(level, gradients_);
  const bool is_last = octave + 1 == options_.levels;
  const size_t finer = segments.size();
  for (DetectedSegment s : MergeCollinear(detector_.Detect(level, gradients_))) {
    if (!is_last && EdgeWidth_px(gradients_, s.segment) > kMaxSharp_px) continue;
    // Pixel i of a halved image is centred on pixel 2 i.
    s.segment.p *= Scale(octave);
    s.segment.q *= Scale(octave);
    s.octave = octave;
    if (s.segment.Length() >= options_.min_length_px && !IsKnown(s, segments, finer)) segments.push_back(s);
  }
}

}  // namespace plslam
