// SPDX-License-Identifier: BSD-3-Clause
#include "core/datasets/euroc_dataset.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <filesystem>
#include <tuple>
#include <utility>

#include "core/datasets/asl_sensor.h"
#include "core/datasets/check_rig.h"
#include "core/datasets/dataset_rows.h"
#include "core/datasets/image_list.h"
#include "core/datasets/imu_files.h"
#include "core/files/shared_file.h"

namespace plslam {
namespace {

namespace fs = std::filesystem;

/// Images with a larger time difference are of two moments, however slow the camera.
constexpr int64_t kMaxStereoPairing_ns = 500'000'000;
/// A camera that turns by 60 degrees a second moves its image by several pixels in this time.
constexpr int64_t kLargeSkew_ns = 5'000'000;
// The first existing one is used. TUM-VI has truth only within its motion capture room.
constexpr std::array<const char*, 2> kTruthFolders = {"state_groundtruth_estimate0", "mocap0"};

fs::path Mav(const fs::path& folder) { return fs::exists(folder / "mav0") ? folder / "mav0" : folder; }

Shots CameraShots(const fs::path& camera) {
  return ReadShots((camera / "data.csv").string(), (camera / "data").string(), 0,
                   "time in nanoseconds and file name");
}

/// The nearest images within half a frame.
std::vector<ImageList::Entry> Pair(const Shots& left, const Shots& right, Notes* notes) {
  std::vector<ImageList::Entry> entries;
  int64_t largest_ns = 0;
  const int64_t max_ns = std::min(kMaxStereoPairing_ns, MedianStep_ns(left.times_ns) / 2);
  for (const auto& [l, r] : AssociateTimes(left.times_ns, right.times_ns, max_ns)) {
    entries.push_back({left.times_ns[l], left.files[l], right.files[r], ""});
    largest_ns = std::max(largest_ns, std::abs(left.times_ns[l] - right.times_ns[r]));
  }
  if (largest_ns > 0) {
    notes->Add(largest_ns > kLargeSkew_ns,
               fmt::format("times of cam0 and cam1 differ by up to {:.3f} ms: the nearest ones are pairs",
                           1e-6 * static_cast<double>(largest_ns)));
  }
  return entries;
}

std::vector<std::optional<SE3>> GroundTruth(const fs::path& mav, const SE3& T_b_l, ImageList* list) {
  for (const char* folder : kTruthFolders) {
    const fs::path path = mav / folder / "data.csv";
    if (!fs::exists(path)) continue;
    std::vector<std::optional<SE3>> poses = FrameTruth(path.string(), TrajectoryFormat::kEuroc, list);
    for (std::optional<SE3>& pose : poses) {
      if (pose) pose = *pose * T_b_l;
    }
    return poses;
  }
  return {};
}

/// The files of Kalibr that TUM-VI has instead of `sensor.yaml`.
fs::path KalibrFile(const fs::path& mav, const char* name) {
  return NamesOfFolder(mav).front().parent_path() / "dso" / name;
}

/// Returns the calibration files of the two cameras; the same file twice if it has both.
std::array<std::string, 2> CalibrationPaths(const fs::path& mav) {
  const fs::path left = mav / "cam0" / "sensor.yaml", right = mav / "cam1" / "sensor.yaml";
  const fs::path both = KalibrFile(mav, "camchain.yaml");
  if (!fs::exists(left) && !fs::exists(right) && fs::exists(both)) return {both.string(), both.string()};
  return {left.string(), right.string()};
}

RigCalibration ReadRig(const std::array<std::string, 2>& paths, Notes* notes) {
  RigCalibration rig;
  rig.name = "euroc";
  if (paths[0] == paths[1]) {
    std::tie(rig.left, rig.right) = ReadCamchain(paths[0], notes);
  } else {
    rig.left = ReadAslCamera(paths[0]);
    rig.right = ReadAslCamera(paths[1]);
  }
  rig.baseline_m = (rig.left.T_b_cam.Inverse() * rig.right.T_b_cam).translation().norm();
  return rig;
}

}  // namespace

std::unique_ptr<Dataset> OpenEurocDataset(const std::string& folder) {
  const fs::path mav = Mav(folder);
  ImageList list;
  list.name = folder;
  const std::array<std::string, 2> calibrations = CalibrationPaths(mav);
  list.rig = ReadRig(calibrations, &list.notes);
  WarnOfLongBaseline(calibrations[1], list.rig, kLengthsAreMetres, &list.notes);
  const Shots left = CameraShots(mav / "cam0");
  const Shots right = CameraShots(mav / "cam1");
  list.entries = Pair(left, right, &list.notes);
  if (list.entries.empty()) {
    throw DatasetError(fmt::format(
        "{}: no image is within half a frame of an image of cam0; the first times are {} ns (cam0) and {} ns (cam1)",
        (mav / "cam1" / "data.csv").string(), left.times_ns.front(), right.times_ns.front()));
  }
  for (const auto& [camera, shots] : {std::pair("images of cam0", &left), std::pair("images of cam1", &right)}) {
    NoteUnpaired(shots->files.size() - list.entries.size(), shots->files.size(), camera, "in time", &list.notes);
  }
  list.image_size = LearnImageSize(list.entries);
  list.ground_truth = GroundTruth(mav, list.rig.left.T_b_cam, &list);
  const std::string imu = (mav / "imu0" / "sensor.yaml").string();
  ImuSources sources{.files = {imu}, .has_camera_file = true, .other = OtherKeys::kIgnored};
  if (calibrations[0] == calibrations[1]) sources.files.push_back(calibrations[0]);
  if (!fs::exists(imu)) sources.files.push_back(KalibrFile(mav, "imu_config.yaml").string());
  AddImu((mav / "imu0" / "data.csv").string(), imu, sources, &list);
  return MakeImageListDataset(std::move(list), calibrations[1]);
}

bool LooksLikeEuroc(const std::string& folder) { return fs::exists(Mav(folder) / "cam0" / "data.csv"); }

}  // namespace plslam
