// SPDX-License-Identifier: BSD-3-Clause
#include "camera/capture_health.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <vector>

namespace plslam::camera {
namespace {

constexpr size_t kWindow = 101;
constexpr int kSampled_px = 4;
/// White and black of video, which are also near those of sensors.
constexpr uint8_t kWhite = 235;
constexpr uint8_t kBlack = 16;
constexpr double kMostly = 0.5;

void Push(std::deque<int64_t>* window, int64_t value) {
  window->push_back(value);
  if (window->size() > kWindow) window->pop_front();
}

int64_t Median(const std::deque<int64_t>& window) {
  if (window.empty()) return 0;
  std::vector<int64_t> sorted(window.begin(), window.end());
  const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
  std::nth_element(sorted.begin(), middle, sorted.end());
  return *middle;
}

}  // namespace

Exposure MeasureExposure(const cv::Mat& image) {
  int64_t white = 0, black = 0, all = 0;
  for (int y = 0; y < image.rows; y += kSampled_px) {
    const uint8_t* row = image.ptr<uint8_t>(y);
    for (int x = 0; x < image.cols; x += kSampled_px) {
      white += row[x] >= kWhite ? 1 : 0;
      black += row[x] <= kBlack ? 1 : 0;
      ++all;
    }
  }
  if (all == 0) return {};
  return {static_cast<double>(white) / static_cast<double>(all),
          static_cast<double>(black) / static_cast<double>(all)};
}

void CaptureHealth::CountMissing(int64_t t_ns) {
  const int64_t step_ns = t_ns - *last_t_ns_;
  Push(&steps_ns_, step_ns);
  const double period_ns = nominal_hz_ > 0.0 ? 1e9 / nominal_hz_ : static_cast<double>(Median(steps_ns_));
  if (period_ns > 0.0) missing_ += std::max<int64_t>(0, std::llround(static_cast<double>(step_ns) / period_ns) - 1);
}

void CaptureHealth::Add(const CapturedPair& pair) {
  ++pairs_;
  if (last_t_ns_) CountMissing(pair.left.t_ns);
  last_t_ns_ = pair.left.t_ns;
  Push(&skews_ns_, std::abs(pair.left.t_ns - pair.right.t_ns));
  const Exposure left = MeasureExposure(pair.left.pixels);
  const Exposure right = MeasureExposure(pair.right.pixels);
  if (std::max(left.saturated, right.saturated) > kMostly) ++overexposed_;
  if (std::max(left.black, right.black) > kMostly) ++underexposed_;
}

double CaptureHealth::rate_hz() const {
  int64_t sum_ns = 0;
  for (const int64_t step_ns : steps_ns_) sum_ns += step_ns;
  return sum_ns > 0 ? 1e9 * static_cast<double>(steps_ns_.size()) / static_cast<double>(sum_ns) : 0.0;
}

double CaptureHealth::skew_ms() const { return 1e-6 * static_cast<double>(Median(skews_ns_)); }

}  // namespace plslam::camera
