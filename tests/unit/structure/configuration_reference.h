// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace plslam::test {

/// Text of docs/configuration.md, from the option structs of all processes.
std::string ConfigurationReference();

/// Text of config/plslam.yaml: every option of every process at its default, with its meaning and bounds.
std::string ConfigurationFile();

}  // namespace plslam::test
