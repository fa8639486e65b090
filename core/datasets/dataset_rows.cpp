// SPDX-License-Identifier: BSD-3-Clause
#include "core/datasets/dataset_rows.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string_view>

#include "core/files/dataset_error.h"
#include "core/io/trajectories/table_header.h"

namespace plslam {
namespace {

constexpr int64_t kMinStep_ns = 100'000;
constexpr int64_t kMaxStep_ns = 10'000'000'000;

}  // namespace

void ForEachDatasetRow(const std::string& path, const std::function<void(const TextRow&)>& use) {
  AsDatasetError([&] { ForEachRow(path, use); });
}

TrajectoryFile ReadTruth(const std::string& path, TrajectoryFormat format, Notes* notes) {
  try {
    TrajectoryFile file = ReadTrajectoryFile(path, format, BadRows::kPassOver);
    notes->Add(file.notes);
    return file;
  } catch (const std::runtime_error& error) {
    notes->Warn(fmt::format("{}; frames have no true poses", error.what()));
    return {};
  }
}

std::vector<std::optional<SE3>> TruthOfEachFrame(const std::string& path, size_t n, Notes* notes) {
  constexpr int64_t kRow_ns = 1'000'000'000;
  const size_t n_warnings = notes->warnings.size();
  const TrajectoryFile file = ReadTruth(path, TrajectoryFormat::kKitti, notes);
  if (file.n_rows != n) {
    if (notes->warnings.size() == n_warnings || file.n_rows > 0) {
      notes->Warn(
          fmt::format("{}: has {} poses for {} frames, which have none for that reason", path, file.n_rows, n));
    }
    return {};
  }
  std::vector<std::optional<SE3>> poses(n);
  for (const TrajectoryPose& pose : file.poses) poses[static_cast<size_t>(pose.t_ns / kRow_ns)] = pose.T_a_b;
  return poses;
}

void RequireColumns(const TextRow& row, size_t n, const char* what) {
  if (row.fields.size() != n) row.Fail(fmt::format("{} columns instead of {} ({})", row.fields.size(), n, what));
}

void AppendTime(const TextRow& row, size_t field, int decimals, std::vector<int64_t>* times_ns) {
  const int64_t t_ns = row.Scaled(field, decimals);
  if (t_ns < 0) row.Fail(fmt::format("time {} ns is negative", t_ns));
  if (!times_ns->empty() && t_ns <= times_ns->back()) {
    const bool has_point = decimals == 0 && row.fields[field].find('.') != std::string_view::npos;
    row.Fail(fmt::format("time {} ns is not after the {} ns of the previous row{}", t_ns, times_ns->back(),
                         has_point ? " (times must be in whole nanoseconds; are these in seconds?)" : ""));
  }
  times_ns->push_back(t_ns);
}

void CheckUnitOfTime(const std::string& path, int decimals, const std::vector<int64_t>& times_ns) {
  if (times_ns.size() < 3) return;
  std::vector<int64_t> steps_ns;
  for (size_t i = 1; i < times_ns.size(); ++i) steps_ns.push_back(times_ns[i] - times_ns[i - 1]);
  const auto middle = steps_ns.begin() + static_cast<std::ptrdiff_t>(steps_ns.size() / 2);
  std::nth_element(steps_ns.begin(), middle, steps_ns.end());
  if (*middle >= kMinStep_ns && *middle <= kMaxStep_ns) return;
  const std::string_view unit =
      UnitOfTimeName(LikelyUnitOfStep(static_cast<double>(*middle) / std::pow(10.0, decimals)));
  const std::string_view expected = decimals == 9 ? "seconds" : "nanoseconds";
  throw DatasetError(fmt::format(
      "{}: times must be in {}, but then frames would be {:g} s apart in the median, not 0.0001 to 10 s{}", path,
      expected, 1e-9 * static_cast<double>(*middle), unit == expected ? "" : fmt::format("; are they in {}?", unit)));
}

std::vector<int64_t> ReadTimes(const std::string& path) {
  std::vector<int64_t> times_ns;
  ForEachDatasetRow(path, [&](const TextRow& row) {
    RequireColumns(row, 1, "a time in seconds");
    AppendTime(row, 0, 9, &times_ns);
  });
  if (times_ns.empty()) throw DatasetError(path + ": has no times");
  CheckUnitOfTime(path, 9, times_ns);
  return times_ns;
}

Shots ReadShots(const std::string& path, const std::string& folder, int decimals, const char* columns) {
  Shots shots;
  ForEachDatasetRow(path, [&](const TextRow& row) {
    if (row.IsCsvHeader()) return;
    RequireColumns(row, 2, columns);
    AppendTime(row, 0, decimals, &shots.times_ns);
    shots.files.push_back(FileBelow(folder, row, 1));
  });
  if (shots.files.empty()) throw DatasetError(path + ": lists no images");
  CheckUnitOfTime(path, decimals, shots.times_ns);
  return shots;
}

std::string FileBelow(const std::string& folder, const TextRow& row, size_t field) {
  const std::filesystem::path name(row.fields[field]);
  const bool climbs = std::any_of(name.begin(), name.end(), [](const auto& part) { return part == ".."; });
  if (name.empty() || name.is_absolute() || climbs || row.fields[field].find('\0') != std::string_view::npos) {
    row.Fail("the file name is empty or leaves the folder of the dataset");
  }
  return (std::filesystem::path(folder) / name).string();
}

}  // namespace plslam
