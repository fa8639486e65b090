// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "core/config/field_list.h"
#include "core/config/fields.h"

namespace plslam {

/// First-level keys of a configuration file, one for each process or shared part.
inline constexpr const char* kBusSection = "bus";
inline constexpr std::string_view kConfigSections[] = {kBusSection, "player", "camera", "adapter", "vo",  "mapping",
                                                       "loop",      "viewer", "dense",  "bridge",  "ros2"};

/// A bad configuration, in one sentence that names file, line, key, value and bound (or the nearest known key).
class ConfigError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// One YAML file (or none) plus `key=value` overrides, with dotted keys ("vo.features.orb.max_points=800"). The first
/// level of the file are sections, one for each process or shared part: `bus:`, `vo:`, `player:`, `viewer:`.
///
/// Strict: duplicate keys, wrong types, values out of bounds and keys that no option struct of their section has are
/// `ConfigError`s. Sections of other processes are not checked, so that one file serves all processes.
class Config {
 public:
  /// Empty: every option keeps its default.
  Config() = default;

  static Config FromFile(const std::string& path);
  /// `name` is the name of the file in messages.
  static Config FromString(const std::string& yaml, const std::string& name);

  /// Later overrides win over the file and over earlier ones.
  void Override(const std::string& assignment);

  /// Fills `options` from `section`; options that the file does not have keep their default.
  template <class Options>
  void Read(const std::string& section, Options& options) const {
    ReadFields(section, ListFields(options));
  }
  void ReadFields(const std::string& section, const std::vector<Field>& fields) const;

  /// Throws if the first level has a key that is not in `known`.
  void RequireSections(std::span<const std::string_view> known) const;

 private:
  /// A leaf of the file, or an override.
  struct Entry {
    std::string key;  ///< dotted, with the section
    enum class Kind { kNothing, kScalar, kList } kind = Kind::kNothing;
    std::string scalar;
    std::vector<std::string> list;
    std::string origin;  ///< "rig.yaml:12" or "override 'vo.x=1'"
  };
  friend class ConfigParser;
  friend class FieldReader;

  std::vector<Entry> entries_;
};

/// All fields with their values as YAML (`section:` on top), for status messages and for files a user can edit. With
/// `comments`, the meaning and the bounds of each option precede it.
std::string FieldsToYaml(const std::string& section, const std::vector<Field>& fields, bool comments = false);
/// The same as a Markdown table: key, default, bounds, meaning.
std::string FieldsToMarkdown(const std::string& section, const std::vector<Field>& fields);

template <class Options>
std::string ToYaml(const std::string& section, Options& options, bool comments = false) {
  return FieldsToYaml(section, ListFields(options), comments);
}

template <class Options>
std::string ToMarkdown(const std::string& section, Options& options) {
  return FieldsToMarkdown(section, ListFields(options));
}

}  // namespace plslam
