// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>

#include "adapter/options.h"
#include "core/config/config.h"

namespace plslam::adapter {

/// The adapter's own command-line arguments, which override the configuration.
class AdapterCommandLine {
 public:
  /// `app` is a CLI::App*.
  void AddTo(void* app);
  /// Throws std::runtime_error where the options name no images, or both kinds of them.
  AdapterOptions Options(const Config& config) const;

 private:
  std::optional<std::string> foreign_url_;
  std::optional<std::string> camera_;
  std::optional<std::string> images_;
  std::optional<std::string> left_;
  std::optional<std::string> right_;
};

}  // namespace plslam::adapter
