// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "core/datasets/yaml_map.h"

namespace plslam {

// Files that users give as a calibration, or have beside their images, and that are not of a stereo pair. The phrases
// follow the name of the file and say what it is and what to give instead; they are empty for all other files.

/// Returns the phrase for a file that is no YAML.
std::string WhyOtherText(const std::string& path);
/// Returns the phrase for YAML and JSON.
std::string WhyOtherSettings(const YamlMap& file);

}  // namespace plslam
