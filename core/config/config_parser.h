// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <set>
#include <string>

#include <yaml-cpp/yaml.h>

#include "core/config/config.h"

namespace plslam {

/// Flattens YAML into the entries of a Config, and rejects duplicate keys and invalid structures.
class ConfigParser {
 public:
  /// `name` is the name of the file in messages.
  explicit ConfigParser(const std::string& name) : name_(name) {}

  Config ParseFile(const std::string& yaml);
  /// "section.key=value", the value as YAML.
  static Config::Entry ParseAssignment(const std::string& assignment);

 private:
  void AddMap(const std::string& prefix, const YAML::Node& map);
  static void SetValue(const YAML::Node& value, Config::Entry* entry);
  std::string Place(const YAML::Node& node) const;

  std::string name_;
  std::set<std::string> seen_;
  Config config_;
};

}  // namespace plslam
