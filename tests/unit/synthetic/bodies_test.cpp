// SPDX-License-Identifier: BSD-3-Clause
#include "core/datasets/synthetic/bodies.h"

#include <algorithm>
#include <cmath>
#include <future>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include "core/datasets/synthetic/simulator.h"

namespace plslam::synthetic {
namespace {

Simulator Make(const std::string& description) { return Simulator(ParseOptions(description)); }

bool SamePixels(const cv::Mat& a, const cv::Mat& b) { return cv::norm(a, b, cv::NORM_INF) == 0.0; }

Eigen::Vector3d PointAt(const View& view, int x, int y, double depth) {
  const Eigen::Vector3d ray((x - view.cx) / view.fx, (y - view.cy) / view.fy, 1.0);
  return view.R_w_c * (depth * ray) + view.t_w_c;
}

double ShareOf(const std::vector<int>& map) {
  const auto covered = std::count_if(map.begin(), map.end(), [](int body) { return body >= 0; });
  return static_cast<double>(covered) / static_cast<double>(map.size());
}

TEST(Bodies, NoneByDefaultAndEqualBitsWithNone) {
  const Simulator plain = Make("street?size=160x120&frames=9");
  const Simulator none = Make("street?size=160x120&frames=9&bodies=0&body=cross&static_body=0&standing=0");
  EXPECT_EQ(none.bodies().size(), 0);
  EXPECT_EQ(none.world().textures().size(), plain.world().textures().size());
  EXPECT_TRUE(SamePixels(plain.Render(5).left, none.Render(5).left));
  EXPECT_TRUE(SamePixels(plain.Render(5).right, none.Render(5).right));
  EXPECT_EQ(ShareOf(plain.RenderBodies(5)), 0.0);
}

TEST(Bodies, DepthAgreesWithRayCasting) {
  for (const char* body : {"lead", "overtake", "cross", "stop", "crowd"}) {
    const Simulator simulator = Make(std::string("street?size=160x120&frames=200&bodies=3&body=") + body);
    int on_bodies = 0;
    int wrong = 0;
    for (const int index : {0, 60, 110}) {
      World bodies;
      for (const Quad& quad : simulator.bodies().At(index).quads) bodies.AddQuad(quad);
      const View view = simulator.LeftView(index);
      const std::vector<float> depth = simulator.RenderDepth(index);
      const std::vector<int> map = simulator.RenderBodies(index);
      for (int i = 0; i < 400; ++i) {
        const int x = i * 37 % 160;
        const int y = i * 53 % 120;
        const int pixel = y * 160 + x;
        const Eigen::Vector3d ray = PointAt(view, x, y, 1.0) - view.t_w_c;
        const double of_body = bodies.CastRay(view.t_w_c, ray).value_or(1e9);
        const double of_world = simulator.world().CastRay(view.t_w_c, ray).value_or(1e9);
        const double nearest = std::min(of_body, of_world);
        const bool same_depth = std::abs((nearest < 1e9 ? nearest : 0.0) - depth[pixel]) < 1e-4 * nearest;
        wrong += same_depth && (map[pixel] >= 0) == (of_body < of_world) ? 0 : 1;
        on_bodies += map[pixel] >= 0 ? 1 : 0;
      }
    }
    // A ray that hits a border to the last bit may fall on either side.
    EXPECT_LE(wrong, 6) << body;
    EXPECT_GT(on_bodies, 30) << body;
  }
}

// A surface point of a body, moved with the body's pose, is visible in the next frame at its projection: with the same
// body, depth and grey.
TEST(Bodies, SurfacesMoveWithTheirPose) {
  for (const char* body : {"lead", "overtake", "cross", "stop", "crowd"}) {
    const Simulator simulator = Make(std::string("street?noise=0&exposure=0&frames=100&bodies=2&body=") + body);
    constexpr int kIndex = 60;
    const View a = simulator.LeftView(kIndex);
    const View b = simulator.LeftView(kIndex + 1);
    const std::vector<float> depth_a = simulator.RenderDepth(kIndex);
    const std::vector<float> depth_b = simulator.RenderDepth(kIndex + 1);
    const std::vector<int> bodies_a = simulator.RenderBodies(kIndex);
    const std::vector<int> bodies_b = simulator.RenderBodies(kIndex + 1);
    const cv::Mat grey_a = simulator.Render(kIndex).left;
    const cv::Mat grey_b = simulator.Render(kIndex + 1).left;
    int seen = 0;
    int agree = 0;
    for (int y = 5; y < a.height - 5; y += 3) {
      for (int x = 5; x < a.width - 5; x += 3) {
        const int pixel = y * a.width + x;
        const int number = bodies_a[pixel];
        if (number < 0) continue;
        const SE3 T =
            *simulator.bodies().T_w_b(number, kIndex + 1) * simulator.bodies().T_w_b(number, kIndex)->Inverse();
        const Eigen::Vector3d p_b = b.R_w_c.transpose() * (T * PointAt(a, x, y, depth_a[pixel]) - b.t_w_c);
        const auto u = static_cast<int>(std::lround(p_b.x() / p_b.z() * b.fx + b.cx));
        const auto v = static_cast<int>(std::lround(p_b.y() / p_b.z() * b.fy + b.cy));
        if (u < 1 || v < 1 || u >= b.width - 1 || v >= b.height - 1) continue;
        const int there = v * b.width + u;
        ++seen;
        const bool same_place = bodies_b[there] == number && std::abs(depth_b[there] / p_b.z() - 1.0) < 0.02;
        agree += same_place && std::abs(grey_a.at<uint8_t>(y, x) - grey_b.at<uint8_t>(v, u)) < 40 ? 1 : 0;
      }
    }
    EXPECT_GT(seen, 100) << body;
    EXPECT_GT(agree, 0.85 * seen) << body << ": " << agree << " of " << seen;
  }
}

TEST(Bodies, LeftAndRightAgreeInDisparity) {
  const Simulator simulator = Make("street?noise=0&exposure=0&frames=60&bodies=1&static_body=0.28");
  const StereoImages pair = simulator.Render(30);
  const std::vector<float> depth = simulator.RenderDepth(30);
  const std::vector<int> map = simulator.RenderBodies(30);
  const double f_b = simulator.LeftView(30).fx * simulator.rig().baseline_m;
  std::vector<int> differences[2];
  for (int y = 2; y < pair.left.rows - 2; y += 2) {
    for (int x = 2; x < pair.left.cols - 2; x += 2) {
      const int pixel = y * pair.left.cols + x;
      const auto u = static_cast<int>(std::lround(x - f_b / depth[pixel]));
      if (map[pixel] < 0 || u < 0) continue;
      differences[map[pixel]].push_back(std::abs(pair.left.at<uint8_t>(y, x) - pair.right.at<uint8_t>(y, u)));
    }
  }
  for (std::vector<int>& of_body : differences) {
    ASSERT_GT(of_body.size(), 1000u);
    const auto most = of_body.begin() + static_cast<int64_t>(of_body.size() * 8 / 10);
    std::nth_element(of_body.begin(), most, of_body.end());
    EXPECT_LT(*most, 12);
  }
}

TEST(Bodies, CoverTheShareOfTheWidth) {
  for (const std::string share : {"0.3", "0.6"}) {
    for (const std::string world : {"street?body=lead", "room?standing=1&body=cross"}) {
      const Simulator simulator = Make(world + "&size=320x200&frames=90&share=" + share);
      std::set<int> most;
      for (int index = 0; index < 90; index += 6) {
        const std::vector<int> map = simulator.RenderBodies(index);
        std::set<int> columns;
        for (int pixel = 0; pixel < static_cast<int>(map.size()); ++pixel) {
          if (map[pixel] >= 0) columns.insert(pixel % 320);
        }
        if (columns.size() > most.size()) most = columns;
      }
      EXPECT_NEAR(static_cast<double>(most.size()) / 320.0, std::stod(share), 0.12) << world << " " << share;
    }
  }
}

TEST(Bodies, LeadingBodyKeepsItsDistance) {
  const Simulator simulator = Make("street?size=160x120&frames=300&bodies=1");
  const double z = (simulator.T_w_c(0).Inverse() * *simulator.bodies().T_w_b(0, 0)).translation().z();
  for (int i = 0; i < 300; i += 10) {
    EXPECT_NEAR((simulator.T_w_c(i).Inverse() * *simulator.bodies().T_w_b(0, i)).translation().z(), z, 0.15 * z);
  }
}

TEST(Bodies, StoppingBodyStandsForTwoSeconds) {
  for (const std::string world : {"street?body=stop", "room?body=stop&standing=1"}) {
    const Simulator simulator = Make(world + "&size=160x120&frames=400");
    int stands = 0;
    int longest = 0;
    int moves = 0;
    for (int i = 1; i < 400; ++i) {
      const auto before = simulator.bodies().T_w_b(0, i - 1);
      const auto now = simulator.bodies().T_w_b(0, i);
      const bool same = before && now && (before->translation() - now->translation()).norm() < 1e-9;
      stands = same ? stands + 1 : 0;
      longest = std::max(longest, stands);
      moves += before && now && !same ? 1 : 0;
    }
    EXPECT_NEAR(longest, 40, 2) << world;
    EXPECT_GT(moves, 200) << world;
  }
}

TEST(Bodies, CrossingBodiesAppearAndDisappear) {
  const Simulator simulator = Make("street?size=160x120&frames=200&body=cross&share=0.4");
  double least = 1.0;
  double most = 0.0;
  for (int i = 0; i < 200; i += 4) {
    const double share = ShareOf(simulator.RenderBodies(i));
    least = std::min(least, share);
    most = std::max(most, share);
  }
  EXPECT_EQ(least, 0.0);
  EXPECT_GT(most, 0.2);
}

TEST(Bodies, StandingCameraSeesTheSameBackground) {
  const Simulator simulator = Make("room?standing=1&bodies=1&share=0.6&noise=0&exposure=0&frames=80");
  const Simulator without = Make("room?standing=1&noise=0&exposure=0&frames=80");
  for (const int index : {0, 60, 79}) {
    EXPECT_EQ(simulator.T_w_c(index).matrix(), simulator.T_w_c(0).matrix());
    const std::vector<int> map = simulator.RenderBodies(index);
    const cv::Mat image = simulator.Render(index).left;
    const cv::Mat still = without.Render(0).left;
    int changed = 0;
    for (int y = 1; y + 1 < image.rows; ++y) {
      for (int x = 1; x + 1 < image.cols; ++x) {
        bool near_body = false;
        for (int k = 0; k < 9; ++k) near_body = near_body || map[(y + k / 3 - 1) * image.cols + x + k % 3 - 1] >= 0;
        changed += !near_body && image.at<uint8_t>(y, x) != still.at<uint8_t>(y, x) ? 1 : 0;
      }
    }
    EXPECT_EQ(changed, 0) << index;
  }
  EXPECT_GT(ShareOf(simulator.RenderBodies(60)), 0.2);
}

TEST(Bodies, BonnetIsFixedInTheCamera) {
  for (const char* world : {"street", "room"}) {
    const Simulator simulator = Make(std::string(world) + "?size=160x120&frames=200&static_body=0.25");
    const std::vector<float> first = simulator.RenderDepth(0);
    for (const int index : {0, 90, 199}) {
      const std::vector<int> map = simulator.RenderBodies(index);
      const std::vector<float> depth = simulator.RenderDepth(index);
      for (int pixel = 0; pixel < 160 * 120; ++pixel) {
        const int y = pixel / 160;
        if (y == 89 || y == 90) continue;  // its far border
        ASSERT_EQ(map[pixel] >= 0, y > 90) << world << " frame " << index << " pixel " << pixel % 160 << ", " << y;
        if (y > 90) {
          ASSERT_NEAR(depth[pixel], first[pixel], 1e-4 * first[pixel]);
        }
      }
    }
  }
}

TEST(Bodies, FramesAreRandomAccessFromSeveralThreads) {
  const std::string description = "street?size=160x120&frames=60&bodies=4&body=crowd&static_body=0.2&blur=0.5";
  const Simulator simulator = Make(description);
  std::vector<std::future<StereoImages>> pairs;
  for (const int index : {40, 3, 40, 20}) {
    pairs.push_back(std::async(std::launch::async, [&simulator, index] { return simulator.Render(index); }));
  }
  std::vector<cv::Mat> images;
  for (auto& pair : pairs) images.push_back(pair.get().right);
  EXPECT_TRUE(SamePixels(images[0], images[2]));
  EXPECT_TRUE(SamePixels(images[0], Make(description).Render(40).right));
  EXPECT_FALSE(SamePixels(images[0], images[1]));
}

}  // namespace
}  // namespace plslam::synthetic
