// SPDX-License-Identifier: BSD-3-Clause
#include "core/robot/node/imu_input.h"

#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <utility>
#include <vector>

#include "core/bus/messages/imu_channel.h"
#include "core/bus/run_loop.h"
#include "core/datasets/imu_files.h"
#include "core/errors/log.h"
#include "core/files/dataset_error.h"

namespace plslam::robot {
namespace {

// Longest time after which late samples are still sent: trackers wait no longer for them.
constexpr uint64_t kLongestOpen_ns = 1'000'000'000;

}  // namespace

ImuInput::ImuInput(bus::Process& process, Settings settings) : process_(process), settings_(std::move(settings)) {
  if (!settings_.calibration.empty()) ReadFile();
}

/// An invalid file ends the process when it starts.
void ImuInput::ReadFile() {
  const std::string& file = settings_.calibration;
  if (!std::filesystem::exists(file)) {
    throw DatasetError(fmt::format("{}_calibration = {}: there is no such file", settings_.option, file));
  }
  Notes notes;
  file_has_pose_ = FindImuCalibration(settings_.name, {}, {.files = {file}}, &notes).has_value();
}

void ImuInput::Add(const ImuSample& sample) {
  queue_.Add(sample);
  added_s_ = bus::NowS();
}

void ImuInput::AddRate(int64_t t_ns, const Eigen::Vector3d& rate_rad_s) {
  queue_.AddRate(t_ns, rate_rad_s);
  added_s_ = bus::NowS();
}

void ImuInput::AddForce(int64_t t_ns, const Eigen::Vector3d& force_m_s2) {
  queue_.AddForce(t_ns, force_m_s2);
  added_s_ = bus::NowS();
}

/// Rigs of CameraInfo come with every image: the file is read again only if the left camera has moved.
void ImuInput::AddTo(RigCalibration& rig) {
  rig.imu.reset();
  if (settings_.name.empty()) return;
  if (calibration_ && T_b_l_.matrix() == rig.left.T_b_cam.matrix()) {
    rig.imu = *calibration_;
    return;
  }
  const bool is_first = !calibration_;
  const bool was_unused = calibration_ && !*calibration_;
  Notes notes;
  rig.imu = FindImuCalibration(
      settings_.name, rig, {{settings_.calibration, settings_.camera}, T_c_imu_, !settings_.camera.empty()}, &notes);
  calibration_ = rig.imu;
  T_b_l_ = rig.left.T_b_cam;
  if (was_unused && rig.imu) LogInfo("{}: the pose of the inertial sensor is known: it is used", settings_.name);
  if (!is_first) return;
  for (const std::string& warning : notes.warnings) LogWarning("{}", warning);
  for (const std::string& remark : notes.remarks) LogInfo("{}", remark);
  if (rig.imu) return;
  process_.Warn("imu_uncalibrated",
                fmt::format("{}: the inertial sensor is not used, because its pose is not known: write T_c_imu "
                            "(docs/imu.md) to a file, and give {}_calibration=FILE",
                            settings_.name, settings_.option));
}

bool ImuInput::Awaits(const RigCalibration& rig, int64_t t_ns) const {
  constexpr double kSilence_s = 0.5;
  if (!rig.imu || bus::NowS() - added_s_ > kSilence_s) return false;
  return !queue_.Covers(t_ns - rig.imu->offset_ns());
}

void ImuInput::Publish(const RigCalibration& rig, int64_t t_ns) {
  // After a clock was set back, this frame is the first one of its time.
  const int64_t from_ns = sent_t_ns_ && *sent_t_ns_ < t_ns ? *sent_t_ns_ : t_ns;
  sent_t_ns_ = t_ns;
  if (!rig.imu) return;
  const int64_t offset_ns = rig.imu->offset_ns();
  const bool has_end = queue_.Covers(t_ns - offset_ns);
  if (from_ns == t_ns) open_t_ns_.clear();
  const auto is_over = [&](int64_t frame_ns) {
    return static_cast<uint64_t>(t_ns) - static_cast<uint64_t>(frame_ns) > kLongestOpen_ns;
  };
  while (!open_t_ns_.empty() && is_over(open_t_ns_.front())) open_t_ns_.pop_front();
  const int64_t begin_ns = open_t_ns_.empty() ? from_ns : open_t_ns_.front();
  const std::vector<ImuSample> samples = queue_.Take(begin_ns - offset_ns, t_ns - offset_ns);
  bus::PublishImu(process_.bus(), begin_ns, t_ns, samples);
  open_t_ns_.push_back(t_ns);
  const auto is_sent = [&](int64_t frame_ns) {
    return !samples.empty() && samples.back().t_ns >= frame_ns - offset_ns;
  };
  while (open_t_ns_.size() > 1 && is_sent(open_t_ns_[1])) open_t_ns_.pop_front();
  Report(t_ns, has_end && (samples.size() > 1 || from_ns == t_ns));
}

void ImuInput::Report(int64_t t_ns, bool is_complete) {
  n_in_a_row_ = is_complete ? 0 : n_in_a_row_ + 1;
  n_incomplete_ += !is_complete;
  const ImuQueue::Counts counts = queue_.counts();
  process_.SetCounter("imu.samples", static_cast<double>(counts.n));
  process_.SetCounter("imu.late", static_cast<double>(counts.n_late));
  process_.SetCounter("imu.repeated", static_cast<double>(counts.n_repeated));
  process_.SetCounter("imu.incomplete", static_cast<double>(n_incomplete_));
  // Sensors may start later than cameras.
  constexpr int64_t kFramesWithoutImu = 20;
  if (n_in_a_row_ < kFramesWithoutImu || std::exchange(has_warned_, true)) return;
  process_.Warn("imu_missing", WarningText(t_ns));
}

std::string ImuInput::WarningText(int64_t t_ns) const {
  constexpr double kSecond_ns = 1e9;
  const std::optional<int64_t> newest_ns = queue_.newest_ns();
  if (!newest_ns) {
    return fmt::format(
        "no sample of the inertial sensor arrives on {} ({}), so frames are tracked without them: is its name right, "
        "and has its type rates and forces?",
        settings_.name, settings_.option);
  }
  const double age_s = static_cast<double>(t_ns - *newest_ns) / kSecond_ns;
  return fmt::format(
      "samples on {} ({}) are {:.3f} s {} than the images when these arrive, so frames are tracked without them: "
      "give both one clock, or their difference as time_offset_s",
      settings_.name, settings_.option, std::abs(age_s), age_s < 0.0 ? "newer" : "older");
}

}  // namespace plslam::robot
