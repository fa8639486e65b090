// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>

#include "tools/plslam/run_options.h"

namespace plslam::launcher {

/// Checks early for errors that would otherwise appear at the end of the run, or cost a file: each output file can be
/// written, and is not one of the input files. Throws std::runtime_error with one sentence.
void CheckFilesToWrite(const RunOptions& options);

/// Copies the bus and player options of the configuration file and `--set` to `options`, except for those given on the
/// command line. Throws ConfigError for invalid values, and std::runtime_error for contradictory ones.
void ReadConfiguration(RunOptions* options);

/// Checks that each `--set` has an effect: this run starts the process, and no other option of `plslam run` overrides
/// the value. Throws std::runtime_error with one sentence.
void CheckOverrides(const RunOptions& options);

/// Checks that the map to continue is a complete map file. Throws std::runtime_error with one sentence.
void CheckMapToContinue(const RunOptions& options);

/// Checks that dense_process is installed if it is requested. Throws std::runtime_error with one sentence.
void CheckSurfaces(const RunOptions& options);

/// Checks that a map that is to be refined is saved in the folder of the run, by default as map.plmap. Throws
/// std::runtime_error with one sentence.
void CheckRefinement(RunOptions* options);

/// Checks that the program for a run from cameras, or from a robot, is installed, and that no option of datasets is given. Throws
/// std::runtime_error with one sentence.
void CheckLive(const RunOptions& options);

/// Returns the current time as files in the output folder will have it: file times advance in steps of milliseconds and
/// lag behind the clock, and a file server has its own clock. The folder must exist. Throws std::runtime_error if no
/// file can be written.
std::filesystem::file_time_type FileTimeNow(const RunOptions& options);

/// Removes the results of earlier runs, written before `began`, from the output folder and the recording's folder,
/// since they must not be mistaken for results of this run. Other files are kept.
void RemoveOldOutputs(const RunOptions& options, std::filesystem::file_time_type began);

}  // namespace plslam::launcher
