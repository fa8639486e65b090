#pragma once

#include <string>
#include <vector>

namespace plslam::test {

/// Text of docs/configuration.md, from the option structs of all processes.
std::string ConfigurationReference();

/// A rig that has a complete configuration of its own in config/.
struct RigConfiguration {
  std::string name;
  std::string meaning;
  /// What differs from the defaults.
  std::vector<std::string> overrides;
};
const std::vector<RigConfiguration>& RigConfigurations();

/// Text of config/NAME.yaml: every option of every process, with its meaning and bounds.
std::string RigYaml(const RigConfiguration& rig);

}  // namespace plslam::test
