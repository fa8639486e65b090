// SPDX-License-Identifier: BSD-3-Clause
#include "core/features/lines/line_grower.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "core/features/image/vector_kernels.h"

namespace plslam {
namespace {

constexpr int kMargin = 2;

int16_t Magnitude(int16_t v) { return static_cast<int16_t>(v < 0 ? -v : v); }

int16_t Mask(bool v) { return static_cast<int16_t>(-static_cast<int16_t>(v)); }

/// Pointers are at the first pixel to mark; `up` and `down` are the dy rows above and below.
PLSLAM_AVX2_CLONES void MarkRow(const int16_t* dx, const int16_t* dy, const int16_t* up, const int16_t* down,
                                int count, int16_t threshold, uint8_t* __restrict out) {
  // Everything is loaded and computed, then selected by masks, so that the loop has no branches and is vectorised.
  for (int x = 0; x < count; ++x) {
    const int16_t ax = Magnitude(dx[x]);
    const int16_t ay = Magnitude(dy[x]);
    const int16_t left = Magnitude(dx[x - 1]);
    const int16_t right = Magnitude(dx[x + 1]);
    const int16_t above = Magnitude(up[x]);
    const int16_t below = Magnitude(down[x]);
    const int16_t steep = Mask((ax >= ay) & (ax >= threshold) & (ax > left) & (ax >= right));
    const int16_t flat = Mask((ay > ax) & (ay >= threshold) & (ay > above) & (ay >= below));
    out[x] = static_cast<uint8_t>((steep & kSteepEdge) | (flat & kFlatEdge));
  }
}

}  // namespace

void ComputeEdgeMap(const Gradients& gradients, int threshold, cv::Mat& out) {
  const int width = gradients.dx.cols;
  const int height = gradients.dx.rows;
  out.create(height, width, CV_8UC1);
  if (width <= 2 * kMargin || height <= 2 * kMargin) {
    out.setTo(kNoEdge);
    return;
  }
  out.rowRange(0, kMargin).setTo(kNoEdge);
  out.rowRange(height - kMargin, height).setTo(kNoEdge);
  for (int y = kMargin; y < height - kMargin; ++y) {
    uint8_t* row = out.ptr<uint8_t>(y);
    std::fill_n(row, kMargin, uint8_t{kNoEdge});
    std::fill_n(row + width - kMargin, kMargin, uint8_t{kNoEdge});
    MarkRow(gradients.dx.ptr<int16_t>(y) + kMargin, gradients.dy.ptr<int16_t>(y) + kMargin,
            gradients.dy.ptr<int16_t>(y - 1) + kMargin, gradients.dy.ptr<int16_t>(y + 1) + kMargin,
            width - 2 * kMargin, static_cast<int16_t>(threshold), row + kMargin);
  }
}

namespace {

/// Steps of the first walk in each direction.
constexpr int kWalkSteps = 5;
constexpr int kWalkPixels = 2 * kWalkSteps + 1;
/// Largest distance from the chord in whole pixels, then from the fitted line.
constexpr int kMaxWalkOffset_px = 1;
constexpr double kMaxWalkResidual_px = 0.8;
/// Largest distance (along the minor axis) of a pixel that joins the line.
constexpr double kJoin_px = 1.0;
/// Consecutive steps without an edge pixel that end a segment.
constexpr int kMaxGap = 4;
/// Tangent of the largest angle between gradients and the line's normal (22 degrees).
constexpr double kMaxLean = 0.41;
constexpr int64_t kLeanParts = 41;
constexpr int64_t kLeanUnit = 100;
/// The line is fitted again after this number of pixels: from eleven pixels on, one more changes it little.
constexpr int kSolveEvery = 4;
constexpr double kMinDensity = 0.75;
constexpr double kMaxRms_px = 0.6;
constexpr int kMinSamples = 10;

}  // namespace

LineGrower::LineGrower(const Gradients& gradients, cv::Mat& edges, double min_contrast)
    : dx_(gradients.dx.ptr<int16_t>()),
      dy_(gradients.dy.ptr<int16_t>()),
      edges_(edges.ptr<uint8_t>()),
      stride_(static_cast<int>(gradients.dx.step1())),
      edge_stride_(static_cast<int>(edges.step1())),
      width_(edges.cols),
      height_(edges.rows),
      min_contrast_(min_contrast) {}

void LineGrower::Fit::Add(double major, double place, double weight) {
  n += weight;
  m += weight * major;
  p += weight * place;
  mm += weight * major * major;
  mp += weight * major * place;
}

bool LineGrower::Fit::Solve() {
  const double determinant = n * mm - m * m;
  if (!(determinant > 0.0)) return false;
  b = (n * mp - m * p) / determinant;
  a = (p - b * m) / n;
  return true;
}

void LineGrower::SetAxes(bool steep) {
  steep_ = steep;
  across_ = steep ? dx_ : dy_;
  along_ = steep ? dy_ : dx_;
  major_stride_ = steep ? stride_ : 1;
  minor_stride_ = steep ? 1 : stride_;
  edge_major_stride_ = steep ? edge_stride_ : 1;
  edge_minor_stride_ = steep ? 1 : edge_stride_;
  major_size_ = steep ? height_ : width_;
  minor_size_ = steep ? width_ : height_;
}

/// In (minor, major) axes the gradient of an edge pixel is (across, along), the line place = b * major has the
/// direction (b, 1) and the normal (1, -b).
bool LineGrower::Agrees(int offset) const {
  const double c = sign_ * across_[offset];
  const double l = sign_ * along_[offset];
  const double with_normal = c - slope_ * l;
  const double with_line = slope_ * c + l;
  return with_normal > 0.0 && std::abs(with_line) <= kMaxLean * with_normal;
}

LineGrower::Sample LineGrower::Locate(int major, int minor) const {
  const int at = Offset(major, minor);
  const int middle = std::abs(across_[at]);
  const int before = std::abs(across_[at - minor_stride_]);
  const int after = std::abs(across_[at + minor_stride_]);
  const int curvature = before - 2 * middle + after;
  const double shift = curvature < 0 ? std::clamp(0.5 * (before - after) / curvature, -1.0, 1.0) : 0.0;
  return {major, minor, minor + shift, static_cast<double>(middle)};
}

bool LineGrower::WalkOneWay(int major, int step, int* minors) const {
  const int c0 = across_[Offset(major, *minors)];
  const int l0 = along_[Offset(major, *minors)];
  for (int i = 0; i < kWalkSteps; ++i) {
    major += step;
    const int minor = *minors;
    minors += step;
    int best_strength = 0;
    for (int candidate = minor - 1; candidate <= minor + 1; ++candidate) {
      const uint8_t mark = edges_[EdgeOffset(major, candidate)];
      if (mark == kNoEdge || (mark & kUsedEdge) != 0) continue;
      const int at = Offset(major, candidate);
      const int c = across_[at];
      const int l = along_[at];
      const int64_t with = c0 * c + l0 * l;
      const int64_t against = std::abs(c0 * l - l0 * c);
      const int strength = std::abs(c);
      if (strength <= best_strength || kLeanUnit * against > kLeanParts * with) continue;
      *minors = candidate;
      best_strength = strength;
    }
    if (best_strength == 0) return false;
  }
  return true;
}

bool LineGrower::WalkFromSeed(int major, int minor) {
  if (major < kWalkSteps + 2 || major >= major_size_ - kWalkSteps - 2) return false;
  int minors[kWalkPixels];
  minors[kWalkSteps] = minor;
  if (!WalkOneWay(major, 1, minors + kWalkSteps) || !WalkOneWay(major, -1, minors + kWalkSteps)) return false;
  // Whole pixels first: most seeds in texture are rejected here.
  const int chord = minors[kWalkPixels - 1] - minors[0];
  for (int i = 1; i < kWalkPixels - 1; ++i) {
    const int off_chord = 2 * kWalkSteps * (minors[i] - minors[0]) - i * chord;
    if (std::abs(off_chord) > 2 * kWalkSteps * kMaxWalkOffset_px) return false;
  }
  samples_.clear();
  origin_ = major;
  sign_ = across_[Offset(major, minor)] < 0 ? -1.0 : 1.0;
  for (int i = 0; i < kWalkPixels; ++i) samples_.push_back(Locate(major - kWalkSteps + i, minors[i]));
  return true;
}

bool LineGrower::StraightSoFar() {
  fit_ = Fit();
  for (const Sample& s : samples_) fit_.Add(s.major - origin_, s.place, 1.0);
  if (!fit_.Solve()) return false;
  slope_ = fit_.b;
  for (const Sample& s : samples_) {
    if (std::abs(s.place - fit_.a - fit_.b * (s.major - origin_)) > kMaxWalkResidual_px) return false;
  }
  return true;
}

bool LineGrower::TakeNear(int major, double place, double tolerance, std::vector<Sample>& out) {
  // Rounds positions inside the image; positions truncated towards zero from below are outside as well.
  const int nearest = static_cast<int>(place + 0.5);  // NOLINT(bugprone-incorrect-roundings)
  if (nearest < 3 || nearest >= minor_size_ - 3) return false;
  // The nearest pixel first, then the neighbour on the nearer side, then the other one.
  const int side = place >= nearest ? 1 : -1;
  for (const int minor : {nearest, nearest + side, nearest - side}) {
    const uint8_t mark = edges_[EdgeOffset(major, minor)];
    if (mark == kNoEdge || (mark & kUsedEdge) != 0 || !Agrees(Offset(major, minor))) continue;
    const Sample sample = Locate(major, minor);
    if (std::abs(sample.place - place) > tolerance) continue;
    out.push_back(sample);
    return true;
  }
  return false;
}

void LineGrower::Extend(int step) {
  scratch_.clear();
  int major = step > 0 ? samples_.back().major : samples_.front().major;
  int gap = 0;
  int taken = 0;
  while (gap < kMaxGap) {
    major += step;
    if (major < 2 || major >= major_size_ - 2) break;
    if (!TakeNear(major, fit_.a + fit_.b * (major - origin_), kJoin_px, scratch_)) {
      ++gap;
      continue;
    }
    gap = 0;
    fit_.Add(major - origin_, scratch_.back().place, 1.0);
    if (++taken % kSolveEvery == 0) fit_.Solve();
    slope_ = fit_.b;
  }
  fit_.Solve();
  if (step > 0) {
    samples_.insert(samples_.end(), scratch_.begin(), scratch_.end());
  } else {
    samples_.insert(samples_.begin(), scratch_.rbegin(), scratch_.rend());
  }
}

bool LineGrower::FitWithoutOutliers() {
  double limit = kJoin_px;
  for (int round = 0; round < 2; ++round) {
    Fit fit;
    double squares = 0.0;
    double weights = 0.0;
    for (const Sample& s : samples_) {
      const double r = s.place - fit_.a - fit_.b * (s.major - origin_);
      if (std::abs(r) > limit) continue;
      fit.Add(s.major - origin_, s.place, s.strength);
      squares += s.strength * r * r;
      weights += s.strength;
    }
    if (!fit.Solve()) return false;
    fit_ = fit;
    const double rms = std::sqrt(squares / weights);
    if (rms > kMaxRms_px) return false;
    limit = std::max(0.3, 2.5 * rms);
  }
  return true;
}

void LineGrower::TrimEnds() {
  const auto is_on_line = [this](const Sample& s) {
    return std::abs(s.place - fit_.a - fit_.b * (s.major - origin_)) <= 0.7;
  };
  while (!samples_.empty() && !is_on_line(samples_.back())) samples_.pop_back();
  const auto first = std::find_if(samples_.begin(), samples_.end(), is_on_line);
  samples_.erase(samples_.begin(), first);
}

std::optional<DetectedSegment> LineGrower::Finish() {
  if (static_cast<int>(samples_.size()) < kMinSamples || !FitWithoutOutliers()) return std::nullopt;
  TrimEnds();
  if (static_cast<int>(samples_.size()) < kMinSamples) return std::nullopt;
  const int first = samples_.front().major;
  const int last = samples_.back().major;
  if (static_cast<double>(samples_.size()) < kMinDensity * (last - first + 1)) return std::nullopt;
  double strength = 0.0;
  for (const Sample& s : samples_) strength += s.strength;
  // `strength` is the minor-axis component of the gradient across the line.
  const double contrast = strength / static_cast<double>(samples_.size()) * std::sqrt(1.0 + fit_.b * fit_.b) /
                          static_cast<double>(Gradients::kStepGain);
  if (contrast < min_contrast_) return std::nullopt;

  const Eigen::Vector2d low(first, fit_.a + fit_.b * (first - origin_));
  const Eigen::Vector2d high(last, fit_.a + fit_.b * (last - origin_));
  // Brighter on the right of p->q: downwards has the left side of the image on its right, rightwards the lower side.
  if (steep_) {
    const Eigen::Vector2d top(low.y(), low.x());
    const Eigen::Vector2d bottom(high.y(), high.x());
    if (sign_ > 0) return DetectedSegment{{bottom, top}, contrast};
    return DetectedSegment{{top, bottom}, contrast};
  }
  if (sign_ > 0) return DetectedSegment{{low, high}, contrast};
  return DetectedSegment{{high, low}, contrast};
}

std::optional<DetectedSegment> LineGrower::Grow(int x, int y) {
  SetAxes(edges_[y * edge_stride_ + x] == kSteepEdge);
  if (!WalkFromSeed(steep_ ? y : x, steep_ ? x : y) || !StraightSoFar()) return std::nullopt;
  Extend(1);
  Extend(-1);
  // Other pixels of a failed segment are no seeds any more, but may join another segment.
  tried_ = samples_;
  auto segment = Finish();
  for (const Sample& s : segment ? samples_ : tried_) {
    edges_[EdgeOffset(s.major, s.minor)] |= segment ? kUsedEdge : kTriedEdge;
  }
  return segment;
}

}  // namespace plslam
