// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "core/datasets/recordings/recording.h"
#include "core/datasets/recordings/zstd_frames.h"

namespace plslam {

/// A recording of `ros2 bag record`: a .db3 file, or a folder of .db3 or .mcap files, one after the other. Files may be
/// compressed (.db3.zstd, .mcap.zstd), and messages too.
///
/// The order of the files is that of metadata.yaml, else that of the last number in their names. A listed file that is
/// missing is reported by `Notes`, as is a damaged metadata.yaml, which is not needed.
class Ros2Bag : public Recording {
 public:
  /// With a non-empty `why_scan` the indices of .mcap files are not used (`DamagedIndex`).
  explicit Ros2Bag(const std::string& path, const std::string& why_scan = "");

  const std::vector<RecordedChannel>& channels() const override { return channels_; }
  std::vector<RecordedMessage> Messages(const std::string& topic) const override;
  plslam::Notes Notes() const override { return notes_; }
  double scan_s() const override;
  std::vector<uint8_t> Read(const RecordedMessage& message) const override;
  std::vector<uint8_t> ReadBegin(const RecordedMessage& message, uint64_t n) const override;
  void WillReadBegin(const RecordedMessage& message, uint64_t n) const override;
  uint64_t DecompressionCost(uint32_t chunk) const override;

 private:
  struct Part {
    std::string name;
    std::unique_ptr<UnzstdFile> unpacked;  ///< removed after its reader
    std::unique_ptr<Recording> reader;
  };

  void Open(const std::string& path, const std::string& name, const std::string& why_scan);
  const Part& PartOf(uint32_t chunk) const;

  std::vector<Part> parts_;
  std::vector<RecordedChannel> channels_;
  plslam::Notes notes_;
};

/// It is a .db3 file, or a folder with .db3 files, with the metadata.yaml of a bag, or with nothing but .mcap files.
bool LooksLikeRos2BagPath(const std::string& path);

}  // namespace plslam
