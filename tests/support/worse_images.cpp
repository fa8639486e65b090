// SPDX-License-Identifier: BSD-3-Clause
#include "tests/support/worse_images.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "core/datasets/synthetic/weather.h"

namespace plslam::test {
namespace {

double Gain(const Worsening& worsening, int index) {
  const double phase = 2.0 * std::numbers::pi * index / worsening.exposure_period;
  return 1.0 - (1.0 - worsening.darkest) * 0.5 * (1.0 - std::cos(phase));
}

void Cover(double share, cv::Mat& image) {
  const int side = static_cast<int>(share * image.rows);
  const cv::Rect middle((image.cols - side) / 2, (image.rows - side) / 2, side, side);
  image(middle & cv::Rect(0, 0, image.cols, image.rows)).setTo(0);
}

void AddWeather(const Worsening& worsening, int index, int camera, cv::Mat& image) {
  if (image.type() != CV_8UC1) return;  // depth
  std::vector<float> radiance(image.total());
  cv::Mat grey(image.size(), CV_32F, radiance.data());
  image.convertTo(grey, CV_32F);
  const auto seed = static_cast<uint64_t>(worsening.dirt_seed);
  synthetic::Weather(image.cols, image.rows, worsening.streaks, worsening.dirt, seed).Apply(index, camera, radiance);
  grey.convertTo(image, CV_8U);
}

cv::Mat Worse(const cv::Mat& image, const Worsening& worsening, double gain, uint64_t seed) {
  if (image.type() != CV_8UC1) return image;  // depth
  cv::Mat worse;
  image.convertTo(worse, CV_32F, gain);
  if (worsening.blur_sigma_px > 0.0) cv::GaussianBlur(worse, worse, {}, worsening.blur_sigma_px);
  if (worsening.noise_sigma > 0.0) {
    cv::Mat noise(image.size(), CV_32F);
    cv::RNG(seed).fill(noise, cv::RNG::NORMAL, 0.0, worsening.noise_sigma);
    worse += noise;
  }
  worse.convertTo(worse, CV_8U);
  if (worsening.covered > 0.0) Cover(worsening.covered, worse);
  return worse;
}

}  // namespace

StereoImages WorseImages::Read(int index) const {
  StereoImages images = dataset_.Read(index);
  const double gain = Gain(worsening_, index);
  const uint64_t seed = n_read_++;
  images.left = Worse(images.left, worsening_, gain, 2 * seed + 1);
  images.right = Worse(images.right, worsening_, 0.5 * (1.0 + gain), 2 * seed + 2);
  if (worsening_.streaks > 0 || worsening_.dirt > 0) {
    AddWeather(worsening_, index, 0, images.left);
    AddWeather(worsening_, index, 1, images.right);
  }
  if (worsening_.IsBlack(index)) {
    images.left.setTo(0);
    images.right.setTo(0);
  }
  return images;
}

}  // namespace plslam::test
