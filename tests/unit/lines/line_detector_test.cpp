// SPDX-License-Identifier: BSD-3-Clause
#include "core/features/lines/line_detector.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "core/features/lines/line_extractor.h"
#include "core/features/lines/line_sigma.h"
#include "tests/unit/lines/rendered_edges.h"

namespace plslam {
namespace {

LineOptions WithDetector(Segments detector) {
  LineOptions options;
  options.detector = detector;
  return options;
}

/// Errors across the true edge of the segments found on it, at both ends.
struct Accuracy {
  int found = 0;
  double rms_px = 0.0;
  double normalised = 0.0;
};

/// One long side of a bar, at many directions and positions.
Accuracy Measure(Segments detector, double contrast, double noise) {
  LineExtractor extractor(WithDetector(detector));
  Accuracy out;
  double squares = 0.0;
  double normalised = 0.0;
  for (int i = 0; i < 36; ++i) {
    const Segment2 edge = test::TurnedSegment({120, 120}, 0.013 + i * M_PI / 18, 60, std::fmod(0.37 * i, 1.0));
    const Eigen::Vector2d d = (edge.q - edge.p).normalized();
    const Eigen::Vector2d inwards = 14.0 * Eigen::Vector2d(-d.y(), d.x());
    cv::Mat image = test::RenderBars({120, 120}, 90, {{{edge.p + inwards, edge.q + inwards}, 28, 90 + contrast}});
    if (noise > 0.0) test::AddNoise(image, noise, static_cast<uint32_t>(i));
    const Eigen::Vector3d line = LineThrough(edge);
    for (const LineFeature& f : extractor.Extract(image)) {
      const double a = line.dot(f.segment.p.homogeneous());
      const double b = line.dot(f.segment.q.homogeneous());
      if (std::max(std::abs(a), std::abs(b)) > 2.0 || (f.segment.q - f.segment.p).dot(d) < 0.0) continue;
      const double sigma = LineSigma_px(f.segment.Length(), f.response, 1.0);
      ++out.found;
      squares += (a * a + b * b) / 2.0;
      normalised += (a * a + b * b) / 2.0 / (sigma * sigma);
    }
  }
  out.rms_px = std::sqrt(squares / out.found);
  out.normalised = std::sqrt(normalised / out.found);
  return out;
}

TEST(LineDetector, EdgeChainAccuracyOnRenderedEdges) {
  const Accuracy a = Measure(Segments::kEdgeChain, 40, 2);
  EXPECT_EQ(a.found, 36);
  EXPECT_LE(a.rms_px, 0.05) << "rms across";
}

TEST(LineDetector, AllFindRenderedEdgesInNoise) {
  for (const auto& [name, detector] : ChoicesOf(Segments())) {
    const Accuracy a = Measure(detector, 40, 2);
    EXPECT_GE(a.found, 34) << name;
    EXPECT_LE(a.rms_px, 0.15) << name;
  }
}

TEST(LineDetector, SigmaMatchesTheErrors) {
  const Accuracy faint = Measure(Segments::kEdgeChain, 12, 2);
  EXPECT_GE(faint.found, 30);
  EXPECT_GT(faint.normalised, 0.7);
  EXPECT_LT(faint.normalised, 1.3);
  // At high contrast the floor, which accounts for real edges, makes it conservative.
  const Accuracy clear = Measure(Segments::kEdgeChain, 40, 2);
  EXPECT_GT(clear.normalised, 0.4);
  EXPECT_LT(clear.normalised, 1.2);
}

TEST(LineDetector, BrighterSideIsOnTheRight) {
  for (const auto& [name, detector] : ChoicesOf(Segments())) {
    LineExtractor extractor(WithDetector(detector));
    for (int i = 0; i < 16; ++i) {
      const Segment2 edge = test::TurnedSegment({100, 100}, 0.05 + i * M_PI / 8, 200, 1.5);
      const auto lines = extractor.Extract(test::RenderEdge({100, 100}, edge, 60, 160));
      ASSERT_EQ(lines.size(), 1U) << name << " direction " << i;
      const Segment2& s = lines[0].segment;
      EXPECT_GT((s.q - s.p).normalized().dot((edge.q - edge.p).normalized()), 0.999) << name << " direction " << i;
      EXPECT_NEAR(lines[0].response, 100.0, 8.0) << name;
    }
  }
}

TEST(LineDetector, DirectTurnsASegmentAndMeasuresItsContrast) {
  Gradients g;
  const Segment2 edge{{50, 10}, {50, 90}};
  ComputeGradients(test::RenderEdge({100, 100}, edge, 40, 140), g);
  const DetectedSegment kept = Direct(edge, g);
  EXPECT_EQ(kept.segment.p, edge.p);
  const DetectedSegment turned = Direct({edge.q, edge.p}, g);
  EXPECT_EQ(turned.segment.p, edge.p);
  EXPECT_NEAR(turned.contrast, kept.contrast, 1e-12);
  EXPECT_NEAR(kept.contrast, 100.0, 2.0);
}

TEST(LineDetector, NoiseGivesNextToNoLines) {
  for (const auto& [name, detector] : ChoicesOf(Segments())) {
    for (const double sigma : {3.0, 12.0, 40.0}) {
      LineExtractor extractor(WithDetector(detector));
      const auto lines = extractor.Extract(test::NoiseImage({320, 240}, 128, sigma, 7));
      EXPECT_LE(lines.size(), 1U) << name << " sigma " << sigma;
    }
  }
}

TEST(LineDetector, AnySizeFromOnePixelIsAccepted) {
  for (const auto& [name, detector] : ChoicesOf(Segments())) {
    LineExtractor extractor(WithDetector(detector));
    EXPECT_TRUE(extractor.Extract(cv::Mat()).empty());
    for (const int width : {1, 2, 3, 5, 8, 13, 17, 33, 64}) {
      for (const int height : {1, 2, 4, 7, 11, 16, 19, 40}) {
        extractor.Extract(test::NoiseImage({width, height}, 128, 60, 2));
        EXPECT_TRUE(extractor.Extract(cv::Mat(height, width, CV_8UC1, cv::Scalar(0))).empty());
        EXPECT_TRUE(extractor.Extract(cv::Mat(height, width, CV_8UC1, cv::Scalar(255))).empty());
      }
    }
  }
}

}  // namespace
}  // namespace plslam
