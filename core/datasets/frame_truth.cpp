// SPDX-License-Identifier: BSD-3-Clause
#include "core/datasets/frame_truth.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "core/datasets/dataset_rows.h"
#include "core/io/trajectories/interpolate_pose.h"

namespace plslam {
namespace {

std::string SpanText(int64_t first_ns, int64_t last_ns) {
  return fmt::format("{} s to {} s", SecondsText(first_ns), SecondsText(last_ns));
}

}  // namespace

std::vector<std::optional<SE3>> FrameTruth(const std::string& path, TrajectoryFormat format, ImageList* list) {
  const Trajectory truth = ReadDatasetTrajectory(path, format);
  std::vector<std::optional<SE3>> poses;
  poses.reserve(list->entries.size());
  for (const ImageList::Entry& entry : list->entries) {
    poses.push_back(InterpolatePose(truth, entry.t_ns, kMaxTruthGap_ns));
  }
  const std::string name = std::filesystem::path(path).lexically_relative(list->name).string();
  const auto n =
      static_cast<size_t>(std::count_if(poses.begin(), poses.end(), [](const auto& p) { return p.has_value(); }));
  if (truth.empty()) {
    list->notes.push_back(name + ": has no poses");
  } else if (2 * n < poses.size()) {
    list->notes.push_back(fmt::format("{}: {} poses ({}), {} of {} frames ({}) have one", name, truth.size(),
                                      SpanText(truth.front().t_ns, truth.back().t_ns), n, poses.size(),
                                      SpanText(list->entries.front().t_ns, list->entries.back().t_ns)));
  }
  return poses;
}

}  // namespace plslam
