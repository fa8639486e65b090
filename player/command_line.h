// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/config/config.h"
#include "player/options.h"

namespace plslam::player {

/// The player's own command-line arguments, which override the configuration.
class PlayerCommandLine {
 public:
  /// `app` is a CLI::App*.
  void AddTo(void* app);
  PlayerOptions Options(const Config& config) const;

 private:
  std::optional<std::string> dataset_;
  std::optional<std::string> kind_;
  std::vector<std::string> topics_;
  std::optional<std::string> pace_;
  std::optional<int64_t> start_;
  std::optional<int64_t> stop_;
  std::optional<int64_t> stride_;
  std::optional<int64_t> loop_;
  bool bounce_ = false;
  bool skip_bad_ = false;
  bool exit_ = false;
  bool resume_ = false;
};

}  // namespace plslam::player
