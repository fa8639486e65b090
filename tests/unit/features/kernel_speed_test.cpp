// SPDX-License-Identifier: BSD-3-Clause
// Each vector kernel beside a plain scalar twin: the results are the same, and a kernel that compilers no longer turn
// into vector code fails here instead of making the tracker slower unseen.
#include <time.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include "core/features/image/gradients.h"
#include "core/features/image/linear_shrink.h"
#include "core/features/lines/lbd.h"
#include "core/features/lines/line_grower.h"
#include "core/features/matching/hamming.h"
#include "core/features/points/fast_score.h"
#include "core/features/points/orb_descriptor.h"
#include "tests/unit/features/scalar_twins.h"
#include "tests/unit/features/texture.h"
#include "vo_process/stereo/row_search.h"

namespace plslam {
namespace {

/// CPU time of this thread only, without other work on the machine.
double ThreadCpu_us() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return 1e6 * static_cast<double>(t.tv_sec) + 1e-3 * static_cast<double>(t.tv_nsec);
}

template <class Run>
double Time_us(const Run& run) {
  const double begin = ThreadCpu_us();
  run();
  return ThreadCpu_us() - begin;
}

/// Returns whether times of this build are meaningful: optimised, and not slowed down by a sanitizer or counters.
bool IsTimed() {
#if defined(__x86_64__) && defined(__OPTIMIZE__) && !defined(__clang__) && !defined(PLSLAM_SANITIZED)
  return __builtin_cpu_supports("avx2") != 0 && __builtin_cpu_supports("popcnt") != 0;
#else
  return false;
#endif
}

/// Compares the fastest of many alternating runs: disturbances only make a run slower. `share` is the largest permitted
/// share of the twin's time, two or three times the share of vector code.
template <class Kernel, class Twin>
void ExpectFaster(double share, const Kernel& kernel, const Twin& twin) {
  constexpr int kRuns = 60;
  if (!IsTimed()) GTEST_SKIP() << "no optimised build for x86-64 by GCC, or no processor with AVX2";
  double kernel_us = std::numeric_limits<double>::infinity();
  double twin_us = kernel_us;
  for (int i = 0; i < kRuns; ++i) {
    kernel_us = std::min(kernel_us, Time_us(kernel));
    twin_us = std::min(twin_us, Time_us(twin));
  }
  testing::Test::RecordProperty("kernel_us", std::to_string(kernel_us));
  testing::Test::RecordProperty("twin_us", std::to_string(twin_us));
  EXPECT_LT(kernel_us, share * twin_us) << "the kernel takes " << kernel_us << " us, its scalar twin " << twin_us;
}

constexpr int kWidth_px = 376;
constexpr int kHeight_px = 240;

class KernelSpeed : public testing::Test {
 protected:
  static bool AreEqual(const cv::Mat& a, const cv::Mat& b) {
    return a.size() == b.size() && a.type() == b.type() && cv::norm(a, b, cv::NORM_INF) == 0.0;
  }

  const cv::Mat image_ = test::RenderTexture(kWidth_px, kHeight_px, {.noise = 2.0});
  cv::Mat result_, expected_;
};

TEST_F(KernelSpeed, HammingDistances) {
  std::mt19937_64 random(1);
  std::vector<Descriptor> descriptors(2000);
  for (Descriptor& d : descriptors) {
    for (uint64_t& word : d) word = random();
  }
  std::vector<uint16_t> distances(descriptors.size()), expected(descriptors.size());
  const auto n = static_cast<int>(descriptors.size());
  const auto kernel = [&] { HammingDistances(descriptors[0], descriptors.data(), n, distances.data()); };
  const auto twin = [&] { test::ScalarHammingDistances(descriptors[0], descriptors, expected.data()); };
  kernel();
  twin();
  EXPECT_EQ(distances, expected);
  ExpectFaster(0.5, kernel, twin);
}

TEST_F(KernelSpeed, FastScores) {
  const auto kernel = [&] { FastScores(image_, result_); };
  const auto twin = [&] { test::ScalarFastScores(image_, expected_); };
  kernel();
  twin();
  EXPECT_TRUE(AreEqual(result_, expected_));
  ExpectFaster(0.3, kernel, twin);
}

TEST_F(KernelSpeed, SuppressNonMaxima) {
  cv::Mat scores;
  FastScores(image_, scores);
  const auto kernel = [&] { SuppressNonMaxima(scores, 10, result_); };
  const auto twin = [&] { test::ScalarSuppressNonMaxima(scores, 10, expected_); };
  kernel();
  twin();
  EXPECT_TRUE(AreEqual(result_, expected_));
  ExpectFaster(0.3, kernel, twin);
}

TEST_F(KernelSpeed, DiscMoments) {
  float sum = 0.0F;
  int of_twins = 0;
  const auto each = [](const auto& visit) {
    for (int y = 20; y < kHeight_px - 20; y += 10) {
      for (int x = 20; x < kWidth_px - 20; x += 10) visit(x, y);
    }
  };
  each([&](int x, int y) {
    const auto [m10, m01] = test::ScalarDiscMoments(image_, x, y);
    EXPECT_NEAR(IntensityCentroidAngle(image_, x, y), std::atan2(m01, m10), 1e-3) << x << ", " << y;
  });
  ExpectFaster(
      0.5, [&] { each([&](int x, int y) { sum += IntensityCentroidAngle(image_, x, y); }); },
      [&] { each([&](int x, int y) { of_twins += test::ScalarDiscMoments(image_, x, y)[0]; }); });
  // Used, so that neither is left out.
  EXPECT_TRUE(IsSkipped() || sum != static_cast<float>(of_twins));
}

TEST_F(KernelSpeed, BlurForBrief) {
  const auto kernel = [&] { BlurForBrief(image_, result_); };
  const auto twin = [&] { test::ScalarBlur(image_, expected_); };
  kernel();
  twin();
  EXPECT_TRUE(AreEqual(result_, expected_));
  ExpectFaster(0.5, kernel, twin);
}

TEST_F(KernelSpeed, LinearShrink) {
  const cv::Size to(kWidth_px * 5 / 6, kHeight_px * 5 / 6);
  LinearShrink shrink(image_.size(), to);
  const test::ScalarShrink scalar(image_.size(), to);
  const auto kernel = [&] { shrink.Apply(image_, result_); };
  const auto twin = [&] { scalar.Apply(image_, expected_); };
  kernel();
  twin();
  EXPECT_TRUE(AreEqual(result_, expected_));
  ExpectFaster(0.5, kernel, twin);
}

TEST_F(KernelSpeed, Gradients) {
  Gradients gradients, expected;
  const auto kernel = [&] { ComputeGradients(image_, gradients); };
  const auto twin = [&] { test::ScalarGradients(image_, expected); };
  kernel();
  twin();
  EXPECT_TRUE(AreEqual(gradients.dx, expected.dx) && AreEqual(gradients.dy, expected.dy));
  ExpectFaster(0.5, kernel, twin);
}

TEST_F(KernelSpeed, EdgeMap) {
  constexpr int kThreshold = 10 * Gradients::kStepGain;
  Gradients gradients;
  ComputeGradients(image_, gradients);
  const auto kernel = [&] { ComputeEdgeMap(gradients, kThreshold, result_); };
  const auto twin = [&] { test::ScalarEdgeMap(gradients, kThreshold, expected_); };
  kernel();
  twin();
  EXPECT_TRUE(AreEqual(result_, expected_));
  ExpectFaster(0.3, kernel, twin);
}

TEST_F(KernelSpeed, LbdRows) {
  Gradients gradients;
  ComputeGradients(image_, gradients);
  std::vector<Segment2> segments;
  for (int i = 0; i < 100; ++i) {
    const Eigen::Vector2d p(60.0 + 2.0 * i, 60.0 + 0.5 * i);
    const double angle = 0.37 * i;
    segments.push_back({p, p + 36.0 * Eigen::Vector2d(std::cos(angle), std::sin(angle))});
    EXPECT_EQ(LbdRows(gradients, segments.back()), test::ScalarLbdRows(gradients, segments.back())) << i;
  }
  int32_t sum = 0;
  ExpectFaster(
      0.8,
      [&] {
        for (const Segment2& s : segments) sum += LbdRows(gradients, s)[7][0];
      },
      [&] {
        for (const Segment2& s : segments) sum -= test::ScalarLbdRows(gradients, s)[7][0];
      });
  EXPECT_EQ(sum, 0);
}

TEST_F(KernelSpeed, RowSearch) {
  constexpr int kPlaces = 96;
  const cv::Mat right =
      test::RenderTexture(kWidth_px, kHeight_px, {.shift_x_px = 23.0, .noise = 2.0, .noise_seed = 2});
  const vo::HalvedPair pair(image_, right);
  vo::RowSearch search(pair);
  const auto each = [](const auto& visit) {
    for (int y = 20; y < kHeight_px - 20; y += 40) {
      for (int x = 120; x < kWidth_px - 20; x += 40) visit(x, y);
    }
  };
  each([&](int x, int y) {
    const auto match = search.Find({x, y}, 1.0, 0.0, kPlaces - 1);
    ASSERT_TRUE(match);
    EXPECT_EQ(match->disparity_px, test::ScalarRowSearch(image_, right, x, y, kPlaces)) << x << ", " << y;
  });
  double sum = 0.0;
  ExpectFaster(
      0.5, [&] { each([&](int x, int y) {
                   sum += search.Find({x, y}, 1.0, 0.0, kPlaces - 1)->disparity_px;
                 }); },
      [&] { each([&](int x, int y) { sum -= test::ScalarRowSearch(image_, right, x, y, kPlaces); }); });
  EXPECT_EQ(sum, 0.0);
}

}  // namespace
}  // namespace plslam
