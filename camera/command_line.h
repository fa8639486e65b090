// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>

#include "camera/options.h"
#include "core/config/config.h"

namespace plslam::camera {

/// The camera's own command-line arguments, which override the configuration.
class CameraCommandLine {
 public:
  /// `app` is a CLI::App*.
  void AddTo(void* app);
  CameraOptions Options(const Config& config) const;

 private:
  std::optional<std::string> rig_;
  std::optional<std::string> pace_;
  bool exit_ = false;
  bool resume_ = false;
};

}  // namespace plslam::camera
