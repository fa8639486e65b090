#pragma once

#include <stdexcept>
#include <string>
#include <vector>

#include "core/config/fields.h"

namespace plslam {

/// A bad configuration, in one sentence that names file, line, key, value and bound (or the nearest known key).
class ConfigError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// One YAML file (or none) plus `key=value` overrides, with dotted keys ("vo.orb.max_points=800"). The first level
/// of the file are sections, one for each process or shared part: `bus:`, `vo:`, `player:`, `viewer:`.
///
/// Strict: duplicate keys, wrong types, values out of bounds and keys that no option struct of their section has are
/// `ConfigError`s. Sections of other processes are not looked at, so that one file serves all processes.
class Config {
 public:
  Config();
  ~Config();
  Config(Config&&) noexcept;
  Config& operator=(Config&&) noexcept;

  static Config FromFile(const std::string& path);
  static Config FromString(const std::string& yaml, const std::string& name);

  /// Later overrides win over the file and over earlier ones.
  void Override(const std::string& assignment);

  /// Fills `options` from `section`; what the file does not name keeps its default.
  template <class Options>
  void Read(const std::string& section, Options& options) const;

 private:
  struct Data;
  Data* data_;
};

/// All fields with their values as YAML (`section:` on top), for status messages and for files a user can edit.
template <class Options>
std::string ToYaml(const std::string& section, Options& options);

/// The same as a Markdown table: key, default, bounds, meaning.
template <class Options>
std::string ToMarkdown(const std::string& section, Options& options);

}  // namespace plslam
