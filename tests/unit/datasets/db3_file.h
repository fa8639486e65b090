// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>

#include "tests/unit/datasets/tiny_recording.h"

namespace plslam::test {

/// Form of a tiny bag of ROS 2, other than that of its messages.
struct Ros2BagOptions {
  bool split = false;       ///< a file for each frame
  bool zstd_files = false;  ///< FILE.db3.zstd
  bool zstd_messages = false;
  bool metadata = true;            ///< metadata.yaml
  std::string extension = ".db3";  ///< or ".mcap"
};

/// Executes SQL on an SQLite file, which is created if it is missing.
void ExecuteSql(const std::filesystem::path& path, const std::string& sql);

/// A tiny valid .db3 file with the content of `MakeMcapFile`; `frame` alone if it is not negative.
void MakeDb3File(const std::filesystem::path& path, const RecordingOptions& options = {}, bool zstd_messages = false,
                 int frame = -1);

/// The same as a killed recorder leaves it: the second half of the messages is in the write-ahead log beside it.
void MakeDb3FileWithLog(const std::filesystem::path& path);

/// A folder as `ros2 bag record` writes it: walk_0.db3 and so on, and metadata.yaml.
void MakeRos2Bag(const std::filesystem::path& folder, const Ros2BagOptions& form = {},
                 const RecordingOptions& options = {});

}  // namespace plslam::test
