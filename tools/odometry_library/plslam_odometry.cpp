// SPDX-License-Identifier: BSD-3-Clause
#include "tools/odometry_library/plslam_odometry.h"

#include <algorithm>
#include <cstring>
#include <exception>
#include <filesystem>
#include <fstream>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>

#include <fmt/format.h>
#include <opencv2/core/mat.hpp>

#include "core/config/config.h"
#include "core/datasets/camera_file.h"
#include "core/files/atomic_file.h"
#include "core/io/images/png_codec.h"
#include "core/io/trajectories/trajectory.h"
#include "plslam_version.h"
#include "vo_process/tracking/odometry.h"

namespace plslam::odometry_library {
namespace {

namespace fs = std::filesystem;

constexpr int kFast = 1;  // compression of PNG files

/// A folder of images (docs/datasets.md) of the pairs that were tracked.
class PairRecorder {
 public:
  /// Throws std::runtime_error if `folder` exists and is not empty, or cannot be created.
  PairRecorder(fs::path folder, const RigCalibration& rig, const std::string& options) : folder_(std::move(folder)) {
    if (fs::exists(folder_) && !fs::is_empty(folder_)) {
      throw std::runtime_error(fmt::format("{}: is not empty; give a new folder", folder_.string()));
    }
    is_rgbd_ = rig.kind == RigCalibration::Kind::kRgbd;
    fs::create_directories(Left());
    fs::create_directories(Right());
    times_.open(folder_ / "times.txt");
    WriteFileAtomically((folder_ / "camera.yaml").string(), CameraFileText(rig));
    if (!options.empty()) WriteFileAtomically((folder_ / "options.yaml").string(), options);
  }

  void Add(const StereoImages& images) {
    const std::string name = fmt::format("{:06}.png", n_++);
    WritePng((Left() / name).string(), images.left, kFast);
    WritePng((Right() / name).string(), images.right, kFast);
    times_ << SecondsText(images.t_ns) << std::endl;
    if (!times_) throw std::runtime_error(fmt::format("{}: cannot be written", (folder_ / "times.txt").string()));
  }

 private:
  fs::path Left() const { return folder_ / (is_rgbd_ ? "rgb" : "left"); }
  fs::path Right() const { return folder_ / (is_rgbd_ ? "depth" : "right"); }

  fs::path folder_;
  bool is_rgbd_ = false;
  int n_ = 0;
  std::ofstream times_;
};

vo::VoOptions OptionsFrom(const std::string& text) {
  vo::VoOptions options;
  if (text.empty()) return options;
  const Config config = Config::FromString(text, "options");
  constexpr std::string_view kSections[] = {"vo"};
  config.RequireSections(kSections);
  config.Read("vo", options);
  return options;
}

/// Copies the pixels, so that the caller may reuse them.
cv::Mat Copied(const plslam_image* image, const char* which) {
  if (image == nullptr || image->pixels == nullptr) {
    throw std::runtime_error(fmt::format("the {} image has no pixels", which));
  }
  if (image->bits != 8 && image->bits != 16) {
    throw std::runtime_error(
        fmt::format("the {} image has {} bits; it must have 8, or 16 (depths)", which, image->bits));
  }
  const int64_t row_bytes = int64_t{image->width_px} * image->bits / 8;
  if (image->width_px < 1 || image->height_px < 1 || image->row_bytes < row_bytes) {
    throw std::runtime_error(fmt::format("the {} image has {} x {} pixels and {} bytes a row, which cannot be", which,
                                         image->width_px, image->height_px, image->row_bytes));
  }
  cv::Mat copy(image->height_px, image->width_px, image->bits == 8 ? CV_8UC1 : CV_16UC1);
  const auto* from = static_cast<const uint8_t*>(image->pixels);
  for (int y = 0; y < copy.rows; ++y) {
    std::memcpy(copy.ptr(y), from + y * image->row_bytes, static_cast<size_t>(row_bytes));
  }
  return copy;
}

template <int kRows, int kColumns>
void Write(const Eigen::Matrix<double, kRows, kColumns>& matrix, double* to) {
  Eigen::Map<Eigen::Matrix<double, kRows, kColumns, Eigen::RowMajor>> rows(to);
  rows = matrix;
}

plslam_pose PoseOf(int64_t t_ns, const vo::OdometryResult& result) {
  plslam_pose pose{};
  pose.t_ns = t_ns;
  pose.state = static_cast<int32_t>(result.state);
  pose.is_keyframe = result.keyframe ? 1 : 0;
  pose.tracked_points = result.n_tracked_points;
  pose.tracked_lines = result.n_tracked_lines;
  Write<4, 4>(result.T_odom_c.matrix(), pose.T_odom_c);
  Write<6, 6>(result.covariance, pose.covariance);
  Write<4, 4>(result.T_prev_c.matrix(), pose.T_prev_c);
  Write<6, 6>(result.motion_covariance, pose.motion_covariance);
  return pose;
}

}  // namespace
}  // namespace plslam::odometry_library

using namespace plslam;  // NOLINT(google-build-using-namespace): the functions of C have no namespace.

struct plslam_odometry {
  plslam_odometry(RigCalibration of_rig, std::string of_options)
      : rig(std::move(of_rig)),
        options(std::move(of_options)),
        front_end(rig, odometry_library::OptionsFrom(options)),
        odometry(front_end.camera(), odometry_library::OptionsFrom(options), front_end.shutter()) {}

  RigCalibration rig;
  std::string options;
  vo::StereoFrontEnd front_end;
  vo::Odometry odometry;
  std::optional<odometry_library::PairRecorder> recorder;
  std::optional<int64_t> last_t_ns;
  std::string error;
};

namespace {

/// Calls `work` and keeps the sentence of its exception. Returns 0 or -1.
template <class Work>
int Guarded(std::string& error, Work&& work) {
  try {
    work();
    return 0;
  } catch (const std::exception& e) {
    error = e.what();
  } catch (...) {
    error = "unknown error";
  }
  return -1;
}

}  // namespace

const char* plslam_odometry_version(void) { return PLSLAM_VERSION; }

plslam_odometry* plslam_odometry_create(const char* calibration, int32_t width_px, int32_t height_px,
                                        const char* options, char* error, size_t error_bytes) {
  std::string sentence;
  std::unique_ptr<plslam_odometry> odometry;
  Guarded(sentence, [&] {
    if (calibration == nullptr) throw std::runtime_error("the calibration is missing: give the path of a file");
    odometry = std::make_unique<plslam_odometry>(ReadCameraFile(calibration, {width_px, height_px}),
                                                 options != nullptr ? options : "");
  });
  if (error != nullptr && error_bytes > 0) {
    const size_t length = std::min(sentence.size(), error_bytes - 1);
    std::memcpy(error, sentence.data(), length);
    error[length] = '\0';
  }
  return odometry.release();
}

void plslam_odometry_destroy(plslam_odometry* odometry) { delete odometry; }

int plslam_odometry_track(plslam_odometry* odometry, int64_t t_ns, const plslam_image* left,
                          const plslam_image* right, plslam_pose* pose) {
  if (odometry == nullptr) return -1;
  return Guarded(odometry->error, [&] {
    if (pose == nullptr) throw std::runtime_error("the pose is missing: give the address of a plslam_pose");
    if (odometry->last_t_ns && t_ns <= *odometry->last_t_ns) {
      throw std::runtime_error(
          fmt::format("the pair of {} ns is not later than the previous one, of {} ns", t_ns, *odometry->last_t_ns));
    }
    StereoImages images;
    images.t_ns = t_ns;
    images.left = odometry_library::Copied(left, "left");
    images.right = odometry_library::Copied(right, "right");
    if (odometry->recorder) odometry->recorder->Add(images);
    vo::StageTimer timer;
    *pose = odometry_library::PoseOf(
        t_ns, odometry->odometry.Track(t_ns, odometry->odometry.SeePair(odometry->front_end, images, timer)));
    odometry->last_t_ns = t_ns;
  });
}

int plslam_odometry_record(plslam_odometry* odometry, const char* folder) {
  if (odometry == nullptr) return -1;
  return Guarded(odometry->error, [&] {
    odometry->recorder.reset();
    if (folder != nullptr) odometry->recorder.emplace(folder, odometry->rig, odometry->options);
  });
}

const char* plslam_odometry_error(const plslam_odometry* odometry) {
  return odometry != nullptr ? odometry->error.c_str()
                             : "the odometry is missing: plslam_odometry_create returned NULL";
}
