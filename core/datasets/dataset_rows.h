#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "core/io/files/text_rows.h"
#include "core/io/trajectories/trajectory.h"

namespace plslam {

/// `ForEachRow`, its errors as DatasetError.
void ForEachDatasetRow(const std::string& path, const std::function<void(const TextRow&)>& use);

/// `ReadTrajectory`, its errors as DatasetError.
Trajectory ReadDatasetTrajectory(const std::string& path, TrajectoryFormat format);

/// Fails where `row` has not `n` fields; `what` says what they are ("time and file name").
void RequireColumns(const TextRow& row, size_t n, const char* what);

/// Appends a time, or fails where it is negative or not after the last one.
void AppendTime(const TextRow& row, int64_t t_ns, std::vector<int64_t>* times_ns);

/// One time in seconds a line.
std::vector<int64_t> ReadTimes(const std::string& path);

/// What a table of times and image files lists, in its order.
struct Shots {
  std::vector<int64_t> times_ns;
  std::vector<std::string> files;
};

/// The table at `path`, one image a row: its time in units of 10^`decimals` ns, which increases, and its file, below
/// `folder`; names of columns with commas are passed over. Fails where there are none, or where rows do not have these two
/// columns (called `columns` when they fail).
Shots ReadShots(const std::string& path, const std::string& folder, int decimals, const char* columns);

/// The file of `row.fields[field]`, which must lie below `folder`: no absolute path, no "..".
std::string FileBelow(const std::string& folder, const TextRow& row, size_t field);

}  // namespace plslam
