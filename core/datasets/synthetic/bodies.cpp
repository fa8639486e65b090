// SPDX-License-Identifier: BSD-3-Clause
#include "core/datasets/synthetic/bodies.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/datasets/synthetic/materials.h"

namespace plslam::synthetic {

struct Bodies::Plan {
  Eigen::Vector3d size_m;
  Path path;
};

namespace {

constexpr double kAheadDisparity = 0.045;  // of a vehicle ahead, of the width of the image
constexpr double kAheadDepth_m = 7.0;      // the depth for which sizes in metres are given; other depths scale them
constexpr double kSmoothing_s = 0.7;       // to both sides
constexpr int kSmoothingSteps = 4;
constexpr double kHoodDisparity = 0.1;  // at its far border, of the width of the image
constexpr int kHoodTiles = 4;           // side by side, of one texture each
constexpr int kTextures = 8;

// A body that stops does so in the middle of a period.
constexpr double kStopPeriod_s = 8.0;
constexpr double kStopFrom_s = 3.0;
constexpr double kStopTo_s = 5.0;
constexpr double kStopRamp_s = 0.4;

/// Returns the time by which a stopping body has moved along its path: the real time at the end of each period,
/// constant during the stop.
double StoppingTime(double t_s) {
  const double period = std::floor(t_s / kStopPeriod_s);
  const double s = t_s - period * kStopPeriod_s;
  const double driven = kStopFrom_s - 0.5 * kStopRamp_s;  // at full speed, before the stop, and after it again
  const double speed = 0.5 * kStopPeriod_s / driven;
  // The way of a speed that falls from 1 to 0 over x in [0, 1] as 1 - Smoothstep(x) does.
  const auto braking = [](double x) { return x - x * x * x + 0.5 * x * x * x * x; };
  double way = 0.0;
  if (s < kStopFrom_s - kStopRamp_s) {
    way = s;
  } else if (s < kStopFrom_s) {
    way = kStopFrom_s - kStopRamp_s + kStopRamp_s * braking((s - kStopFrom_s + kStopRamp_s) / kStopRamp_s);
  } else if (s <= kStopTo_s) {
    way = driven;
  } else if (s < kStopTo_s + kStopRamp_s) {
    way = driven + kStopRamp_s * (0.5 - braking((kStopTo_s + kStopRamp_s - s) / kStopRamp_s));
  } else {
    way = driven + s - kStopTo_s - 0.5 * kStopRamp_s;
  }
  return period * kStopPeriod_s + speed * way;
}

/// Returns the progress, from 0 to 1, of a motion that takes a body `duration_s` and repeats every `period_s`; nullopt
/// in the pauses, and before its first begin.
std::optional<double> Progress(double t_s, double begin_s, double period_s, double duration_s) {
  const double since_s = t_s - begin_s;
  if (since_s < 0.0) {
    return std::nullopt;
  }
  const double share = (since_s - period_s * std::floor(since_s / period_s)) / duration_s;
  return share < 1.0 ? std::optional<double>(share) : std::nullopt;
}

Quad Panel(const Eigen::Vector3d& origin, const Eigen::Vector3d& s, const Eigen::Vector3d& t, int texture,
           float light, const World& world) {
  Quad quad;
  quad.origin = origin;
  quad.edge_s = s;
  quad.edge_t = t;
  quad.texture = texture;
  quad.texels_s = world.textures()[texture].width();
  quad.texels_t = world.textures()[texture].height();
  quad.light = {light, light, light, light};
  return quad;
}

/// The four sides and the roof of a box about the origin, x right, y down, z ahead. Each has `panels` x `panels`
/// pictures, which follow one another in `paints` from `first`.
std::vector<Quad> MakeBox(const Eigen::Vector3d& size_m, int panels, const std::vector<int>& paints, int first,
                          const World& world) {
  const Eigen::Vector3d x(size_m.x(), 0.0, 0.0);
  const Eigen::Vector3d y(0.0, size_m.y(), 0.0);
  const Eigen::Vector3d z(0.0, 0.0, size_m.z());
  const Eigen::Vector3d o = -0.5 * size_m;
  std::vector<Quad> quads;
  const auto add = [&](const Eigen::Vector3d& origin, const Eigen::Vector3d& s, const Eigen::Vector3d& t,
                       float light) {
    for (int i = 0; i < panels * panels; ++i) {
      const Eigen::Vector3d corner = origin + (i % panels) * s / panels + (i / panels) * t / panels;
      const int paint = paints[(first + static_cast<int>(quads.size())) % static_cast<int>(paints.size())];
      quads.push_back(Panel(corner, s / panels, t / panels, paint, light, world));
    }
  };
  add(o, x, y, 0.95F);
  add(o + z, -z, y, 0.85F);
  add(o + x, z, y, 0.8F);
  add(o + x + z, -x, y, 0.95F);
  add(o + z, x, -z, 1.0F);
  return quads;
}

Quad Moved(const SE3& T_a_b, Quad quad) {
  const Eigen::Matrix3d R = T_a_b.R();
  quad.origin = R * quad.origin + T_a_b.translation();
  quad.edge_s = R * quad.edge_s;
  quad.edge_t = R * quad.edge_t;
  return quad;
}

}  // namespace

Bodies::Bodies(const Options& options, const Stage& stage, World* world)
    : stage_(stage),
      n_(options.bodies),
      share_(options.share),
      depth_m_(stage.f_px * stage.baseline_m / (kAheadDisparity * stage.width_px)),
      stands_(options.standing),
      random_(Hash(options.seed, 0x626f6479ULL)) {
  if (n_ == 0 && options.static_body == 0.0) return;
  std::vector<int> paints;
  for (uint64_t i = 0; i < kTextures; ++i) {
    const uint64_t seed = Hash(options.seed, 0x7061696e74ULL, i);
    paints.push_back(world->AddTexture(i % 4 == 3 ? PaintFacade(seed, 6, 3) : PaintPoster(seed)));
  }
  constexpr std::pair<BodyMotion, Plan (Bodies::*)(int)> kPlans[] = {{BodyMotion::kLead, &Bodies::Lead},
                                                                     {BodyMotion::kOvertake, &Bodies::Overtake},
                                                                     {BodyMotion::kCross, &Bodies::Cross},
                                                                     {BodyMotion::kStop, &Bodies::Stop},
                                                                     {BodyMotion::kCrowd, &Bodies::Crowd}};
  const auto* row = std::find_if(std::begin(kPlans), std::end(kPlans),
                                 [&](const auto& plan) { return plan.first == options.body; });
  for (int i = 0; i < n_; ++i) {
    const Plan plan = (this->*row->second)(i);
    const int panels = options.body == BodyMotion::kCrowd ? 1 : 2;
    boxes_.push_back({MakeBox(plan.size_m, panels, paints, i, *world), plan.path});
  }
  if (options.static_body > 0.0) MakeHood(options.static_body, paints, *world);
}

SE3 Bodies::T_w_v(double t_s) const {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  Eigen::Vector3d ahead = Eigen::Vector3d::Zero();
  for (int k = -kSmoothingSteps; k <= kSmoothingSteps; ++k) {
    const SE3 T_w_c = stage_.motion->At((t_s + k * kSmoothing_s / kSmoothingSteps) * stage_.rate_hz);
    position += T_w_c.translation();
    ahead += T_w_c.R().col(2);
  }
  position /= 2 * kSmoothingSteps + 1;
  ahead -= ahead.dot(stage_.up_w) * stage_.up_w;
  // A camera that looks straight up or down has no direction ahead: any level one serves.
  if (ahead.squaredNorm() < 1e-6) ahead = {stage_.up_w.y(), stage_.up_w.z(), stage_.up_w.x()};
  Eigen::Matrix3d R;
  R.col(1) = -stage_.up_w;
  R.col(0) = R.col(1).cross(ahead);
  R.col(0) /= std::sqrt(R.col(0).squaredNorm());
  R.col(2) = R.col(0).cross(R.col(1));
  return {R, position};
}

std::optional<SE3> Bodies::T_w_b(int body, double frame) const {
  if (body == static_cast<int>(boxes_.size())) return stage_.motion->At(frame);
  const std::optional<Place> place = boxes_[body].path(frame / stage_.rate_hz);
  if (!place) return std::nullopt;
  return T_w_v(place->t_s) * SE3(Eigen::Quaterniond::Identity(), place->p_v);
}

Bodies::Surfaces Bodies::At(double frame) const {
  Surfaces surfaces;
  for (int i = 0; i < size(); ++i) {
    const std::optional<SE3> T = T_w_b(i, frame);
    if (!T) continue;
    for (const Quad& quad : i < static_cast<int>(boxes_.size()) ? boxes_[i].quads_b : hood_) {
      surfaces.quads.push_back(Moved(*T, quad));
      surfaces.body.push_back(i);
    }
  }
  return surfaces;
}

double Bodies::FarthestWithin(double seconds) const {
  double farthest2 = 0.0;
  const double step = 0.25 * seconds * stage_.rate_hz;
  for (double frame = 0.0; frame < stage_.frames; frame += step) {
    const Eigen::Vector3d way =
        stage_.motion->At(frame + 4.0 * step).translation() - stage_.motion->At(frame).translation();
    farthest2 = std::max(farthest2, way.squaredNorm());
  }
  return std::sqrt(farthest2);
}

Bodies::Plan Bodies::Lead(int i) {
  const double z = depth_m_ * (1.0 + 0.2 * i);
  const double width = share_ * WidthAt(z);
  const Eigen::Vector3d size(width, 0.7 * HeightAt(z), 1.5 * width);
  const double x = 1.1 * width * (i - 0.5 * (n_ - 1)) + random_.Uniform(-0.05, 0.05) * WidthAt(z);
  const double phase = random_.Uniform(0.0, 6.0);
  const double frequency = random_.Uniform(0.9, 1.5);  // rad/s
  return {size, [=](double t_s) {
            const Eigen::Vector3d own(0.01 * Sin(frequency * t_s + phase), 0.002 * Sin(2.3 * frequency * t_s),
                                      0.02 * Sin(0.8 * frequency * t_s + 2.0 * phase));
            return Place{t_s, Eigen::Vector3d(x, 0.0, z + 0.5 * size.z()) + z * own};
          }};
}

Bodies::Plan Bodies::Overtake(int i) {
  constexpr double kPeriod_s = 9.0;
  const double unit = depth_m_ / kAheadDepth_m;
  const Eigen::Vector3d size = unit * Eigen::Vector3d(2.5, 3.0, 9.0);
  const double x = unit * random_.Uniform(2.0, 3.0) + 0.5 * size.x();
  const double begin_s = random_.Uniform(0.0, 1.0) + i * kPeriod_s / n_;
  return {size, [=](double t_s) -> std::optional<Place> {
            const std::optional<double> progress = Progress(t_s, begin_s, kPeriod_s, 7.0);
            if (!progress) return std::nullopt;
            const double z = -7.0 + 47.0 * *progress;
            return Place{t_s, {-x * (1.0 - 0.8 * Smoothstep((z - 8.0) / 12.0)), 0.0, unit * z}};
          }};
}

Bodies::Plan Bodies::Cross(int i) {
  constexpr double kPeriod_s = 6.0;
  const double z = 1.2 * depth_m_ * (1.0 + 0.15 * i);
  const Eigen::Vector3d size(share_ * WidthAt(z), 0.7 * HeightAt(z), 0.4 * depth_m_);
  const double way = (1.3 + share_) * WidthAt(z) + size.z();
  const double begin_s = random_.Uniform(0.8, 1.5) + i * kPeriod_s / n_;
  return {size, [=](double t_s) -> std::optional<Place> {
            const std::optional<double> progress = Progress(t_s, begin_s, kPeriod_s, 4.0);
            if (!progress) return std::nullopt;
            return Place{t_s, {(0.5 - *progress) * way, 0.0, z + 0.5 * size.z()}};
          }};
}

Bodies::Plan Bodies::Stop(int i) {
  const double z = 1.2 * depth_m_ * (1.0 + 0.15 * i);
  const Eigen::Vector3d size(share_ * WidthAt(z), 0.7 * HeightAt(z), 0.4 * depth_m_);
  const double begin_s = random_.Uniform(0.0, 1.0) + i * kStopPeriod_s / n_;
  if (stands_) {
    const double way = (1.3 + share_) * WidthAt(z) + size.z();
    return {size, [=](double t_s) -> std::optional<Place> {
              if (t_s < begin_s) return std::nullopt;
              const double t_b_s = StoppingTime(t_s - begin_s);
              const double progress = t_b_s / kStopPeriod_s - std::floor(t_b_s / kStopPeriod_s);
              return Place{0.0, {(0.5 - progress) * way, 0.0, z + 0.5 * size.z()}};
            }};
  }
  const double x = size.x() * (i - 0.5 * (n_ - 1)) + random_.Uniform(-0.1, 0.1) * WidthAt(z);
  const double ahead = z + 0.5 * size.z() + FarthestWithin(kStopTo_s - kStopFrom_s);
  return {size, [=](double t_s) { return Place{begin_s + StoppingTime(t_s - begin_s), {x, 0.0, ahead}}; }};
}

Bodies::Plan Bodies::Crowd(int i) {
  const double z = depth_m_ * random_.Uniform(0.8, 2.4);
  const double width = 1.6 * share_ * WidthAt(z) / n_ * random_.Uniform(0.7, 1.3);
  const Eigen::Vector3d size(width, std::min(2.6 * width, 0.7 * HeightAt(z)), 0.6 * width);
  const double way = 1.2 * WidthAt(z) + 2.0 * width;
  const double period_s = random_.Uniform(3.0, 9.0);
  const double start = random_.Uniform();
  const double side = i % 2 == 0 ? 1.0 : -1.0;
  const double y = random_.Uniform(-0.15, 0.25) * HeightAt(z);
  const double step = random_.Uniform(6.0, 10.0);  // rad/s
  return {size, [=](double t_s) {
            const double progress = start + t_s / period_s;
            const double x = side * (0.5 - (progress - std::floor(progress))) * way;
            return Place{t_s, {x, y + 0.01 * z * Sin(step * t_s), z}};
          }};
}

void Bodies::MakeHood(double share, const std::vector<int>& textures, const World& world) {
  const double far_m = stage_.f_px * stage_.baseline_m / (kHoodDisparity * stage_.width_px);
  const double near_m = 0.7 * far_m;
  const double far_y = (0.5 - share) * HeightAt(far_m);
  // Wider and longer than the image, which lenses with distortion show more of.
  const double near_y = 0.7 * HeightAt(near_m);
  const double tile_m = 1.6 * WidthAt(far_m) / kHoodTiles;
  for (int i = 0; i < kHoodTiles; ++i) {
    const Eigen::Vector3d corner((i - 0.5 * kHoodTiles) * tile_m, far_y, far_m);
    hood_.push_back(
        Panel(corner, {tile_m, 0.0, 0.0}, {0.0, near_y - far_y, near_m - far_m}, textures[i], 0.8F, world));
  }
}

}  // namespace plslam::synthetic
