// SPDX-License-Identifier: BSD-3-Clause
#include "vo_process/stereo/line_stereo.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

#include "core/features/lines/line_sigma.h"

namespace plslam::vo {
namespace {

constexpr int kPlaces = 16;
constexpr int kReach = 6;
/// Pixels beyond the edge that belong to either strip: the edge itself.
constexpr int kOverEdge = 1;
constexpr int kColumns = 2 * kReach + 1;

using Strip = std::array<std::array<double, kColumns>, kPlaces>;

/// Samples grey values around (u, v) along the row nearest to v; returns false outside the image.
bool SampleRow(const cv::Mat& image, double u, double v, std::array<double, kColumns>& out) {
  const int y = static_cast<int>(std::lround(v));
  const double floor_u = std::floor(u);
  const int x = static_cast<int>(floor_u);
  if (y < 0 || y >= image.rows || x - kReach < 0 || x + kReach + 1 >= image.cols) return false;
  const uint8_t* row = image.ptr<uint8_t>(y) + x - kReach;
  const double w = u - floor_u;
  for (size_t i = 0; i < kColumns; ++i) out[i] = (1.0 - w) * row[i] + w * row[i + 1];
  return true;
}

/// Zero-mean normalised correlation of columns [first, last] of rows [0, count).
double Correlation(const Strip& a, const Strip& b, size_t count, size_t first, size_t last) {
  double n = 0, sa = 0, sb = 0, aa = 0, bb = 0, ab = 0;
  for (size_t r = 0; r < count; ++r) {
    for (size_t c = first; c <= last; ++c) {
      n += 1.0;
      sa += a[r][c];
      sb += b[r][c];
      aa += a[r][c] * a[r][c];
      bb += b[r][c] * b[r][c];
      ab += a[r][c] * b[r][c];
    }
  }
  const double va = n * aa - sa * sa;
  const double vb = n * bb - sb * sb;
  return va > 0.0 && vb > 0.0 ? (n * ab - sa * sb) / std::sqrt(va * vb) : 0.0;
}

}  // namespace

double StripSimilarity(const cv::Mat& left_image, const cv::Mat& right_image, const Segment2& left,
                       double disparity_p_px, double disparity_q_px, const RowField& rows, const PairDirt& dirt) {
  Strip a;
  Strip b;
  size_t count = 0;
  for (int i = 0; i < kPlaces; ++i) {
    const double t = (i + 0.5) / kPlaces;
    const Eigen::Vector2d at = left.p + t * (left.q - left.p);
    const double right_u = at.x() - disparity_p_px - t * (disparity_q_px - disparity_p_px);
    const double right_v = at.y() + rows.MatchOffset_px(at, at.x() - right_u);
    if (dirt.left.IsOn(at) || dirt.right.IsOn({right_u, right_v})) continue;
    if (SampleRow(left_image, at.x(), at.y(), a[count]) && SampleRow(right_image, right_u, right_v, b[count])) {
      ++count;
    }
  }
  if (count < kPlaces / 4) return 0.0;
  return std::max(Correlation(a, b, count, 0, kReach + kOverEdge),
                  Correlation(a, b, count, kReach - kOverEdge, kColumns - 1));
}

namespace {

/// A segment parameterised by the row, because stereo compares rows.
struct RowLine {
  double top = 0.0;
  double bottom = 0.0;
  /// Column in row `top`, and columns per row.
  double u_top = 0.0;
  double slope = 0.0;
  Eigen::Vector2d direction = Eigen::Vector2d::Zero();
  double length = 0.0;

  double Column(double row) const { return u_top + slope * (row - top); }
  double Sine() const { return std::abs(direction.y()); }
};

RowLine MakeRowLine(const Segment2& s) {
  const bool down = s.q.y() >= s.p.y();
  const Eigen::Vector2d& high = down ? s.p : s.q;
  const Eigen::Vector2d& low = down ? s.q : s.p;
  RowLine line;
  line.top = high.y();
  line.bottom = low.y();
  line.u_top = high.x();
  line.length = s.Length();
  const double rows = line.bottom - line.top;
  line.slope = rows > 0.0 ? (low.x() - high.x()) / rows : 0.0;
  if (line.length > 0.0) line.direction = (s.q - s.p) / line.length;
  return line;
}

struct Pairing {
  size_t left;
  size_t right;
  int distance;
  /// Disparity in the middle of the shared rows.
  double disparity;
};

/// Geometric tests of a match.
class StereoGates {
 public:
  explicit StereoGates(const StereoOptions& o)
      : options_(o),
        min_sine_(std::sin(o.line_min_angle_deg * M_PI / 180.0)),
        min_cosine_(std::cos(o.line_max_angle_difference_deg * M_PI / 180.0)) {}

  bool HasAngle(const RowLine& l) const { return l.Sine() >= min_sine_ && l.bottom > l.top; }

  /// Returns the disparity in the middle of the shared rows, if the two may be one edge.
  std::optional<double> Disparity(const RowLine& l, const RowLine& r) const {
    const double top = std::max(l.top, r.top);
    const double bottom = std::min(l.bottom, r.bottom);
    const double left_rows = l.bottom - l.top;
    const double right_rows = r.bottom - r.top;
    if (bottom - top < options_.line_min_overlap * std::min(left_rows, right_rows)) return std::nullopt;
    if (bottom - top < kMinSharedRows || l.direction.dot(r.direction) < min_cosine_) return std::nullopt;
    const double ratio = left_rows < right_rows ? left_rows / right_rows : right_rows / left_rows;
    if (ratio < options_.line_min_length_ratio) return std::nullopt;
    if (!InRange(l, r, top, bottom) || !InRange(l, r, l.top, l.bottom)) return std::nullopt;
    const double middle = 0.5 * (top + bottom);
    return l.Column(middle) - r.Column(middle);
  }

 private:
  static constexpr double kMinSharedRows = 3.0;

  bool InRange(const RowLine& l, const RowLine& r, double top, double bottom) const {
    const double a = l.Column(top) - r.Column(top);
    const double b = l.Column(bottom) - r.Column(bottom);
    const double low = std::min(a, b);
    const double high = std::max(a, b);
    if (low < options_.min_disparity_px || high > options_.max_disparity_px) return false;
    // For far lines the noise of the ends is a large part of the disparity.
    return low + kEndNoise_px >= options_.line_min_disparity_ratio * high;
  }

  static constexpr double kEndNoise_px = 1.0;

  const StereoOptions& options_;
  double min_sine_;
  double min_cosine_;
};

std::vector<RowLine> MakeRowLines(const std::vector<StereoLine>& lines) {
  std::vector<RowLine> out;
  out.reserve(lines.size());
  for (const StereoLine& l : lines) out.push_back(MakeRowLine(l.left.segment));
  return out;
}

std::vector<RowLine> MakeRowLines(const std::vector<LineFeature>& lines) {
  std::vector<RowLine> out;
  out.reserve(lines.size());
  for (const LineFeature& l : lines) out.push_back(MakeRowLine(l.segment));
  return out;
}

std::vector<Pairing> AllPairings(const std::vector<StereoLine>& left, const std::vector<RowLine>& left_rows,
                                 const std::vector<LineFeature>& right, const std::vector<RowLine>& right_rows,
                                 const StereoGates& gates) {
  std::vector<Pairing> pairings;
  for (size_t i = 0; i < left.size(); ++i) {
    if (!gates.HasAngle(left_rows[i])) continue;
    for (size_t j = 0; j < right.size(); ++j) {
      if (!gates.HasAngle(right_rows[j])) continue;
      const auto disparity = gates.Disparity(left_rows[i], right_rows[j]);
      if (!disparity) continue;
      pairings.push_back({i, j, HammingDistance(left[i].left.descriptor, right[j].descriptor), *disparity});
    }
  }
  return pairings;
}

/// Best pairing of each line on one side, and the distance of the best rival with another disparity.
struct BestPairing {
  const Pairing* pairing = nullptr;
  int rival_distance = Descriptor{}.size() * 64 + 1;
};

/// Disparities within this are the same: pieces of one edge are no rivals.
constexpr double kSameDisparity_px = 1.5;

std::vector<BestPairing> BestOf(const std::vector<Pairing>& pairings, size_t count, size_t Pairing::*side) {
  std::vector<BestPairing> best(count);
  for (const Pairing& p : pairings) {
    BestPairing& b = best[p.*side];
    if (b.pairing == nullptr || p.distance < b.pairing->distance) b.pairing = &p;
  }
  for (const Pairing& p : pairings) {
    BestPairing& b = best[p.*side];
    const bool differs = std::abs(p.disparity - b.pairing->disparity) > kSameDisparity_px;
    if (differs) b.rival_distance = std::min(b.rival_distance, p.distance);
  }
  return best;
}

/// Standard deviation of the disparity in `row`, for a given left point and the intersection of the right line with the
/// row.
double DisparitySigma(const LineFeature& left, const LineFeature& right, const RowLine& l, const RowLine& r,
                      double row) {
  const Eigen::Vector2d on_left(l.Column(row), row);
  const Eigen::Vector2d on_right(r.Column(row), row);
  const double sl = LineSigma_px(l.length, left.response, PlaceAlong(left.segment, on_left), left.octave) / l.Sine();
  const double sr =
      LineSigma_px(r.length, right.response, PlaceAlong(right.segment, on_right), right.octave) / r.Sine();
  return std::sqrt(sl * sl + sr * sr);
}

/// Compares the two images along a match. Without images it confirms all matches.
class Appearance {
 public:
  Appearance(const cv::Mat& left, const cv::Mat& right, const RowField& rows, const PairDirt& dirt,
             double min_similarity)
      : left_(left), right_(right), rows_(rows), dirt_(dirt), min_similarity_(min_similarity) {}

  bool Confirms(const Segment2& s, const RowLine& r) const {
    return left_.empty() || right_.empty() || SimilarityOf(s, r) >= min_similarity_;
  }

  double SimilarityOf(const Segment2& s, const RowLine& r) const {
    const double disparity_p = s.p.x() - r.Column(s.p.y());
    const double disparity_q = s.q.x() - r.Column(s.q.y());
    return StripSimilarity(left_, right_, s, disparity_p, disparity_q, rows_, dirt_);
  }

 private:
  const cv::Mat& left_;
  const cv::Mat& right_;
  const RowField& rows_;
  const PairDirt& dirt_;
  double min_similarity_;
};

/// Column where the right line crosses the row of a left pixel, which the skew of the pair moves down.
double CrossingColumn(const RowLine& r, const PairSkew& skew, const Eigen::Vector2d& left_px) {
  const double level_px = r.Column(left_px.y());
  return skew.is_zero() ? level_px : r.Column(left_px.y() + skew.RowOffset_px(left_px, left_px.x() - level_px));
}

void SetDepth(StereoLine& line, const LineFeature& right, const RowLine& l, const RowLine& r, const PairSkew& skew,
              const StereoOptions& options) {
  const Segment2& s = line.left.segment;
  const double sigma_p = DisparitySigma(line.left, right, l, r, s.p.y());
  const double sigma_q = DisparitySigma(line.left, right, l, r, s.q.y());
  if (std::max(sigma_p, sigma_q) > options.line_max_sigma_disparity_px) return;
  line.disparity_p_px = s.p.x() - CrossingColumn(r, skew, s.p);
  line.disparity_q_px = s.q.x() - CrossingColumn(r, skew, s.q);
  line.sigma_disparity_p_px = sigma_p;
  line.sigma_disparity_q_px = sigma_q;
}

/// Places along a segment at which dirt is looked for.
constexpr int kDirtPlaces = 16;
/// Ratio of 1 - similarity of the best candidate to that of the next with another disparity, at most.
constexpr double kMaxUnlikeness = 0.6;
constexpr int kUnlike = 256;  ///< distance of a similarity of 0

bool CrossesDirt(const Segment2& s, const DirtCells& dirt) {
  for (int i = 0; i < kDirtPlaces; ++i) {
    if (dirt.IsOn(s.p + (i + 0.5) / kDirtPlaces * (s.q - s.p))) return true;
  }
  return false;
}

}  // namespace

std::vector<StereoLine> WithoutDepth(std::vector<LineFeature> lines) {
  std::vector<StereoLine> out(lines.size());
  for (size_t i = 0; i < lines.size(); ++i) {
    out[i].left = lines[i];
    out[i].sigma_px = EndSigma_px(lines[i]);
  }
  return out;
}

void SetDepthFromRight(const LineFeature& right, const cv::Mat& left_image, const cv::Mat& right_image,
                       const RowField& rows, const StereoOptions& options, const PairDirt& dirt, StereoLine& line) {
  LineFeature corrected = right;
  if (!rows.is_zero()) {
    for (Eigen::Vector2d* px : {&corrected.segment.p, &corrected.segment.q}) px->y() = rows.LeftRow_px(*px);
  }
  const RowLine l = MakeRowLine(line.left.segment);
  const RowLine r = MakeRowLine(corrected.segment);
  line.disparity_p_px = line.disparity_q_px = -1.0;
  const StereoGates gates(options);
  if (!gates.HasAngle(l) || !gates.HasAngle(r) || !gates.Disparity(l, r)) return;
  if (!Appearance(left_image, right_image, rows, dirt, options.line_min_similarity).Confirms(line.left.segment, r))
    return;
  SetDepth(line, corrected, l, r, rows.skew(), options);
}

void MatchLinesStereo(std::vector<StereoLine>& left, const std::vector<LineFeature>& right, const cv::Mat& left_image,
                      const cv::Mat& right_image, const RowField& rows, const StereoOptions& options,
                      const PairDirt& dirt) {
  const Appearance appearance(left_image, right_image, rows, dirt, options.line_min_similarity);
  const StereoGates gates(options);
  const std::vector<RowLine> left_rows = MakeRowLines(left);
  const std::vector<RowLine> right_rows = MakeRowLines(right);
  const std::vector<Pairing> pairings = AllPairings(left, left_rows, right, right_rows, gates);
  const std::vector<BestPairing> of_left = BestOf(pairings, left.size(), &Pairing::left);
  const std::vector<BestPairing> of_right = BestOf(pairings, right.size(), &Pairing::right);
  std::vector<bool> is_taken(right.size(), false);
  for (size_t i = 0; i < left.size(); ++i) {
    const Pairing* p = of_left[i].pairing;
    if (p == nullptr || p->distance > options.line_max_descriptor_distance) continue;
    const BestPairing& back = of_right[p->right];
    const int rival = std::min(of_left[i].rival_distance, back.rival_distance);
    if (back.pairing->left != i || p->distance > options.line_max_ratio * rival) continue;
    if (!appearance.Confirms(left[i].left.segment, right_rows[p->right])) continue;
    SetDepth(left[i], right[p->right], left_rows[i], right_rows[p->right], rows.skew(), options);
    is_taken[p->right] = true;
  }
  if (dirt.empty()) return;
  std::vector<Pairing> beside;
  for (const Pairing& p : pairings) {
    const Segment2& s = left[p.left].left.segment;
    if (left[p.left].HasDepth() || is_taken[p.right]) continue;
    if (!CrossesDirt(s, dirt.left) && !CrossesDirt(right[p.right].segment, dirt.right)) continue;
    const double similarity = appearance.SimilarityOf(s, right_rows[p.right]);
    beside.push_back({p.left, p.right, static_cast<int>(std::lround(kUnlike * (1.0 - similarity))), p.disparity});
  }
  const std::vector<BestPairing> beside_left = BestOf(beside, left.size(), &Pairing::left);
  const std::vector<BestPairing> beside_right = BestOf(beside, right.size(), &Pairing::right);
  for (size_t i = 0; i < left.size(); ++i) {
    const Pairing* p = beside_left[i].pairing;
    if (p == nullptr || p->distance > kUnlike * (1.0 - options.line_min_similarity)) continue;
    const BestPairing& back = beside_right[p->right];
    const int rival = std::min(beside_left[i].rival_distance, back.rival_distance);
    if (back.pairing->left != i || p->distance > kMaxUnlikeness * rival) continue;
    SetDepth(left[i], right[p->right], left_rows[i], right_rows[p->right], rows.skew(), options);
  }
}

}  // namespace plslam::vo
