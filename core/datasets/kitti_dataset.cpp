// SPDX-License-Identifier: BSD-3-Clause
#include "core/datasets/kitti_dataset.h"

#include <fmt/format.h>

#include <array>
#include <filesystem>
#include <map>
#include <utility>

#include "core/datasets/check_rig.h"
#include "core/datasets/dataset_rows.h"
#include "core/datasets/image_list.h"
#include "core/datasets/imu_files.h"
#include "core/files/shared_file.h"

namespace plslam {
namespace {

namespace fs = std::filesystem;

using Projection = Eigen::Matrix<double, 3, 4>;

// Numbers of the left camera of a pair; the right one has the next.
constexpr std::array<int, 2> kLeftCameras = {0, 2};
constexpr std::array<const char*, 5> kFrameExtensions = {".png", ".jpg", ".jpeg", ".pgm", ".PNG"};

std::string ImageFolder(const std::string& folder, int camera) {
  return (fs::path(folder) / fmt::format("image_{}", camera)).string();
}

int LeftCamera(const std::string& folder) {
  for (const int camera : kLeftCameras) {
    if (fs::is_directory(ImageFolder(folder, camera)) && fs::is_directory(ImageFolder(folder, camera + 1))) {
      return camera;
    }
  }
  throw DatasetError(folder + ": has neither image_0 and image_1 nor image_2 and image_3");
}

// P = K [I | t]: a matrix that is no such product has another meaning than the benchmark's.
Projection ParseProjection(const TextRow& row) {
  RequireColumns(row, 13, "a name and 12 numbers");
  Projection P;
  for (int i = 0; i < 12; ++i) P(i / 4, i % 4) = row.Number(static_cast<size_t>(i) + 1);
  const bool upper = P(0, 1) == 0.0 && P(1, 0) == 0.0 && P(2, 0) == 0.0 && P(2, 1) == 0.0 && P(2, 2) == 1.0;
  if (!upper || !(P(0, 0) > 0.0) || !(P(1, 1) > 0.0)) {
    row.Fail(fmt::format("{} is not a projection [f 0 cu; 0 f cv; 0 0 1] with f > 0 (f = {} and {})", row.fields[0],
                         P(0, 0), P(1, 1)));
  }
  return P;
}

std::map<std::string, Projection> ReadProjections(const std::string& path, int left) {
  std::map<std::string, Projection> projections;
  const std::string left_name = fmt::format("P{}:", left);
  const std::string right_name = fmt::format("P{}:", left + 1);
  ForEachDatasetRow(path, [&](const TextRow& row) {
    const std::string name(row.fields[0]);
    if (name != left_name && name != right_name) return;
    if (!projections.emplace(name, ParseProjection(row)).second) row.Fail(name + " is repeated");
  });
  for (const std::string& name : {left_name, right_name}) {
    if (!projections.contains(name)) throw DatasetError(fmt::format("{}: has no line {}", path, name));
  }
  return projections;
}

CameraCalibration ToCamera(const Projection& P) {
  CameraCalibration camera;
  camera.fx_px = P(0, 0);
  camera.fy_px = P(1, 1);
  camera.cx_px = P(0, 2);
  camera.cy_px = P(1, 2);
  // p_cam = p_0 + K^-1 p4, so this camera is at -K^-1 p4 in camera 0.
  const double z = P(2, 3);
  const Eigen::Vector3d offset((P(0, 3) - P(0, 2) * z) / P(0, 0), (P(1, 3) - P(1, 2) * z) / P(1, 1), z);
  camera.T_b_cam = SE3(Eigen::Quaterniond::Identity(), -offset);
  return camera;
}

RigCalibration ReadRig(const std::string& path, int left) {
  const std::map<std::string, Projection> projections = ReadProjections(path, left);
  RigCalibration rig;
  rig.left = ToCamera(projections.begin()->second);
  rig.right = ToCamera(projections.rbegin()->second);
  rig.baseline_m = (rig.left.T_b_cam.Inverse() * rig.right.T_b_cam).translation().norm();
  return rig;
}

// "000000.png" and its kin, for the first frame that is there.
std::string NamePattern(const std::string& folder, size_t n_frames) {
  for (size_t i = 0; i < n_frames; ++i) {
    for (const int digits : {6, 10}) {
      for (const char* extension : kFrameExtensions) {
        std::string pattern = fmt::format("{{:0{}}}{}", digits, extension);
        if (fs::exists(fs::path(folder) / fmt::format(fmt::runtime(pattern), i))) return pattern;
      }
    }
  }
  throw DatasetError(fmt::format("{}: has none of the {} images 000000.png and so on", folder, n_frames));
}

std::string PosesPath(const fs::path& folder) {
  if (fs::exists(folder / "poses.txt")) return (folder / "poses.txt").string();
  for (const fs::path& sequence : NamesOfFolder(folder)) {
    if (sequence.parent_path().filename() != "sequences") continue;
    const fs::path beside = sequence.parent_path().parent_path() / "poses" / (sequence.filename().string() + ".txt");
    if (fs::exists(beside)) return beside.string();
  }
  return "";
}

std::vector<std::optional<SE3>> ReadPoses(const std::string& path, size_t n_frames, const SE3& T_0_left,
                                          Notes* notes) {
  if (path.empty()) return {};
  std::vector<std::optional<SE3>> poses = TruthOfEachFrame(path, n_frames, notes);
  for (std::optional<SE3>& pose : poses) {
    if (pose) pose = *pose * T_0_left;
  }
  return poses;
}

}  // namespace

std::unique_ptr<Dataset> OpenKittiDataset(const std::string& folder) {
  const int left = LeftCamera(folder);
  const std::string calibration_path = (fs::path(folder) / "calib.txt").string();
  ImageList list;
  list.name = folder;
  list.rig = ReadRig(calibration_path, left);
  WarnOfLongBaseline(calibration_path, list.rig, kLengthsAreMetres, &list.notes);
  const std::vector<int64_t> times_ns = ReadTimes((fs::path(folder) / "times.txt").string());
  const std::string pattern = NamePattern(ImageFolder(folder, left), times_ns.size());
  for (size_t i = 0; i < times_ns.size(); ++i) {
    const std::string name = fmt::format(fmt::runtime(pattern), i);
    list.entries.push_back({times_ns[i], (fs::path(ImageFolder(folder, left)) / name).string(),
                            (fs::path(ImageFolder(folder, left + 1)) / name).string(), ""});
  }
  list.image_size = LearnImageSize(list.entries);
  for (CameraCalibration* camera : {&list.rig.left, &list.rig.right}) {
    camera->width_px = list.image_size.width_px;
    camera->height_px = list.image_size.height_px;
  }
  list.rig.name = "kitti";
  list.ground_truth = ReadPoses(PosesPath(folder), times_ns.size(), list.rig.left.T_b_cam, &list.notes);
  const std::string own = (fs::path(folder) / "imu.yaml").string();
  AddImu((fs::path(folder) / "imu.csv").string(), own, {.files = {own}}, &list);
  return MakeImageListDataset(std::move(list), calibration_path);
}

bool LooksLikeKitti(const std::string& folder) {
  return fs::exists(fs::path(folder) / "calib.txt") &&
         (fs::is_directory(ImageFolder(folder, 0)) || fs::is_directory(ImageFolder(folder, 2)));
}

}  // namespace plslam
