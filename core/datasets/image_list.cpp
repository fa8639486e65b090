// SPDX-License-Identifier: BSD-3-Clause
#include "core/datasets/image_list.h"

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <tuple>
#include <utility>

#include <fmt/format.h>

#include "core/datasets/check_rig.h"
#include "core/datasets/dataset_rows.h"
#include "core/datasets/white_level.h"
#include "core/io/trajectories/trajectory.h"

namespace plslam {
namespace {

// Distance in time, then indices: a total order, so that ties are decided the same way everywhere.
using Candidate = std::tuple<int64_t, size_t, size_t>;

std::vector<Candidate> Candidates(const std::vector<int64_t>& a_ns, const std::vector<int64_t>& b_ns,
                                  int64_t max_ns) {
  std::vector<Candidate> candidates;
  for (size_t a = 0; a < a_ns.size(); ++a) {
    const auto after = std::lower_bound(b_ns.begin(), b_ns.end(), a_ns[a]);
    const auto b = static_cast<size_t>(after - b_ns.begin());
    if (after != b_ns.end() && *after - a_ns[a] <= max_ns) candidates.emplace_back(*after - a_ns[a], a, b);
    if (b > 0 && a_ns[a] - b_ns[b - 1] <= max_ns) candidates.emplace_back(a_ns[a] - b_ns[b - 1], a, b - 1);
  }
  std::sort(candidates.begin(), candidates.end());
  return candidates;
}

}  // namespace

std::vector<std::pair<size_t, size_t>> AssociateTimes(const std::vector<int64_t>& a_ns,
                                                      const std::vector<int64_t>& b_ns, int64_t max_ns) {
  std::vector<bool> a_used(a_ns.size());
  std::vector<bool> b_used(b_ns.size());
  std::vector<std::pair<size_t, size_t>> pairs;
  for (const auto& [distance_ns, a, b] : Candidates(a_ns, b_ns, max_ns)) {
    if (a_used[a] || b_used[b]) continue;
    a_used[a] = b_used[b] = true;
    pairs.emplace_back(a, b);
  }
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

void NoteUnpaired(size_t n, size_t n_all, const std::string& what, const std::string& where, Notes* notes) {
  constexpr double kFewUnpaired = 0.05;
  if (n == 0) return;
  notes->Add(static_cast<double>(n) > kFewUnpaired * static_cast<double>(n_all),
             fmt::format("{} of {} {} {} no partner {} and {} skipped", n, n_all, what, n == 1 ? "has" : "have",
                         where, n == 1 ? "is" : "are"));
}

int64_t MedianStep_ns(const std::vector<int64_t>& times_ns) {
  constexpr int64_t kOneSecond_ns = 1'000'000'000;
  if (times_ns.size() < 2) return kOneSecond_ns;
  std::vector<int64_t> steps_ns;
  for (size_t i = 1; i < times_ns.size(); ++i) steps_ns.push_back(times_ns[i] - times_ns[i - 1]);
  const auto middle = steps_ns.begin() + static_cast<std::ptrdiff_t>(steps_ns.size() / 2);
  std::nth_element(steps_ns.begin(), middle, steps_ns.end());
  return *middle;
}

namespace {

/// The median of the pixels with a depth; 0 if there are none.
double MedianDepth(const cv::Mat& depths) {
  std::vector<uint16_t> values;
  for (int y = 0; y < depths.rows; ++y) {
    std::copy_if(depths.ptr<uint16_t>(y), depths.ptr<uint16_t>(y) + depths.cols, std::back_inserter(values),
                 [](uint16_t depth) { return depth > 0; });
  }
  if (values.empty()) return 0.0;
  const auto middle = values.begin() + std::ssize(values) / 2;
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

class ImageListDataset : public Dataset {
 public:
  explicit ImageListDataset(ImageList list) : list_(std::move(list)) {
    try {
      white_ = WhiteLevelOf(
          size(), [this](int index) { return BrightValuesOf(index); }, &list_.notes);
    } catch (const DatasetError& error) {
      throw DatasetError(fmt::format("{}: {}", list_.name, error.what()));
    }
    clipped_.emplace(white_);
    if (list_.rig.kind == RigCalibration::Kind::kRgbd) CheckDepths();
  }

  std::string name() const override { return list_.name; }
  const RigCalibration& rig() const override { return list_.rig; }
  int size() const override { return static_cast<int>(list_.entries.size()); }
  int64_t t_ns(int index) const override { return Entry(index).t_ns; }
  const std::vector<ImuSample>& ImuSamples() const override { return list_.imu_samples; }
  plslam::Notes Notes() const override { return list_.notes; }
  bool HasRecordedTruth() const override { return !list_.ground_truth.empty(); }

  StereoImages Read(int index) const override {
    const ImageList::Entry& entry = Entry(index);
    if (!entry.missing.empty()) throw DatasetError(entry.missing);
    const ImageSize size{list_.rig.left.width_px, list_.rig.left.height_px};
    const bool rgbd = list_.rig.kind == RigCalibration::Kind::kRgbd;
    double left = 0.0, right = 0.0;
    StereoImages images{index, entry.t_ns, ReadGreyImage(entry.left, size, white_, &left),
                        rgbd ? ReadDepthImage(entry.right, size) : ReadGreyImage(entry.right, size, white_, &right)};
    clipped_->Add(index, left, right);
    return images;
  }

  plslam::Notes NotesOfReading() const override { return clipped_->Report(); }

  std::string LeftFile(int index) const override { return Entry(index).left; }

  std::string Missing(int index) const override {
    const ImageList::Entry& entry = Entry(index);
    if (!entry.missing.empty()) return entry.missing;
    for (const std::string& file : {entry.left, entry.right}) {
      std::error_code error;
      if (std::filesystem::status(file, error).type() == std::filesystem::file_type::not_found) {
        return file + ": the image is missing";
      }
    }
    return {};
  }

  std::optional<SE3> GroundTruth(int index) const override {
    if (list_.ground_truth.empty()) return std::nullopt;
    return list_.ground_truth.at(static_cast<size_t>(index));
  }

 private:
  const ImageList::Entry& Entry(int index) const { return list_.entries.at(static_cast<size_t>(index)); }

  BrightValues BrightValuesOf(int index) const {
    const ImageList::Entry& entry = Entry(index);
    if (!entry.missing.empty()) throw DatasetError(entry.missing);
    const int left = BrightWideValue(entry.left, list_.image_size);
    if (list_.rig.kind == RigCalibration::Kind::kRgbd) return {left, left};
    return {left, BrightWideValue(entry.right, list_.image_size)};
  }

  /// Warns if the depths of the first map are too large for a depth camera.
  void CheckDepths() {
    constexpr double kFarthest_m = 50.0;
    const auto first = std::find_if(list_.entries.begin(), list_.entries.end(),
                                    [](const ImageList::Entry& entry) { return entry.missing.empty(); });
    if (first == list_.entries.end()) return;
    double median = 0.0;
    try {
      median = MedianDepth(ReadDepthImage(first->right, list_.image_size));
    } catch (const DatasetError&) {
      return;  // an error when it is played
    }
    const double median_m = median / list_.rig.depth_units_per_m;
    if (!(median_m > kFarthest_m)) return;
    list_.notes.Warn(
        fmt::format("{}: its depths have a median of {} units, which is {:.4g} m at {:g} units a metre: the factor "
                    "(depth_units_per_m, "
                    "DepthMapFactor) is most often 1000 (millimetres) or 5000 (TUM RGB-D)",
                    first->right, median, median_m, list_.rig.depth_units_per_m));
  }

  ImageList list_;
  int white_ = kWhiteOf16Bits;
  mutable std::optional<ClippedFrames> clipped_;
};

double MedianRate_hz(const std::vector<ImageList::Entry>& entries, double fallback_hz) {
  if (entries.size() < 2) return fallback_hz;
  std::vector<int64_t> times_ns;
  times_ns.reserve(entries.size());
  for (const ImageList::Entry& entry : entries) times_ns.push_back(entry.t_ns);
  return 1e9 / static_cast<double>(MedianStep_ns(times_ns));
}

}  // namespace

std::unique_ptr<Dataset> MakeImageListDataset(ImageList list, const std::string& calibration_path) {
  if (list.entries.empty()) throw DatasetError(list.name + ": the sequence has no frames");
  for (size_t i = 1; i < list.entries.size(); ++i) {
    if (list.entries[i].t_ns <= list.entries[i - 1].t_ns) {
      throw DatasetError(fmt::format("{}: time {} ns of frame {} is not after the {} ns of the previous frame",
                                     list.name, list.entries[i].t_ns, i, list.entries[i - 1].t_ns));
    }
  }
  list.rig.rate_hz = MedianRate_hz(list.entries, list.rig.rate_hz);
  const std::string complaint = RigComplaint(list.rig);
  if (!complaint.empty()) throw DatasetError(calibration_path + ": " + complaint);
  if (ImageSize{list.rig.left.width_px, list.rig.left.height_px} != list.image_size) {
    throw DatasetError(fmt::format("{}: the cameras have {} x {} pixels, but the images {} x {} ({})",
                                   calibration_path, list.rig.left.width_px, list.rig.left.height_px,
                                   list.image_size.width_px, list.image_size.height_px, list.entries.front().left));
  }
  WarnOfOtherScale(calibration_path, list.rig, &list.notes);
  return std::make_unique<ImageListDataset>(std::move(list));
}

ImageSize LearnImageSize(const std::vector<ImageList::Entry>& entries) {
  std::string first_error = "the sequence has no frames";
  bool is_first = true;
  for (const ImageList::Entry& entry : entries) {
    std::string error = entry.missing;
    try {
      if (error.empty()) {
        const ImageSize left = ReadImageSize(entry.left);
        const ImageSize right = ReadImageSize(entry.right);
        if (left == right) return left;
        error = fmt::format("{}: has {} x {} pixels, but the left image {} x {}", entry.right, right.width_px,
                            right.height_px, left.width_px, left.height_px);
      }
    } catch (const DatasetError& bad) {
      error = bad.what();
    }
    if (std::exchange(is_first, false)) first_error = error;
  }
  throw DatasetError(first_error);
}

namespace {

std::string SpanText(int64_t first_ns, int64_t last_ns) {
  return fmt::format("{} s to {} s", SecondsText(first_ns), SecondsText(last_ns));
}

}  // namespace

std::vector<std::optional<SE3>> FrameTruth(const std::string& path, TrajectoryFormat format, ImageList* list) {
  const TrajectoryFile file = ReadTruth(path, format, &list->notes);
  const Trajectory& truth = file.poses;
  std::vector<std::optional<SE3>> poses;
  poses.reserve(list->entries.size());
  for (const ImageList::Entry& entry : list->entries) {
    poses.push_back(InterpolatePose(truth, entry.t_ns, kMaxTruthGap_ns));
  }
  const std::string name = std::filesystem::path(path).lexically_relative(list->name).string();
  const auto n =
      static_cast<size_t>(std::count_if(poses.begin(), poses.end(), [](const auto& p) { return p.has_value(); }));
  if (truth.empty()) {
    if (file.n_rows == 0 && file.format) list->notes.Warn(name + ": has no poses, so accuracy is not measured");
    return {};
  }
  if (2 * n < poses.size()) {
    const int64_t first_ns = list->entries.front().t_ns, last_ns = list->entries.back().t_ns;
    const auto n_outside = static_cast<size_t>(std::count_if(
        truth.begin(), truth.end(), [&](const TrajectoryPose& p) { return p.t_ns < first_ns || p.t_ns > last_ns; }));
    // A truth without any pose is a warning of the run (truth_of_other_times).
    const bool is_of_other_times = n > 0 && 2 * n_outside > truth.size();
    list->notes.Add(is_of_other_times, fmt::format("{}: {} poses ({}), {} of {} frames ({}) have one", name,
                                                   truth.size(), SpanText(truth.front().t_ns, truth.back().t_ns), n,
                                                   poses.size(), SpanText(first_ns, last_ns)));
  }
  return poses;
}

}  // namespace plslam
