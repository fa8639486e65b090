// SPDX-License-Identifier: BSD-3-Clause
#include "tools/calibration/calibration_command.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <charconv>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/datasets/calibrations/foreign_calibration.h"
#include "core/datasets/camera_file.h"
#include "core/datasets/check_rig.h"
#include "core/files/atomic_file.h"
#include "core/files/dataset_error.h"
#include "core/geometry/rectification.h"

namespace plslam::calibration {
namespace {

struct CalibrationOptions {
  std::vector<std::string> files;
  std::string out;
  std::string size;
  std::string unit;
};

/// Parses "752x480"; 0 x 0 for an empty text.
ImageSize SizeOf(const std::string& text) {
  if (text.empty()) return {0, 0};
  ImageSize size{0, 0};
  const char* const end = text.data() + text.size();
  const auto [cross, error] = std::from_chars(text.data(), end, size.width_px);
  if (error == std::errc() && cross != end && *cross == 'x') {
    const auto [rest, other_error] = std::from_chars(cross + 1, end, size.height_px);
    if (other_error == std::errc() && rest == end && size.width_px > 0 && size.height_px > 0) return size;
  }
  throw DatasetError(fmt::format("--size {}: expected WIDTHxHEIGHT in pixels, like 752x480", text));
}

/// The unit that was given, or the question for it where lengths are hardly metres.
ForeignCalibration ReadWithUnit(const CalibrationOptions& o) {
  const std::optional<double> metres_per_unit = MetresOf(o.unit);
  ForeignCalibration calibration = ReadForeignCalibration(o.files, SizeOf(o.size), metres_per_unit);
  const RigCalibration& rig = calibration.rig;
  const bool is_stereo = rig.kind == RigCalibration::Kind::kStereo;
  if (is_stereo && !metres_per_unit && rig.baseline_m > kUsualBaseline_m) {
    throw DatasetError(
        fmt::format("{}: the cameras are {:.4g} m apart: state the unit of its lengths, --unit m, cm "
                    "or mm",
                    fmt::join(o.files, ", "), rig.baseline_m));
  }
  return calibration;
}

/// Prints where the inertial sensor is, and what of it is assumed.
void PrintImu(const CalibrationOptions& o, const RigCalibration& rig) {
  if (!rig.imu) return;
  Notes notes;
  const ImuParts parts = ReadForeignImu(o.files, MetresOf(o.unit), &notes);
  for (const std::string& warning : notes.warnings) fmt::print("warning: {}\n", warning);
  for (const std::string& remark : notes.remarks) fmt::print("note: {}\n", remark);
  const Eigen::Vector3d p = (rig.left.T_b_cam.Inverse() * rig.imu->T_b_imu).translation();
  fmt::print("inertial sensor at {:.4f}, {:.4f}, {:.4f} m in the left camera, time offset {} s, noise {}\n", p.x(),
             p.y(), p.z(), rig.imu->time_offset_s,
             parts.noise ? "as stated" : "that of a sensor without a data sheet, since none is stated");
}

int Convert(const CalibrationOptions& o) {
  ForeignCalibration calibration = ReadWithUnit(o);
  WarnOfOtherScale(o.files.front(), calibration.rig, &calibration.notes);
  const RigCalibration& rig = calibration.rig;
  const Rectification rectification = Rectify(rig);
  fmt::print("{}: {}; {}\n", fmt::join(o.files, ", "), calibration.format, calibration.direction);
  for (const std::string& warning : calibration.notes.warnings) fmt::print("warning: {}\n", warning);
  for (const std::string& remark : calibration.notes.remarks) fmt::print("note: {}\n", remark);
  if (rig.kind == RigCalibration::Kind::kRgbd) {
    fmt::print("lens {}, {} x {} pixels, {} depth units per metre\n", rig.left.model, rig.left.width_px,
               rig.left.height_px, rig.depth_units_per_m);
  } else {
    fmt::print("left lens {}, right lens {}, {} x {} pixels, baseline {:.5f} m; rectified focal length {:.1f} px\n",
               rig.left.model, rig.right.model, rig.left.width_px, rig.left.height_px, rig.baseline_m,
               rectification.camera.f_px);
  }
  PrintImu(o, rig);
  if (!o.out.empty()) WriteFileAtomically(o.out, CameraFileText(rig));
  return 0;
}

}  // namespace

void AddCalibrationCommand(CLI::App* app, std::function<int()>* command) {
  auto options = std::make_shared<CalibrationOptions>();
  auto* sub =
      app->add_subcommand("calibration", "reads the stereo calibration of another program into a camera.yaml");
  sub->add_option("files", options->files,
                  "Kalibr camchain, OpenCV (M1 D1 M2 D2 R T), ROS camera_info (left and right), ORB-SLAM, PL-SLAM, "
                  "VINS-Fusion, ZED and others (docs/datasets.md)")
      ->required()
      ->expected(1, 2);
  sub->add_option("--out", options->out, "camera.yaml to write [the calibration is only printed]")->type_name("FILE");
  sub->add_option("--size", options->size, "size of the images, if the file does not state it or has several")
      ->type_name("WIDTHxHEIGHT");
  sub->add_option("--unit", options->unit, "unit of lengths in the file [m; required if the baseline is above 1 m]")
      ->check(CLI::IsMember({"m", "cm", "mm"}));
  sub->footer(
      "The format is recognised from the content. The output states how the file's transforms were interpreted.\n"
      "Examples:\n"
      "  plslam calibration camchain.yaml --out my_camera/camera.yaml\n"
      "  plslam calibration left.yaml right.yaml --out my_camera/camera.yaml\n"
      "  plslam calibration SN1234.conf --size 1280x720 --out my_camera/camera.yaml\n"
      "  plslam calibration stereo.yml --unit mm --out my_camera/camera.yaml");
  sub->callback([=] { *command = [options] { return Convert(*options); }; });
}

}  // namespace plslam::calibration
