// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/io/files/text_rows.h"
#include "core/io/trajectories/trajectory.h"

namespace plslam {

/// `ForEachRow`, its errors as DatasetError.
void ForEachDatasetRow(const std::string& path, const std::function<void(const TextRow&)>& use);

/// The truth at `path`, whose rows and errors never keep a dataset from opening: rows that are no poses are passed
/// over, and a file that cannot be read is empty. `notes` says so.
TrajectoryFile ReadTruth(const std::string& path, TrajectoryFormat format, std::vector<std::string>* notes);

/// The poses of a truth of KITTI's format, a row for each of `n` frames; nullopt for rows that are none. Empty, with a
/// note, where the number of rows is another.
std::vector<std::optional<SE3>> TruthOfEachFrame(const std::string& path, size_t n, std::vector<std::string>* notes);

/// Fails where `row` has not `n` fields; `what` says what they are ("time and file name").
void RequireColumns(const TextRow& row, size_t n, const char* what);

/// Appends the time in `field`, in units of 10^`decimals` ns (9: seconds), or fails where it is negative or not after
/// the last one.
void AppendTime(const TextRow& row, size_t field, int decimals, std::vector<int64_t>* times_ns);

/// Throws DatasetError where the times of `path` lie apart as those of no camera do, more than 10 s or less than 0.1
/// ms in the median: then they are in another unit than 10^`decimals` ns, which the sentence names.
void CheckUnitOfTime(const std::string& path, int decimals, const std::vector<int64_t>& times_ns);

/// One time in seconds a line.
std::vector<int64_t> ReadTimes(const std::string& path);

/// What a table of times and image files lists, in its order.
struct Shots {
  std::vector<int64_t> times_ns;
  std::vector<std::string> files;
};

/// The table at `path`, one image a row: its time in units of 10^`decimals` ns (CheckUnitOfTime), which increases,
/// and its file, below `folder`; names of columns with commas are passed over. Fails where there are none, or where
/// rows do not have these two columns (called `columns` when they fail).
Shots ReadShots(const std::string& path, const std::string& folder, int decimals, const char* columns);

/// The file of `row.fields[field]`, which must lie below `folder`: no absolute path, no "..".
std::string FileBelow(const std::string& folder, const TextRow& row, size_t field);

}  // namespace plslam
