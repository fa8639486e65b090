// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "core/geometry/triangulation.h"

namespace plslam::test {

/// A thick bar around a segment: half its width to each side, ends cut square.
struct Bar {
  Segment2 axis;
  double width_px = 20.0;
  double grey = 140.0;
};

/// Bars on a plain ground, box-sampled with 8x8 points a pixel; pixel centres have integer coordinates.
cv::Mat RenderBars(cv::Size size, double ground, const std::vector<Bar>& bars);

/// Everything right of p->q bright, the rest dark.
cv::Mat RenderEdge(cv::Size size, const Segment2& edge, double dark, double bright);

/// Gaussian noise (sum of twelve uniforms), rounded and cut to 0..255.
void AddNoise(cv::Mat& image, double sigma, uint32_t seed);

/// Returns an image of pure noise.
cv::Mat NoiseImage(cv::Size size, double mean, double sigma, uint32_t seed);

/// The segment turned by an angle around the middle of an image, `length` long.
Segment2 TurnedSegment(cv::Size size, double angle_rad, double length_px, double offset_px);

}  // namespace plslam::test
