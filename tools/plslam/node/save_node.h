// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <string>

#include "core/bus/bus.h"

namespace plslam {
class status_t;
}  // namespace plslam

namespace plslam::launcher {

/// The sentence for a bus on which no mapping_process has been heard for so long.
std::string NobodyHeard(const bus::BusOptions& options, std::chrono::seconds waited);

/// Asks mapping_process to save its map, and hears from its status how that went.
class SaveNode {
 public:
  enum class Result { kPending, kSaved, kFailed };

  /// Subscribes; `Bus::Run` delivers.
  explicit SaveNode(bus::Bus& bus);

  /// Once mapping_process has been heard: sends the order, the first time. `path` is absolute, on the machine of
  /// mapping_process.
  void Send(const std::filesystem::path& path);

  bool heard() const { return heard_; }
  Result result() const { return result_; }
  /// What mapping_process said of a failed save.
  const std::string& reason() const { return reason_; }

 private:
  void OnStatus(const status_t& message);

  bus::Bus& bus_;
  bool heard_ = false;
  bool sent_ = false;
  /// Of the process, before the order: its id, and what it had saved and failed to save.
  int64_t pid_ = 0;
  double saves_ = 0.0;
  double failed_ = 0.0;
  Result result_ = Result::kPending;
  std::string reason_;
};

}  // namespace plslam::launcher
