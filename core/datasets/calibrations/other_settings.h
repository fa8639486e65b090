// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "core/datasets/yaml_map.h"

namespace plslam {

// Files that people give for a calibration, or have beside their images, and that are none of a stereo pair: what they
// are, and what to give instead, as a phrase behind their name. Empty for all others.

/// Of a file that is no YAML.
std::string WhyOtherText(const std::string& path);
/// Of YAML and JSON.
std::string WhyOtherSettings(const YamlMap& file);

}  // namespace plslam
