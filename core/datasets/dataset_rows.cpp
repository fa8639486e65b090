#include "core/datasets/dataset_rows.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "core/io/files/dataset_error.h"

namespace plslam {

void ForEachDatasetRow(const std::string& path, const std::function<void(const TextRow&)>& use) {
  AsDatasetError([&] { ForEachRow(path, use); });
}

Trajectory ReadDatasetTrajectory(const std::string& path, TrajectoryFormat format) {
  return AsDatasetError([&] { return ReadTrajectory(path, format); });
}

void RequireColumns(const TextRow& row, size_t n, const char* what) {
  if (row.fields.size() != n) row.Fail(fmt::format("{} columns instead of {} ({})", row.fields.size(), n, what));
}

void AppendTime(const TextRow& row, int64_t t_ns, std::vector<int64_t>* times_ns) {
  if (t_ns < 0) row.Fail(fmt::format("time {} ns is negative", t_ns));
  if (!times_ns->empty() && t_ns <= times_ns->back()) {
    row.Fail(fmt::format("time {} ns is not after the {} ns of the row before", t_ns, times_ns->back()));
  }
  times_ns->push_back(t_ns);
}

std::vector<int64_t> ReadTimes(const std::string& path) {
  std::vector<int64_t> times_ns;
  ForEachDatasetRow(path, [&](const TextRow& row) {
    RequireColumns(row, 1, "a time in seconds");
    AppendTime(row, row.Scaled(0, 9), &times_ns);
  });
  if (times_ns.empty()) throw DatasetError(path + ": has no times");
  return times_ns;
}

Shots ReadShots(const std::string& path, const std::string& folder, int decimals, const char* columns) {
  Shots shots;
  ForEachDatasetRow(path, [&](const TextRow& row) {
    if (row.IsCsvHeader()) return;
    RequireColumns(row, 2, columns);
    AppendTime(row, row.Scaled(0, decimals), &shots.times_ns);
    shots.files.push_back(FileBelow(folder, row, 1));
  });
  if (shots.files.empty()) throw DatasetError(path + ": lists no images");
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
