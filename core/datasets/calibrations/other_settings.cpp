// SPDX-License-Identifier: BSD-3-Clause
#include "core/datasets/calibrations/other_settings.h"

#include <algorithm>
#include <array>
#include <fstream>
#include <string_view>

#include "core/files/git_lfs.h"

namespace plslam {
namespace {

/// A file that is recognised by its first bytes.
struct OtherText {
  const char* begin;
  const char* what;
};
constexpr std::array<OtherText, 5> kOtherTexts = {
    {{"<?xml", "is XML: write the calibration as YAML (OpenCV's FileStorage does if the name ends with .yml)"},
     {"<opencv_storage", "is XML from OpenCV: write it as YAML (FileStorage does if the name ends with .yml)"},
     {"# oST",
      "is a ROS calibration in INI form: `rosrun camera_calibration_parsers convert FILE left.yaml` writes the YAML "
      "form; files of the left and the right camera are needed"},
     {"PK\x03\x04", "is a numpy (.npz) or zip archive: write M1 D1 M2 D2 R T as YAML with OpenCV's FileStorage"},
     {"\x93NUMPY", "is a numpy array: write M1 D1 M2 D2 R T as YAML with OpenCV's FileStorage"}}};

/// A file that is recognised by its keys, all of which it has.
struct OtherSettings {
  std::array<const char*, 3> keys;
  const char* what;
};
constexpr std::array<OtherSettings, 12> kOtherSettings = {
    {{{"left.focal_length_px"},
      "is in plslam's own format already: call it camera.yaml, beside the images, or name it "
      "(FILE?camera=camera.yaml of a "
      "recording)"},
     {{"from", nullptr, nullptr},
      "is in plslam's own format already, and names other files by `from`: give those, or use it as the camera.yaml "
      "beside the images"},
     {{"model_type", "projection_parameters"},
      "is for one camera (camodocal): give the settings of VINS-Fusion that name both by cam0_calib and cam1_calib"},
     {{"rotation_matrix", "translation_matrix"},
      "is the pose of the pair in RTAB-Map's calibration: give the files of its cameras, NAME_left.yaml and "
      "NAME_right.yaml"},
     {{"camera_matrix", "distortion_coefficients"},
      "is for one camera: a stereo pair needs both cameras and R and T (OpenCV's stereo_calib, or `plslam "
      "calibrate`)"},
     {{"Camera_Matrix", "Distortion_Coefficients"},
      "is for one camera: a stereo pair needs both cameras and R and T (OpenCV's stereo_calib, or `plslam "
      "calibrate`)"},
     {{"extrinsicRotation", "extrinsicTranslation"},
      "is from VINS-Mono, with one camera: a stereo pair is needed (settings of VINS-Fusion with num_of_cam: 2)"},
     {{"P0", "P1"}, "is KITTI's calib.txt: name it calib.txt, beside image_0 and image_1 (docs/datasets.md, KITTI)"},
     {{"P_rect_00", "P_rect_01"},
      "is calib_cam_to_cam.txt of KITTI's raw data: write the numbers of P_rect_00 and P_rect_01 into a calib.txt as "
      "P0: and P1:, beside image_0 and image_1"},
     {{"T_BS", "gyroscope_noise_density"}, "is for an inertial sensor: give the files of the cameras"},
     {{"noise_gyro", "noise_acc"}, "is for an inertial sensor: give the file of the cameras"},
     {{"cam_overlaps", "rostopic"}, "is for one camera of Kalibr: give the complete camchain, with cam0 and cam1"}}};

/// The first line is `[name]`, as in an INI file. A list of YAML or JSON has commas, quotes or braces.
bool BeginsWithSection(std::string_view begin) {
  const size_t first = begin.find_first_not_of(" \t\r\n");
  if (first == begin.npos || begin[first] != '[') return false;
  const std::string_view line = begin.substr(first, begin.find('\n', first) - first);
  const size_t end = line.find(']');
  return end != line.npos && end > 1 && line.find_first_not_of(" \t\r", end + 1) == line.npos &&
         line.substr(0, end).find_first_of(",\"'{:") == line.npos;
}

}  // namespace

std::string WhyOtherText(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::array<char, 64> bytes{};
  file.read(bytes.data(), bytes.size());
  std::string_view begin(bytes.data(), static_cast<size_t>(file.gcount()));
  constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
  if (begin.starts_with(kByteOrderMark)) begin.remove_prefix(kByteOrderMark.size());
  if (IsGitLfsPointer(begin)) return kGitLfsPointer;
  for (const OtherText& text : kOtherTexts) {
    if (begin.starts_with(text.begin)) return text.what;
  }
  if (BeginsWithSection(begin)) {
    return "is an INI file: ZED's are read, under their own name (SN1234.conf), and those of ROS (ost.ini) as YAML "
           "(`rosrun camera_calibration_parsers convert ost.ini left.yaml`); write others as a camera.yaml "
           "(docs/datasets.md)";
  }
  return "";
}

std::string WhyOtherSettings(const YamlMap& file) {
  for (const OtherSettings& settings : kOtherSettings) {
    const bool has_all = std::all_of(settings.keys.begin(), settings.keys.end(),
                                     [&](const char* key) { return key == nullptr || file.Has(key); });
    if (has_all) return settings.what;
  }
  return "";
}

}  // namespace plslam
