// SPDX-License-Identifier: BSD-3-Clause
#include "core/datasets/synthetic/simulator.h"

#include <algorithm>
#include <cmath>
#include <future>

#include "core/datasets/dataset.h"
#include "core/datasets/synthetic/exact_math.h"
#include "core/datasets/synthetic/inertial_sensor.h"
#include "core/datasets/synthetic/sensor_faults.h"
#include "core/datasets/synthetic/worlds.h"

namespace plslam::synthetic {
namespace {

// A blurred image is the average of so many images that edges at this depth move by this step from one to the next.
constexpr double kBlurStep_px = 1.5;
constexpr double kBlurDepth_m = 2.0;
constexpr int kMinBlurSteps = 5;
constexpr int kMaxBlurSteps = 65;
constexpr double kExposureSwing = 0.2;

/// The frame with z upwards from the frame of a trajectory file: cameras are upright in the mean, so the signed axis
/// nearest to their mean upward direction is the vertical. Permutes axes, hence exact.
Eigen::Matrix3d UprightFromFile(const std::vector<SE3>& poses) {
  Eigen::Vector3d up = Eigen::Vector3d::Zero();
  for (const SE3& pose : poses) {
    up -= pose.R().col(1);
  }
  int axis = 0;
  const int largest = static_cast<int>(up.cwiseAbs().maxCoeff(&axis) > 0.0 ? axis : 2);
  const double sign = up[largest] < 0.0 ? -1.0 : 1.0;
  Eigen::Matrix3d R = Eigen::Matrix3d::Zero();
  R(2, largest) = sign;
  R(0, (largest + 1) % 3) = 1.0;
  R(1, (largest + 2) % 3) = sign;
  return R;
}

std::vector<int64_t> RegularTimes(int count, double rate_hz) {
  std::vector<int64_t> times;
  times.reserve(count);
  for (int i = 0; i < count; ++i) {
    times.push_back(static_cast<int64_t>(std::floor(i * (1e9 / rate_hz) + 0.5)));
  }
  return times;
}

Options WithDefaults(Options options) {
  const WorldKind& kind = FindWorldKind(options.world);
  options.baseline_m = options.baseline_m == 0.0 ? kind.baseline_m : options.baseline_m;
  options.fov_deg = options.fov_deg == 0.0 ? kind.fov_deg : options.fov_deg;
  return options;
}

}  // namespace

Simulator::Simulator(const Options& options)
    : options_(WithDefaults(options)),
      weather_(options.width_px, options.height_px, options.streaks, options.dirt, options.seed),
      sensor_(options.width_px, options.height_px, options.noise, options.seed) {
  MakeMotion();
  MakeEyes();
  MakeBodies();
  MakeInertialSensor();
}

void Simulator::MakeMotion() {
  const WorldKind& kind = FindWorldKind(options_.world);
  WorldRequest request{options_.seed, {}, !options_.trajectory.empty()};
  if (!request.from_file) {
    const Walk walk = kind.walk();
    auto motion = std::make_unique<WalkMotion>(walk, options_.speed == 0.0 ? walk.speed : options_.speed,
                                               options_.rate_hz, options_.seed);
    frames_per_lap_ = motion->frames_per_lap();
    for (int i = 0; i < 512; ++i) {
      request.path.push_back(motion->At(frames_per_lap_ * (i / 512.0)).translation());
    }
    const int frames = options_.frames == 0 ? options_.loops * frames_per_lap_ + 1 : options_.frames;
    t_ns_ = RegularTimes(frames, options_.rate_hz);
    motion_ = std::move(motion);
    world_ = kind.build(request);
    if (options_.changed_after > 0) {
      request.is_changed = true;
      changed_world_ = kind.build(request);
    }
    return;
  }
  FilePoses file = ReadPoses(options_.trajectory);
  const int poses = static_cast<int>(file.T_w_c.size());
  if (options_.frames > poses) {
    throw DatasetError(options_.trajectory + ": holds " + std::to_string(poses) +
                       " poses, but frames=" + std::to_string(options_.frames) + " are wanted");
  }
  const Eigen::Matrix3d R_up_file = UprightFromFile(file.T_w_c);
  for (const SE3& pose : file.T_w_c) {
    request.path.emplace_back(R_up_file * pose.translation());
  }
  world_ = kind.build(request);
  world_.Move(SE3(Eigen::Matrix3d(R_up_file.transpose()), Eigen::Vector3d::Zero()));
  t_ns_ = file.t_ns.empty() ? RegularTimes(poses, options_.rate_hz) : file.t_ns;
  t_ns_.resize(options_.frames == 0 ? poses : options_.frames);
  motion_ = std::make_unique<ListedMotion>(std::move(file.T_w_c));
}

const World& Simulator::WorldAt(double frame) const {
  const bool is_changed = options_.changed_after > 0 && frame >= options_.changed_after * frames_per_lap_;
  return is_changed ? changed_world_ : world_;
}

void Simulator::MakeBodies() {
  if (options_.standing) {
    motion_ = std::make_unique<ListedMotion>(std::vector<SE3>{motion_->At(0.0)});
  }
  if (options_.turning_deg_s != 0.0) {
    const double rad = options_.turning_deg_s * kPi / 180.0 / options_.rate_hz;
    motion_ = std::make_unique<TurningMotion>(motion_->At(0.0), rad * world_.up());
  }
  const Lens::Intrinsics& lens = left_.lens.recorded();
  const Stage stage{motion_.get(),
                    static_cast<double>(size()),
                    options_.rate_hz,
                    world_.up(),
                    static_cast<double>(lens.width),
                    static_cast<double>(lens.height),
                    lens.fx,
                    rig_.baseline_m};
  bodies_ = Bodies(options_, stage, &world_);
}

void Simulator::MakeInertialSensor() {
  if (options_.imu_rate_hz == 0.0) return;
  const auto& classes = SensorClasses();
  const auto sensor = std::find_if(classes.begin(), classes.end(),
                                   [this](const SensorClass& c) { return c.name == options_.imu_class; });
  const double end_s = static_cast<double>(t_ns_.back()) * 1e-9;
  imu_samples_ = SampleMotion({motion_.get(), options_.rate_hz, end_s, world_.up()}, options_.imu_rate_hz, *sensor,
                              options_.seed);
  rig_.imu = ImuCalibration{MountedSensor(), sensor->noise, 0.0, options_.imu_rate_hz};
  if (const SensorFault* fault = FindSensorFault(options_.imu_fault)) {
    fault->apply(options_.imu_fault_size, options_.seed, imu_samples_, *rig_.imu);
  }
}

void Simulator::MakeEyes() {
  const double f = 0.5 * options_.width_px / Tan(0.5 * options_.fov_deg * kPi / 180.0);
  const Lens::Intrinsics ideal{
      f, f, 0.5 * (options_.width_px - 1), 0.5 * (options_.height_px - 1), options_.width_px, options_.height_px};
  left_.lens = Lens(ideal);
  right_.lens = Lens(ideal);
  right_.t_l_cam = Eigen::Vector3d(options_.baseline_m, 0.0, 0.0);
  if (options_.distorted) {
    const double shift = 0.01 * options_.width_px;
    const Lens::Intrinsics left{f, 1.003 * f, ideal.cx + shift, ideal.cy - 0.6 * shift, ideal.width, ideal.height};
    const Lens::Intrinsics right{0.995 * f,        0.998 * f,   ideal.cx - 0.7 * shift,
                                 ideal.cy + shift, ideal.width, ideal.height};
    left_.lens = Lens(left, {-0.20, 0.05, 0.0004, -0.0003});
    right_.lens = Lens(right, {-0.19, 0.045, -0.0003, 0.0005});
    const Eigen::Quaterniond q(1.0, 0.006, -0.008, 0.005);
    right_.R_l_cam = q.normalized().toRotationMatrix();
    right_.t_l_cam = options_.baseline_m * Eigen::Vector3d(1.0, 0.012, -0.009);
  }
  if (options_.distorted && !DisparityBias(options_.disparity_bias_px, options_.width_px).is_zero()) {
    throw DatasetError("synthetic: options disparity_bias and distorted=1 exclude each other");
  }
  rig_.name = options_.world;
  rig_.rate_hz = options_.rate_hz;
  rig_.left = Calibration(left_);
  rig_.right = Calibration(right_);
  rig_.baseline_m = right_.t_l_cam.norm();
}

CameraCalibration Simulator::Calibration(const Eye& eye) const {
  const Lens::Intrinsics& lens = eye.lens.recorded();
  CameraCalibration camera;
  camera.width_px = lens.width;
  camera.height_px = lens.height;
  camera.fx_px = lens.fx;
  camera.fy_px = lens.fy;
  camera.cx_px = lens.cx;
  camera.cy_px = lens.cy;
  if (eye.lens.is_distorted()) {
    camera.model = lens_model::kRadtan;
    camera.distortion.assign(eye.lens.distortion().begin(), eye.lens.distortion().end());
  }
  camera.T_b_cam = SE3(eye.R_l_cam, eye.t_l_cam);
  if (options_.readout_known) camera.readout_ms = options_.readout_ms;
  return camera;
}

View Simulator::ViewOf(const Eye& eye, const SE3& T_w_c) const {
  const Lens::Intrinsics& lens = eye.lens.ideal();
  View view{lens.width, lens.height, lens.fx, lens.fy, lens.cx, lens.cy};
  const Eigen::Matrix3d R_w_c = T_w_c.R();
  view.R_w_c = R_w_c * eye.R_l_cam;
  view.t_w_c = T_w_c.translation() + R_w_c * eye.t_l_cam;
  return view;
}

View Simulator::LeftView(int index) const {
  Eye eye = left_;
  eye.lens = Lens(left_.lens.recorded());
  return ViewOf(eye, T_w_c(index));
}

std::vector<int> Simulator::RenderBodies(int index) const {
  Bodies::Surfaces moved = bodies_.At(index);
  const int still = static_cast<int>(world_.quads().size());
  std::vector<int> map = RenderQuadMap({world_, std::move(moved.quads)}, LeftView(index));
  std::transform(map.begin(), map.end(), map.begin(),
                 [&](int quad) { return quad < still ? -1 : moved.body[quad - still]; });
  return map;
}

double Simulator::Gain(int index) const {
  const double t_s = static_cast<double>(t_ns_[index] - t_ns_[0]) * 1e-9;
  const double wave = 0.6 * Sin(2.0 * kPi * t_s / 7.3) + 0.4 * Sin(2.0 * kPi * t_s / 2.9 + 1.0);
  return 1.0 + kExposureSwing * options_.exposure * wave;
}

int Simulator::BlurSteps(const Eye& eye, double frame) const {
  const SE3 opens = motion_->At(frame - 0.5 * options_.blur);
  const SE3 closes = motion_->At(frame + 0.5 * options_.blur);
  // The chord of the rotation; of angles as small it is their length.
  const double turn_rad = (closes.R() - opens.R()).norm() / std::sqrt(2.0);
  const double path_m = (closes.translation() - opens.translation()).norm();
  const double moved_px = eye.lens.ideal().fx * (turn_rad + path_m / kBlurDepth_m);
  return std::clamp(static_cast<int>(std::ceil(moved_px / kBlurStep_px)), kMinBlurSteps, kMaxBlurSteps);
}

std::vector<float> Simulator::RadianceAt(const Eye& eye, double frame) const {
  if (options_.readout_ms == 0.0) {
    return RenderRadiance(SceneAt(frame), ViewOf(eye, motion_->At(frame)));
  }
  const double readout = 1e-3 * options_.readout_ms * options_.rate_hz;
  return RenderRollingShutter(SceneAt(frame),
                              [&](double share) { return ViewOf(eye, motion_->At(frame + share * readout)); });
}

std::vector<float> Simulator::Radiance(const Eye& eye, double frame) const {
  if (options_.blur == 0.0) {
    return RadianceAt(eye, frame);
  }
  const int steps = BlurSteps(eye, frame);
  const float share = 1.0F / static_cast<float>(steps);
  std::vector<float> sum;
  for (int step = 0; step < steps; ++step) {
    const double shutter = options_.blur * ((step + 0.5) / steps - 0.5);
    const std::vector<float> part = RadianceAt(eye, frame + shutter);
    sum.resize(part.size(), 0.0F);
    std::transform(sum.begin(), sum.end(), part.begin(), sum.begin(),
                   [share](float a, float b) { return a + b * share; });
  }
  return sum;
}

cv::Mat Simulator::RenderEye(const Eye& eye, int index, int camera) const {
  const double late = camera == 1 ? 1e-3 * options_.right_late_ms * options_.rate_hz : 0.0;
  std::vector<float> radiance = Radiance(eye, index + late);
  if (eye.lens.is_distorted()) {
    radiance = eye.lens.Apply(radiance);
  }
  const DisparityBias bias(options_.disparity_bias_px, options_.width_px);
  if (camera == 1 && !bias.is_zero()) {
    const View view = ViewOf(eye, motion_->At(index));
    radiance = bias.Apply(radiance, RenderDepthMap(SceneAt(index), view), view.fx * options_.baseline_m);
  }
  weather_.Apply(index, camera, radiance);
  return sensor_.Expose(radiance, Gain(index), static_cast<uint64_t>(index) * 2 + camera);
}

StereoImages Simulator::Render(int index) const {
  auto right = std::async(std::launch::async, [this, index] { return RenderEye(right_, index, 1); });
  StereoImages images;
  images.frame_id = index;
  images.t_ns = t_ns_[index];
  images.left = RenderEye(left_, index, 0);
  images.right = right.get();
  return images;
}

}  // namespace plslam::synthetic

namespace plslam {
namespace {

class SyntheticDataset : public Dataset {
 public:
  explicit SyntheticDataset(const std::string& description)
      : name_("synthetic:" + description), simulator_(synthetic::ParseOptions(description)) {}

  std::string name() const override { return name_; }
  const RigCalibration& rig() const override { return simulator_.rig(); }
  int size() const override { return simulator_.size(); }
  int64_t t_ns(int index) const override { return simulator_.t_ns(index); }
  StereoImages Read(int index) const override { return simulator_.Render(index); }
  const std::vector<ImuSample>& ImuSamples() const override { return simulator_.imu_samples(); }
  std::optional<SE3> GroundTruth(int index) const override { return simulator_.T_w_c(index); }

 private:
  std::string name_;
  synthetic::Simulator simulator_;
};

}  // namespace

std::unique_ptr<Dataset> OpenSyntheticDataset(const std::string& description) {
  return std::make_unique<SyntheticDataset>(description);
}

}  // namespace plslam
