#include "vo_process/stereo/patch_tracker.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <random>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/LU>

#include "tests/unit/features/texture.h"

namespace plslam {
namespace {

constexpr int kTrackedWidth = 200;
constexpr int kTrackedHeight = 160;
const Eigen::Vector2d kMiddle(100.3, 79.6);

/// How a place of the plane turns up in the view: `A` about the middle, then the shift.
struct Motion {
  Eigen::Matrix2d A = Eigen::Matrix2d::Identity();
  Eigen::Vector2d shift = Eigen::Vector2d::Zero();

  Eigen::Vector2d operator()(const Eigen::Vector2d& place) const { return kMiddle + A * (place - kMiddle) + shift; }
  Eigen::Vector2d Back(const Eigen::Vector2d& px) const { return kMiddle + A.inverse() * (px - kMiddle - shift); }
};

/// A view of waves of many directions, 5 to 40 pixels long, exact at every place.
cv::Mat Render(const Motion& motion, const test::View& view = {}, uint64_t seed = 1) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  std::vector<std::array<double, 3>> waves(60);
  for (auto& wave : waves) {
    const double direction = 2.0 * std::numbers::pi * uniform(random);
    const double frequency = 2.0 * std::numbers::pi / (5.0 * std::pow(8.0, uniform(random)));
    wave = {frequency * std::cos(direction), frequency * std::sin(direction), 6.0 * uniform(random)};
  }
  std::mt19937_64 noise_source(view.noise_seed);
  std::normal_distribution<double> normal(0.0, 1.0);
  cv::Mat image(kTrackedHeight, kTrackedWidth, CV_8UC1);
  for (int y = 0; y < kTrackedHeight; ++y) {
    for (int x = 0; x < kTrackedWidth; ++x) {
      const Eigen::Vector2d place = motion.Back(Eigen::Vector2d(x, y));
      double value = 100.0;
      for (const auto& [fx, fy, phase] : waves) value += 8.0 * std::sin(fx * place.x() + fy * place.y() + phase);
      value = view.gain * value + view.offset + view.noise * normal(noise_source);
      image.at<uint8_t>(y, x) = static_cast<uint8_t>(std::clamp(std::lround(value), 0L, 255L));
    }
  }
  return image;
}

std::optional<ReferencePatch> Reference(const ImageLevels& image, const Eigen::Vector2d& px, double scale) {
  const auto pixels = TakePatch(image, px, scale);
  return pixels ? MakeReferencePatch(*pixels) : std::nullopt;
}

struct Outcome {
  int tried = 0;
  int found = 0;
  double squared = 0.0;
  double squared_in_sigmas = 0.0;

  double Rms() const { return std::sqrt(squared / (2.0 * std::max(found, 1))); }
  double InSigmas() const { return std::sqrt(squared_in_sigmas / (2.0 * std::max(found, 1))); }
};

/// Tracks points all over the image, expected `start_error` from where they are.
Outcome TrackAll(const Motion& motion, const test::View& view, const Eigen::Matrix2d& expected_shape,
                 double shape_sigma = 0.01, double scale = 1.0, uint64_t seed = 1) {
  const ImageLevels then(Render({}, {.noise = view.noise, .noise_seed = 99}, seed));
  const ImageLevels now(Render(motion, view, seed));
  Outcome outcome;
  for (int i = 0; i < 100; ++i) {
    const Eigen::Vector2d px(55.0 + 9.37 * (i % 10), 45.0 + 7.13 * (i / 10));
    const auto reference = Reference(then, px, scale);
    if (!reference) continue;
    ++outcome.tried;
    const Eigen::Vector2d truth = motion(px);
    const Eigen::Vector2d start = truth + scale * Eigen::Vector2d(0.7 * std::cos(i), 0.7 * std::sin(i));
    const auto tracked = TrackPatch(*reference, now, {start, expected_shape, shape_sigma});
    if (!tracked) continue;
    ++outcome.found;
    const double squared = (tracked->px - truth).squaredNorm();
    outcome.squared += squared;
    outcome.squared_in_sigmas += squared / (tracked->sigma_px * tracked->sigma_px);
  }
  return outcome;
}

Motion Affine() {
  Motion motion;
  motion.A << 1.15, 0.12, -0.08, 0.95;
  motion.shift = {3.37, -2.71};
  return motion;
}

TEST(PatchTracker, SubPixelShiftsAreFound) {
  for (const double shift : {0.0, 0.25, 0.5, 0.81}) {
    const Motion motion{Eigen::Matrix2d::Identity(), {shift, -0.6 * shift}};
    const Outcome outcome = TrackAll(motion, {}, Eigen::Matrix2d::Identity());
    EXPECT_EQ(outcome.found, outcome.tried) << "shift " << shift;
    EXPECT_GT(outcome.tried, 90);
    EXPECT_LT(outcome.Rms(), 0.03) << "shift " << shift;
  }
}

TEST(PatchTracker, AffineShapesThatAreExpectedDoNoHarm) {
  const Motion motion = Affine();
  const Outcome known = TrackAll(motion, {}, motion.A);
  EXPECT_GT(known.found, 0.95 * known.tried);
  EXPECT_LT(known.Rms(), 0.05);
  const Outcome unknown = TrackAll(motion, {}, Eigen::Matrix2d::Identity());
  EXPECT_GT(unknown.Rms(), 2.0 * known.Rms()) << "the shape makes no difference";
}

TEST(PatchTracker, ErrorsOfTheExpectedShapeAreInTheDeviation) {
  const Motion motion = Affine();
  for (const double error : {0.03, 0.1}) {
    Eigen::Matrix2d off;
    off << error, -error, error, error;
    const Outcome outcome = TrackAll(motion, {}, motion.A + off, error);
    EXPECT_GT(outcome.found, 0.9 * outcome.tried) << error;
    EXPECT_GT(outcome.InSigmas(), 0.3) << error << " rms " << outcome.Rms();
    EXPECT_LT(outcome.InSigmas(), 1.5) << error << " rms " << outcome.Rms();
  }
}

TEST(PatchTracker, ExposureChangesDoNoHarm) {
  const Motion motion{Eigen::Matrix2d::Identity(), {0.4, 0.3}};
  const Outcome outcome = TrackAll(motion, {.gain = 0.6, .offset = 30.0}, Eigen::Matrix2d::Identity());
  EXPECT_EQ(outcome.found, outcome.tried);
  EXPECT_LT(outcome.Rms(), 0.05);
  const ImageLevels then(Render({}));
  const ImageLevels now(Render({}, {.gain = 0.6, .offset = 30.0}));
  const auto tracked = TrackPatch(*Reference(then, kMiddle, 1.0), now, {kMiddle});
  ASSERT_TRUE(tracked);
  EXPECT_NEAR(tracked->gain, 0.6, 0.05);
  EXPECT_GT(tracked->correlation, 0.99);
}

TEST(PatchTracker, NoiseIsInTheDeviation) {
  const Motion motion = Affine();
  for (const double noise : {2.0, 6.0}) {
    const Outcome outcome = TrackAll(motion, {.noise = noise}, motion.A);
    EXPECT_GT(outcome.found, 0.9 * outcome.tried) << noise;
    EXPECT_GT(outcome.InSigmas(), 0.25) << noise << " rms " << outcome.Rms();
    EXPECT_LT(outcome.InSigmas(), 1.4) << noise << " rms " << outcome.Rms();
  }
}

TEST(PatchTracker, CoarsePatchesFollowTheirScale) {
  const Motion motion{Eigen::Matrix2d::Identity(), {0.9, -1.3}};
  const Outcome outcome = TrackAll(motion, {}, Eigen::Matrix2d::Identity(), 0.01, 2.0);
  EXPECT_GT(outcome.tried, 50);
  EXPECT_GT(outcome.found, 0.95 * outcome.tried);
  EXPECT_LT(outcome.Rms(), 0.1);
}

TEST(PatchTracker, AViewTwiceAsNearIsComparedAtItsSize) {
  Motion motion;
  motion.A = 1.9 * Eigen::Matrix2d::Identity();
  const ImageLevels then(Render({}));
  const ImageLevels now(Render(motion));
  const auto reference = Reference(then, kMiddle, 1.0);
  ASSERT_TRUE(reference);
  const auto tracked = TrackPatch(*reference, now, {motion(kMiddle) + Eigen::Vector2d(0.5, -0.4), motion.A, 0.01});
  ASSERT_TRUE(tracked);
  EXPECT_LT((tracked->px - motion(kMiddle)).norm(), 0.25);
  EXPECT_FALSE(TrackPatch(*reference, now, {kMiddle, 4.0 * Eigen::Matrix2d::Identity(), 0.01}));
}

TEST(PatchTracker, HiddenPlacesAreNotFoundOrDoNotCorrelate) {
  const ImageLevels then(Render({}));
  cv::Mat image = Render({});
  test::RandomImage(40, 40, 5).copyTo(image(cv::Rect(80, 60, 40, 40)));
  const auto tracked = TrackPatch(*Reference(then, kMiddle, 1.0), ImageLevels(image), {kMiddle});
  if (tracked) {
    EXPECT_LT(tracked->correlation, 0.6);
  }
}

TEST(PatchTracker, EdgesAndFlatPlacesAreNoReference) {
  cv::Mat image(kTrackedHeight, kTrackedWidth, CV_8UC1, cv::Scalar(90));
  EXPECT_FALSE(Reference(ImageLevels(image), kMiddle, 1.0));
  image.colRange(100, kTrackedWidth).setTo(160);
  EXPECT_FALSE(Reference(ImageLevels(image), kMiddle, 1.0));
  image.rowRange(80, kTrackedHeight).setTo(30);
  EXPECT_TRUE(Reference(ImageLevels(image), kMiddle, 1.0));
}

TEST(PatchTracker, NoiseAlongAnEdgeIsNoCorner) {
  const auto noisy_edge = [](uint64_t seed) {
    std::mt19937_64 random(seed);
    std::normal_distribution<double> normal(0.0, 6.0);
    cv::Mat image(kTrackedHeight, kTrackedWidth, CV_8UC1);
    for (int y = 0; y < kTrackedHeight; ++y) {
      for (int x = 0; x < kTrackedWidth; ++x) {
        image.at<uint8_t>(y, x) = static_cast<uint8_t>(std::lround((x < 100 ? 90.0 : 160.0) + normal(random)));
      }
    }
    return ImageLevels(image);
  };
  const auto reference = Reference(noisy_edge(1), kMiddle, 1.0);
  if (reference) {
    EXPECT_FALSE(TrackPatch(*reference, noisy_edge(2), {kMiddle}));
  }
}

TEST(PatchTracker, TheBorderEndsATrack) {
  const ImageLevels image(Render({}));
  EXPECT_FALSE(Reference(image, {4.0, 80.0}, 1.0));
  EXPECT_FALSE(Reference(image, {80.0, kTrackedHeight - 3.0}, 1.0));
  const auto reference = Reference(image, kMiddle, 1.0);
  ASSERT_TRUE(reference);
  for (const Eigen::Vector2d& px : {Eigen::Vector2d(3.0, 80.0), Eigen::Vector2d(kTrackedWidth - 3.0, 80.0),
                                    Eigen::Vector2d(80.0, 2.0), Eigen::Vector2d(-1e9, 80.0)}) {
    EXPECT_FALSE(TrackPatch(*reference, image, {px})) << px.transpose();
  }
}

TEST(PatchTracker, NothingComesOfNothing) {
  const ImageLevels image(Render({}));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(Reference(ImageLevels(), kMiddle, 1.0));
  EXPECT_FALSE(Reference(ImageLevels(cv::Mat()), kMiddle, 1.0));
  EXPECT_FALSE(Reference(ImageLevels(Render({})(cv::Rect(0, 0, 1, 1))), {0.0, 0.0}, 4.0));
  EXPECT_FALSE(Reference(image, {nan, 80.0}, 1.0));
  const auto reference = Reference(image, kMiddle, 1.0);
  ASSERT_TRUE(reference);
  EXPECT_FALSE(TrackPatch(*reference, ImageLevels(), {kMiddle}));
  EXPECT_FALSE(TrackPatch(*reference, image, {{nan, 1.0}}));
  EXPECT_FALSE(TrackPatch(*reference, image, {kMiddle, Eigen::Matrix2d::Constant(nan)}));
  EXPECT_FALSE(TrackPatch(*reference, image, {kMiddle, Eigen::Matrix2d::Zero()}));
}

}  // namespace
}  // namespace plslam
