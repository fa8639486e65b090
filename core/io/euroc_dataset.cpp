#include "core/io/euroc_dataset.h"

#include <fmt/format.h>

#include <filesystem>
#include <utility>

#include "core/io/asl_sensor.h"
#include "core/io/dataset_rows.h"
#include "core/io/image_list.h"
#include "core/io/interpolate_pose.h"

namespace plslam {
namespace {

namespace fs = std::filesystem;

constexpr int64_t kMaxStereoPairing_ns = 500'000;

fs::path Mav(const fs::path& folder) { return fs::exists(folder / "mav0") ? folder / "mav0" : folder; }

Shots CameraShots(const fs::path& camera) {
  return ReadShots((camera / "data.csv").string(), (camera / "data").string(), 0,
                   "time in nanoseconds and file name");
}

// Both lists increase, so that one walk over the two finds all pairs.
std::vector<ImageList::Entry> Pair(const Shots& left, const Shots& right) {
  std::vector<ImageList::Entry> entries;
  size_t r = 0;
  for (size_t l = 0; l < left.files.size(); ++l) {
    const int64_t t_ns = left.times_ns[l];
    while (r < right.files.size() && right.times_ns[r] < t_ns && t_ns - right.times_ns[r] > kMaxStereoPairing_ns) ++r;
    if (r == right.files.size()) break;
    if (right.times_ns[r] > t_ns && right.times_ns[r] - t_ns > kMaxStereoPairing_ns) continue;
    entries.push_back({t_ns, left.files[l], right.files[r], ""});
    ++r;
  }
  return entries;
}

void NoteUnpairedImages(const char* camera, size_t n, std::vector<std::string>* notes) {
  if (n > 0) notes->push_back(fmt::format("{} images of {} have no partner in time and are passed over", n, camera));
}

std::vector<std::optional<SE3>> GroundTruth(const fs::path& mav, const std::vector<ImageList::Entry>& entries,
                                            const SE3& T_b_l) {
  const fs::path path = mav / "state_groundtruth_estimate0" / "data.csv";
  std::vector<std::optional<SE3>> poses;
  if (!fs::exists(path)) return poses;
  const Trajectory body = ReadDatasetTrajectory(path.string(), TrajectoryFormat::kEuroc);
  for (const ImageList::Entry& entry : entries) {
    const std::optional<SE3> T_w_b = InterpolatePose(body, entry.t_ns, kMaxTruthGap_ns);
    poses.push_back(T_w_b ? std::optional<SE3>(*T_w_b * T_b_l) : std::nullopt);
  }
  return poses;
}

RigCalibration ReadRig(const fs::path& mav) {
  RigCalibration rig;
  rig.name = "euroc";
  rig.left = ReadAslCamera((mav / "cam0" / "sensor.yaml").string());
  rig.right = ReadAslCamera((mav / "cam1" / "sensor.yaml").string());
  rig.baseline_m = (rig.left.T_b_cam.Inverse() * rig.right.T_b_cam).translation().norm();
  return rig;
}

}  // namespace

std::unique_ptr<Dataset> OpenEurocDataset(const std::string& folder) {
  const fs::path mav = Mav(folder);
  ImageList list;
  list.name = folder;
  list.rig = ReadRig(mav);
  const Shots left = CameraShots(mav / "cam0");
  const Shots right = CameraShots(mav / "cam1");
  list.entries = Pair(left, right);
  if (list.entries.empty()) {
    throw DatasetError((mav / "cam1" / "data.csv").string() + ": no image has the time of one of cam0");
  }
  NoteUnpairedImages("cam0", left.files.size() - list.entries.size(), &list.notes);
  NoteUnpairedImages("cam1", right.files.size() - list.entries.size(), &list.notes);
  list.image_size = LearnImageSize(list.entries);
  list.ground_truth = GroundTruth(mav, list.entries, list.rig.left.T_b_cam);
  return MakeImageListDataset(std::move(list), (mav / "cam1" / "sensor.yaml").string());
}

bool LooksLikeEuroc(const std::string& folder) { return fs::exists(Mav(folder) / "cam0" / "data.csv"); }

}  // namespace plslam
