// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/files/notes.h"
#include "core/files/text_rows.h"
#include "core/io/trajectories/trajectory.h"

namespace plslam {

/// `ForEachRow`, its errors as DatasetError.
void ForEachDatasetRow(const std::string& path, const std::function<void(const TextRow&)>& use);

/// Reads the truth at `path`; errors in it never keep a dataset from opening: invalid rows are skipped, and an
/// unreadable file counts as empty. `notes` reports this.
TrajectoryFile ReadTruth(const std::string& path, TrajectoryFormat format, Notes* notes);

/// Reads the poses of a truth in KITTI's format, a row for each of `n` frames; nullopt for invalid rows. Empty, with a
/// note, if the number of rows differs.
std::vector<std::optional<SE3>> TruthOfEachFrame(const std::string& path, size_t n, Notes* notes);

/// Fails if `row` does not have `n` fields; `what` describes them ("time and file name").
void RequireColumns(const TextRow& row, size_t n, const char* what);

/// Appends the time in `field`, in units of 10^`decimals` ns (9: seconds), or fails if it is negative or not after the
/// last one.
void AppendTime(const TextRow& row, size_t field, int decimals, std::vector<int64_t>* times_ns);

/// Throws DatasetError if the steps between the times of `path` are impossible for a camera, more than 10 s or less
/// than 0.1 ms in the median: then they are in another unit than 10^`decimals` ns, which the sentence names.
void CheckUnitOfTime(const std::string& path, int decimals, const std::vector<int64_t>& times_ns);

/// One time in seconds a line.
std::vector<int64_t> ReadTimes(const std::string& path);

/// Content of a table of times and image files, in its order.
struct Shots {
  std::vector<int64_t> times_ns;
  std::vector<std::string> files;
};

/// Reads the table at `path`, one image a row: its time in units of 10^`decimals` ns (CheckUnitOfTime), which
/// increases, and its file, below `folder`; a header row with commas is skipped. Fails if there are no rows, or if rows
/// do not have these two columns (called `columns` in the error).
Shots ReadShots(const std::string& path, const std::string& folder, int decimals, const char* columns);

/// The file of `row.fields[field]`, which must lie below `folder`: no absolute path, no "..".
std::string FileBelow(const std::string& folder, const TextRow& row, size_t field);

}  // namespace plslam
