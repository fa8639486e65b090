// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "core/datasets/yaml_map.h"

namespace plslam {

// Files that users mistake for a calibration of a stereo pair, or have beside their images. The phrases follow the name
// of the file and give its type and the remedy; they are empty for all other files.

/// Returns the phrase for a file that is no YAML.
std::string WhyOtherText(const std::string& path);
/// Returns the phrase for YAML and JSON.
std::string WhyOtherSettings(const YamlMap& file);

}  // namespace plslam
