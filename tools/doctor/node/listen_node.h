// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <string>

#include "tools/doctor/heard_process.h"

namespace plslam::doctor {

/// Listens to all channels of `url` for `duration`, regardless of their prefix, version or key, and publishes nothing.
/// `key_file`: the key that messages are checked with; empty: none. Throws std::runtime_error with one sentence if the
/// URL cannot be opened or the key not be read.
Heard ListenToAll(const std::string& url, const std::string& key_file, std::chrono::milliseconds duration);

}  // namespace plslam::doctor
