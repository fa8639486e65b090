// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <string>
#include <vector>

namespace plslam::adapter {

/// Returns the channels of `url` on which images of a type that adapter reads arrive within this time, sorted; empty if
/// nothing can be received.
std::vector<std::string> ImageChannels(const std::string& url, std::chrono::milliseconds time);

}  // namespace plslam::adapter
