// SPDX-License-Identifier: BSD-3-Clause
#include "core/datasets/synthetic/renderer.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "core/datasets/synthetic/simulator.h"
#include "core/datasets/synthetic/worlds.h"

namespace plslam::synthetic {
namespace {

Eigen::Vector3d Ray(const View& view, double u, double v) {
  return view.R_w_c * Eigen::Vector3d((u - view.cx) / view.fx, (v - view.cy) / view.fy, 1.0);
}

Eigen::Vector3d InCamera(const View& view, const Eigen::Vector3d& p_w) {
  return view.R_w_c.transpose() * (p_w - view.t_w_c);
}

float Bilinear(const std::vector<float>& image, const View& view, double u, double v) {
  const int x = static_cast<int>(u);
  const int y = static_cast<int>(v);
  const auto fx = static_cast<float>(u - x);
  const auto fy = static_cast<float>(v - y);
  const float* row = &image[static_cast<size_t>(y) * view.width + x];
  const float top = row[0] + fx * (row[1] - row[0]);
  const float bottom = row[view.width] + fx * (row[view.width + 1] - row[view.width]);
  return top + fy * (bottom - top);
}

double Median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + values.size() / 2, values.end());
  return values[values.size() / 2];
}

TEST(Renderer, DepthAgreesWithRaysCastAtEveryQuad) {
  for (const WorldKind& kind : WorldKinds()) {
    const Simulator simulator(ParseOptions(std::string(kind.name) + "?size=160x120&frames=40"));
    const View view = simulator.LeftView(17);
    const std::vector<float> depth = simulator.RenderDepth(17);
    int wrong = 0;
    for (int i = 0; i < 400; ++i) {
      const int x = i * 37 % 160;
      const int y = i * 53 % 120;
      const auto truth = simulator.world().CastRay(view.t_w_c, Ray(view, x, y));
      wrong += std::abs(depth[y * 160 + x] - truth.value_or(0.0)) > 1e-4 * truth.value_or(1.0) ? 1 : 0;
    }
    // A ray that hits an edge of a surface to the last bit may fall on either side.
    EXPECT_LE(wrong, 2) << kind.name;
  }
}

/// Shifts of windows between left and right after warping each pixel by its true disparity: a line search by one
/// Gauss-Newton step over 9 x 9 pixels.
std::vector<double> ResidualShifts(const Simulator& simulator, int index, double baseline_m) {
  const View left_view = simulator.LeftView(index);
  View right_view = left_view;
  right_view.t_w_c += baseline_m * left_view.R_w_c.col(0);
  const std::vector<float> left = RenderRadiance(simulator.world(), left_view);
  const std::vector<float> right = RenderRadiance(simulator.world(), right_view);
  const std::vector<float> depth = simulator.RenderDepth(index);
  std::vector<double> shifts;
  const double scale = left_view.fx * baseline_m;
  for (int y = 10; y < left_view.height - 10; y += 7) {
    for (int x = 10; x < left_view.width - 10; x += 7) {
      double gradient2 = 0.0;
      double product = 0.0;
      bool smooth = true;
      for (int k = 0; k < 81 && smooth; ++k) {
        const int u = x + k % 9 - 4;
        const int v = y + k / 9 - 4;
        const double z = depth[v * left_view.width + u];
        const double at = u - scale / z;
        const double neighbours = 0.5 * (depth[v * left_view.width + u - 1] + depth[v * left_view.width + u + 1]);
        smooth = z > 0.0 && at > 2.0 && std::abs(neighbours / z - 1.0) < 1e-3;
        if (smooth) {
          const double slope =
              0.5 * (Bilinear(right, right_view, at + 1, v) - Bilinear(right, right_view, at - 1, v));
          gradient2 += slope * slope;
          product += slope * (left[v * left_view.width + u] - Bilinear(right, right_view, at, v));
        }
      }
      if (smooth && gradient2 > 81 * 25.0) {
        shifts.push_back(product / gradient2);
      }
    }
  }
  return shifts;
}

TEST(Renderer, DisparityIsUnbiased) {
  for (const char* world : {"room", "street"}) {
    const Simulator simulator(ParseOptions(std::string(world) + "?frames=60"));
    const std::vector<double> shifts = ResidualShifts(simulator, 30, simulator.rig().baseline_m);
    ASSERT_GT(shifts.size(), 100u) << world;
    std::vector<double> sizes;
    for (const double shift : shifts) {
      sizes.push_back(std::abs(shift));
    }
    EXPECT_LT(std::abs(Median(shifts)), 0.01) << world << ", " << shifts.size() << " windows";
    EXPECT_LT(Median(sizes), 0.05) << world;
    RecordProperty(std::string(world) + "_bias", std::to_string(Median(shifts)));
  }
}

/// A vertical edge between dark and bright at a known column.
TEST(Renderer, EdgesAreAtTheirTruePositions) {
  World world;
  const int dark = world.AddTexture(Texture(1, 1, Texture::Border::kClamp, {50.0F}));
  const int bright = world.AddTexture(Texture(1, 1, Texture::Border::kClamp, {150.0F}));
  Quad back{{-5.0, -5.0, 4.0}, {10.0, 0.0, 0.0}, {0.0, 10.0, 0.0}, dark, 0.0, 0.0, 1.0, 1.0, {1, 1, 1, 1}};
  world.AddQuad(back);
  Quad front = back;
  front.texture = bright;
  front.origin = {0.0123, -5.0, 2.0};
  world.AddQuad(front);
  View view{64, 48, 100.0, 100.0, 31.5, 23.5};
  for (int step = 0; step < 40; ++step) {
    view.t_w_c.x() = 0.0007 * step;
    const std::vector<float> image = RenderRadiance(world, view);
    double left_of_edge = 0.0;  // columns of dark, by area
    for (int x = 0; x < view.width; ++x) {
      left_of_edge += (150.0 - image[20 * view.width + x]) / 100.0;
    }
    const double truth = (0.0123 - view.t_w_c.x()) / 2.0 * view.fx + view.cx + 0.5;
    EXPECT_NEAR(left_of_edge, truth, 0.02) << "step " << step;
  }
}

/// Greatest change of grey across a line through p with the image direction `along`, within a pixel of it.
double StepAcross(const std::vector<float>& image, const View& view, const Eigen::Vector2d& p,
                  const Eigen::Vector2d& along) {
  const Eigen::Vector2d normal(-along.y(), along.x());
  double best = 0.0;
  for (const double shift : {-0.5, 0.0, 0.5}) {
    const Eigen::Vector2d a = p + (shift - 1.5) * normal;
    const Eigen::Vector2d b = p + (shift + 1.5) * normal;
    best = std::max(best, std::abs(static_cast<double>(Bilinear(image, view, a.x(), a.y())) -
                                   Bilinear(image, view, b.x(), b.y())));
  }
  return best;
}

TEST(Renderer, TrueSegmentsLieOnGradients) {
  for (const char* world : {"room", "corridor", "whitewall"}) {
    const Simulator simulator(ParseOptions(std::string(world) + "?frames=100"));
    const View view = simulator.LeftView(50);
    const std::vector<float> image = RenderRadiance(simulator.world(), view);
    int seen = 0;
    int strong = 0;
    for (const Segment3& segment : simulator.world().segments()) {
      const Eigen::Vector3d p = InCamera(view, segment.p);
      const Eigen::Vector3d q = InCamera(view, segment.q);
      const Eigen::Vector3d m = 0.5 * (p + q);
      if (p.z() < 0.2 || q.z() < 0.2) {
        continue;
      }
      const auto pixel = [&view](const Eigen::Vector3d& c) {
        return Eigen::Vector2d(c.x() / c.z() * view.fx + view.cx, c.y() / c.z() * view.fy + view.cy);
      };
      const Eigen::Vector2d at = pixel(m);
      const Eigen::Vector2d along = pixel(q) - pixel(p);
      const bool inside = at.x() > 5 && at.y() > 5 && at.x() < view.width - 6 && at.y() < view.height - 6;
      if (!inside || along.norm() < 40.0) {
        continue;
      }
      const auto hit = simulator.world().CastRay(view.t_w_c, 0.999 * Ray(view, at.x(), at.y()));
      if (hit && *hit * 0.999 > 0.995 * m.z()) {
        ++seen;
        strong += StepAcross(image, view, at, along.normalized()) > 6.0 ? 1 : 0;
      }
    }
    EXPECT_GE(seen, 12) << world;
    EXPECT_GE(strong, 0.7 * seen) << world << ": " << strong << " of " << seen;
  }
}

}  // namespace
}  // namespace plslam::synthetic
