// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "core/features/features.h"
#include "core/features/image/gradients.h"
#include "core/features/lines/lbd.h"

/// The same results as the vector kernels, computed pixel by pixel, with as few operations. Compiled without vector
/// code (CMakeLists.txt), so that they show the time of a kernel that compilers do not vectorise.
namespace plslam::test {

void ScalarHammingDistances(const Descriptor& query, const std::vector<Descriptor>& descriptors, uint16_t* distances);

void ScalarFastScores(const cv::Mat& image, cv::Mat& scores);
void ScalarSuppressNonMaxima(const cv::Mat& scores, int min_score, cv::Mat& maxima);

/// First moments of the disc of radius `kOrbPatchRadius_px` around a pixel.
std::array<int, 2> ScalarDiscMoments(const cv::Mat& image, int x, int y);
void ScalarBlur(const cv::Mat& image, cv::Mat& blurred);

void ScalarGradients(const cv::Mat& image, Gradients& out);
void ScalarEdgeMap(const Gradients& gradients, int threshold, cv::Mat& out);

/// The segment must be within the image.
std::array<LbdRow, kLbdRows> ScalarLbdRows(const Gradients& gradients, const Segment2& segment);

/// Linear interpolation as in cv::resize; positions and weights are precomputed.
class ScalarShrink {
 public:
  ScalarShrink(cv::Size from, cv::Size to);
  void Apply(const cv::Mat& image, cv::Mat& out) const;

 private:
  struct Place {
    int first, second, weight;
  };
  static std::vector<Place> Places(int from, int to);

  std::vector<Place> columns_;
  std::vector<Place> rows_;
};

/// Returns the disparity, of `n_places` from disparity 0 on, at which the normalised correlation of 11x11 patches is
/// highest.
int ScalarRowSearch(const cv::Mat& left, const cv::Mat& right, int u, int v, int n_places);

}  // namespace plslam::test
