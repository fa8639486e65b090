// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "core/datasets/synthetic/exact_math.h"
#include "core/datasets/synthetic/motion.h"
#include "core/datasets/synthetic/options.h"
#include "core/datasets/synthetic/world.h"
#include "core/geometry/se3.h"

namespace plslam::synthetic {

/// The camera for which bodies are made: its path, and its view.
struct Stage {
  const Motion* motion = nullptr;  ///< outlives the bodies
  double frames = 0.0;
  double rate_hz = 0.0;
  Eigen::Vector3d up_w = Eigen::Vector3d::UnitZ();
  double width_px = 0.0;
  double height_px = 0.0;
  double f_px = 0.0;
  double baseline_m = 0.0;
};

/// Textured boxes that move through a world on their own paths, and the bonnet that moves with the camera. Their poses
/// depend on the options and the time only.
///
/// A body moves in the level frame v that the camera's path makes when it is smoothed over 1.4 s: x right, y down, z
/// ahead.
class Bodies {
 public:
  Bodies() = default;
  /// Adds the textures to the world.
  Bodies(const Options& options, const Stage& stage, World* world);

  /// The boxes come first, and the bonnet last if there is one.
  int size() const { return static_cast<int>(boxes_.size()) + (hood_.empty() ? 0 : 1); }
  /// Pose of a body: of the centre of the box, or of the camera that carries the bonnet; nullopt while it is absent.
  std::optional<SE3> T_w_b(int body, double frame) const;
  /// The quads at a frame (fractional frames exist for motion blur), and the body of each quad.
  struct Surfaces {
    std::vector<Quad> quads;
    std::vector<int> body;
  };
  Surfaces At(double frame) const;

 private:
  /// A point in the frame v of a time of the path, which may be another than the one at which the body is there.
  struct Place {
    double t_s = 0.0;
    Eigen::Vector3d p_v;
  };
  using Path = std::function<std::optional<Place>(double t_s)>;
  struct Box {
    std::vector<Quad> quads_b;
    Path path;
  };
  struct Plan;

  /// Ahead, as fast as the camera, with a small relative motion; several side by side, each farther than the last.
  Plan Lead(int i);
  /// A lorry that overtakes 2 to 3 m to the left and then turns in ahead.
  Plan Overtake(int i);
  /// From right to left at one depth, wholly out of view before and afterwards.
  Plan Cross(int i);
  /// With a moving camera: drives ahead, stops for 2 s while the camera approaches, and drives on. With a static
  /// camera: crosses, and stops half way.
  Plan Stop(int i);
  /// Small bodies that walk to the left and to the right, each at its own depth and speed.
  Plan Crowd(int i);
  double WidthAt(double depth_m) const { return stage_.width_px * depth_m / stage_.f_px; }
  double HeightAt(double depth_m) const { return stage_.height_px * depth_m / stage_.f_px; }
  /// Returns the largest distance that the camera moves in so many seconds, anywhere on its path.
  double FarthestWithin(double seconds) const;
  void MakeHood(double share, const std::vector<int>& textures, const World& world);
  SE3 T_w_v(double t_s) const;

  Stage stage_;
  int n_ = 0;
  double share_ = 0.0;
  double depth_m_ = 0.0;
  bool stands_ = false;
  Random random_{0};
  std::vector<Box> boxes_;
  std::vector<Quad> hood_;  ///< in the frame of the left camera
};

}  // namespace plslam::synthetic
