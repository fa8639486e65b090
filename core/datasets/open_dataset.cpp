// SPDX-License-Identifier: BSD-3-Clause
#include "core/datasets/open_dataset.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "core/datasets/calibrations/foreign_calibration.h"
#include "core/datasets/euroc_dataset.h"
#include "core/datasets/images_dataset.h"
#include "core/datasets/kitti_dataset.h"
#include "core/datasets/log_dataset.h"
#include "core/datasets/recordings/recording_dataset.h"
#include "core/datasets/synthetic/simulator.h"
#include "core/datasets/tum_dataset.h"
#include "core/datasets/vslamlab_dataset.h"
#include "core/errors/error_text.h"
#include "core/errors/standard_streams.h"
#include "core/files/git_lfs.h"

namespace plslam {
namespace {

class ShiftedDataset : public Dataset {
 public:
  ShiftedDataset(std::unique_ptr<Dataset> dataset, int offset)
      : dataset_(std::move(dataset)), offset_(offset), first_(std::max(-offset, 0)) {}

  std::string name() const override { return dataset_->name(); }
  const RigCalibration& rig() const override { return dataset_->rig(); }
  int size() const override { return dataset_->size() - std::abs(offset_); }
  int64_t t_ns(int index) const override { return dataset_->t_ns(first_ + index); }
  StereoImages Read(int index) const override {
    StereoImages images = dataset_->Read(first_ + index);
    images.right = dataset_->Read(first_ + index + offset_).right;
    images.frame_id = index;
    return images;
  }
  std::string Missing(int index) const override {
    const std::string left = dataset_->Missing(first_ + index);
    return left.empty() ? dataset_->Missing(first_ + index + offset_) : left;
  }
  std::string LeftFile(int index) const override { return dataset_->LeftFile(first_ + index); }
  const std::vector<ImuSample>& ImuSamples() const override { return dataset_->ImuSamples(); }
  std::optional<SE3> GroundTruth(int index) const override { return dataset_->GroundTruth(first_ + index); }
  bool HasRecordedTruth() const override { return dataset_->HasRecordedTruth(); }
  plslam::Notes Notes() const override { return dataset_->Notes(); }
  plslam::Notes NotesOfReading() const override { return dataset_->NotesOfReading(); }
  double scan_s() const override { return dataset_->scan_s(); }

 private:
  std::unique_ptr<Dataset> dataset_;
  int offset_;
  int first_;
};

}  // namespace

std::unique_ptr<Dataset> ShiftRightImages(std::unique_ptr<Dataset> dataset, int offset) {
  if (offset == 0) return dataset;
  if (dataset->rig().kind == RigCalibration::Kind::kRgbd) {
    throw DatasetError(dataset->name() + ": player.right_offset_frames=" + std::to_string(offset) +
                       " is for pairs of two cameras, but this dataset has depth images; leave it at 0");
  }
  if (std::abs(offset) >= dataset->size()) {
    throw DatasetError(dataset->name() + ": player.right_offset_frames=" + std::to_string(offset) +
                       " leaves none of its " + std::to_string(dataset->size()) +
                       " frames with a right image; give a smaller number");
  }
  return std::make_unique<ShiftedDataset>(std::move(dataset), offset);
}

namespace {

constexpr std::string_view kSyntheticPrefix = "synthetic:";

bool LooksLikeSynthetic(const std::string& location) { return location.starts_with(kSyntheticPrefix); }

bool LooksLikeLog(const std::string& location) { return std::filesystem::is_regular_file(location); }

std::unique_ptr<Dataset> OpenSynthetic(const std::string& location) {
  return OpenSyntheticDataset(LooksLikeSynthetic(location) ? location.substr(kSyntheticPrefix.size()) : location);
}

/// How a kind is found and opened.
struct Opener {
  DatasetKind kind;
  bool (*looks_like)(const std::string& location);
  std::unique_ptr<Dataset> (*open)(const std::string& location);
};

// In this order: a folder with the lists of a format is taken for that format even if it has a camera.yaml too.
const std::vector<Opener>& Openers() {
  static const std::vector<Opener> kOpeners{
      {{"synthetic", "synthetic:NAME",
        "built-in world (synthetic:room, synthetic:corridor, synthetic:street, synthetic:whitewall)", false},
       LooksLikeSynthetic,
       OpenSynthetic},
      {{"mcap", "FILE.mcap", "MCAP file", false}, LooksLikeMcap, OpenMcapDataset},
      {{"bag", "FILE.bag", "ROS 1 bag", false}, LooksLikeBag, OpenBagDataset},
      {{"ros2bag", "a folder of .db3 or .mcap files, or FILE.db3", "ROS 2 bag"},
       LooksLikeRos2Bag,
       OpenRos2BagDataset},
      {{"log", "a file", "LCM log", false}, LooksLikeLog, bus::OpenLogDataset},
      {{"vslamlab", "rgb.csv with calibration.yaml", "VSLAM-LAB"}, LooksLikeVslamLab, OpenVslamLabDataset},
      {{"kitti", "calib.txt with image_0 or image_2", "KITTI odometry"}, LooksLikeKitti, OpenKittiDataset},
      {{"euroc", "mav0/cam0/data.csv", "EuRoC"}, LooksLikeEuroc, OpenEurocDataset},
      {{"tum", "rgb.txt with depth.txt, or associations.txt", "TUM RGB-D"}, LooksLikeTum, OpenTumDataset},
      {{"images", "camera.yaml or the calibration of another program", "left/right images"},
       LooksLikeImages,
       OpenImagesDataset}};
  return kOpeners;
}

template <class Describe>
std::string Join(const std::vector<DatasetKind>& kinds, Describe describe) {
  std::string text;
  for (const DatasetKind& kind : kinds) text += (text.empty() ? "" : ", ") + describe(kind);
  return text;
}

const Opener& OpenerByName(const std::string& name) {
  for (const Opener& opener : Openers()) {
    if (opener.kind.name == name) return opener;
  }
  throw DatasetError(fmt::format("unknown format of dataset '{}' ({})", name, DatasetKindHelp()));
}

const Opener& OpenerByLooking(const std::string& location) {
  for (const Opener& opener : Openers()) {
    if (opener.looks_like(location)) return opener;
  }
  if (!std::filesystem::exists(location)) throw DatasetError(location + ": the dataset does not exist");
  const auto describe = [](const DatasetKind& kind) { return fmt::format("{}: {}", kind.name, kind.sign); };
  const std::string unread = UnreadCalibration(location);
  throw DatasetError(fmt::format("{}: is not a dataset of a known format ({}){}", location,
                                 Join(DatasetKinds(), describe), unread.empty() ? "" : "; " + unread));
}

const Opener& OpenerOf(const std::string& location, const std::string& kind) {
  return kind.empty() ? OpenerByLooking(location) : OpenerByName(kind);
}

/// A recording that Git LFS has not fetched.
bool IsPointerFile(const std::string& path) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) return false;
  std::array<char, 64> start{};
  std::ifstream(path, std::ios::binary).read(start.data(), start.size());
  return IsGitLfsPointer({start.data(), start.size()});
}

/// Returns the result of `f`; an error of the file system becomes a DatasetError.
template <class F>
auto Translated(F f) {
  try {
    return f();
  } catch (const std::filesystem::filesystem_error& error) {
    throw DatasetError(SentenceOf(error));
  }
}

}  // namespace

const std::vector<DatasetKind>& DatasetKinds() {
  static const std::vector<DatasetKind> kKinds = [] {
    std::vector<DatasetKind> kinds;
    for (const Opener& opener : Openers()) kinds.push_back(opener.kind);
    return kinds;
  }();
  return kKinds;
}

std::string DatasetHelp() {
  std::vector<DatasetKind> folders, others;
  for (const DatasetKind& kind : DatasetKinds()) (kind.is_folder ? folders : others).push_back(kind);
  const auto what = [](const DatasetKind& kind) { return kind.what; };
  return fmt::format("folder ({}), {}", Join(folders, what), Join(others, what));
}

std::string DatasetKindHelp() {
  return Join(DatasetKinds(), [](const DatasetKind& kind) { return kind.name; });
}

std::unique_ptr<Dataset> OpenDataset(const std::string& location, const std::string& kind) {
  if (IsPointerFile(FileOfLocation(location))) throw DatasetError(fmt::format("{}: {}", location, kGitLfsPointer));
  return Translated([&] { return OpenerOf(location, kind).open(location); });
}

void PrintNotes(const Dataset& dataset) {
  const Notes notes = dataset.Notes();
  for (const std::string& warning : notes.warnings)
    PrintError(fmt::format("warning: {}: {}", dataset.name(), warning));
  for (const std::string& remark : notes.remarks) PrintError(fmt::format("note: {}: {}", dataset.name(), remark));
}

std::unique_ptr<Dataset> OpenDatasetAndWarn(const std::string& location, const std::string& kind) {
  auto dataset = OpenDataset(location, kind);
  PrintNotes(*dataset);
  return dataset;
}

std::string WithTopics(const std::string& location, const std::string& kind, const std::vector<std::string>& topics) {
  if (topics.empty()) return location;
  for (const std::string& topic : topics) {
    if (topic.find_first_of("?&") == std::string::npos) continue;
    throw DatasetError(fmt::format("--topics: '{}' is not a ROS topic, because it contains ? or &", Shown(topic)));
  }
  return Translated([&] {
    const auto open = OpenerOf(location, kind).open;
    if (open != OpenMcapDataset && open != OpenBagDataset && open != OpenRos2BagDataset) {
      throw DatasetError(location + ": --topics is only for ROS recordings (FILE.mcap, FILE.bag, ROS 2 bags)");
    }
    const char sign = FileOfLocation(location) == location ? '?' : '&';
    return fmt::format("{}{}left={}&right={}", location, sign, topics.at(0), topics.at(1));
  });
}

}  // namespace plslam
