// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>

#include "tools/plslam/run_options.h"

namespace plslam::launcher {

/// What would be found out only when the run is over, or would cost a file: that a file to write can be written
/// there, and is none of those that are read. Throws std::runtime_error with one sentence.
void CheckFilesToWrite(const RunOptions& options);

/// What the configuration file and `--set` say of the bus and the player counts where the command line says nothing:
/// it is put into `options`. Throws ConfigError for what no bus and no player takes, and std::runtime_error for what
/// does not go together.
void ReadConfiguration(RunOptions* options);

/// That the map to go on from is one, and whole. Throws std::runtime_error with one
/// sentence.
void CheckMapToGoOnFrom(const RunOptions& options);

/// That a run from cameras has the program for it, and no option of datasets. Throws std::runtime_error with one
/// sentence.
void CheckCameras(const RunOptions& options);

/// Now, as files that are written in the folder of outputs from here on will have it: times of files step by
/// milliseconds behind the clock, and a file server has a clock of its own. The folder exists. Throws
/// std::runtime_error where nothing can be written.
std::filesystem::file_time_type FileTimeNow(const RunOptions& options);

/// Removes what earlier runs have left in the folder of outputs, and in the one of recordings, since it must not be
/// taken for that of this run: what was written before `began`. What no run writes stays.
void RemoveOldOutputs(const RunOptions& options, std::filesystem::file_time_type began);

}  // namespace plslam::launcher
