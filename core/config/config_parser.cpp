// SPDX-License-Identifier: BSD-3-Clause
#include "core/config/config_parser.h"

#include <algorithm>

#include <fmt/format.h>

#include "core/errors/error_text.h"

namespace plslam {
namespace {

constexpr int kMaxDepth = 16;
constexpr size_t kMaxBytes = 1'000'000;

std::string ReadText(const std::string& path) {
  std::ifstream file = OpenInput(path);
  std::string text(kMaxBytes + 1, '\0');
  file.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<size_t>(file.gcount()));
  if (text.empty()) throw ConfigError(path + ": is empty (0 bytes)");
  if (text.size() > kMaxBytes) {
    throw ConfigError(fmt::format("{}: has more than {} bytes, too many for a configuration", path, kMaxBytes));
  }
  return text;
}

}  // namespace

std::string ConfigParser::Place(const YAML::Node& node) const {
  return fmt::format("{}:{}", name_, node.Mark().line + 1);
}

Config ConfigParser::ParseFile(const std::string& yaml) {
  std::vector<YAML::Node> documents;
  try {
    documents = YAML::LoadAll(yaml);
  } catch (const YAML::Exception& error) {
    throw ConfigError(YamlComplaint(name_, yaml, error.mark.line, error.msg));
  }
  if (documents.size() > 1) throw ConfigError(fmt::format("{}: has more than one YAML document", name_));
  if (documents.empty() || documents[0].IsNull()) return std::move(config_);
  if (!documents[0].IsMap()) throw ConfigError(fmt::format("{}: must be a map of sections", Place(documents[0])));
  AddMap("", documents[0]);
  return std::move(config_);
}

void ConfigParser::AddMap(const std::string& prefix, const YAML::Node& map) {
  // An alias may refer to a node that contains it.
  if (std::count(prefix.begin(), prefix.end(), '.') > kMaxDepth) {
    throw ConfigError(fmt::format("{}: keys are nested more than {} deep", Place(map), kMaxDepth));
  }
  for (const auto& item : map) {
    if (!item.first.IsScalar()) throw ConfigError(fmt::format("{}: a key must be a word", Place(item.first)));
    Config::Entry entry;
    entry.key = prefix + item.first.Scalar();
    entry.origin = Place(item.first);
    if (!seen_.insert(entry.key).second) {
      throw ConfigError(fmt::format("{}: key '{}' is repeated", entry.origin, Shown(entry.key)));
    }
    if (item.second.IsMap() && item.second.size() > 0) {
      AddMap(entry.key + ".", item.second);
      continue;
    }
    SetValue(item.second, &entry);
    config_.entries_.push_back(std::move(entry));
  }
}

void ConfigParser::SetValue(const YAML::Node& value, Config::Entry* entry) {
  using Kind = Config::Entry::Kind;
  if (value.IsScalar()) {
    entry->kind = Kind::kScalar;
    entry->scalar = value.Scalar();
  } else if (value.IsSequence()) {
    entry->kind = Kind::kList;
    for (const YAML::Node& item : value) {
      if (!item.IsScalar()) {
        throw ConfigError(
            fmt::format("{}: key '{}' must be a list of single values", entry->origin, Shown(entry->key)));
      }
      entry->list.push_back(item.Scalar());
    }
  }
}

Config::Entry ConfigParser::ParseAssignment(const std::string& assignment) {
  const std::string place = fmt::format("override '{}'", Shown(assignment));
  const size_t equals = assignment.find('=');
  const size_t dot = assignment.find('.');
  if (equals == std::string::npos || dot == std::string::npos || dot == 0 || dot + 1 >= equals) {
    throw ConfigError(place + ": must be SECTION.KEY=VALUE");
  }
  Config::Entry entry;
  entry.key = assignment.substr(0, equals);
  entry.origin = place;
  const std::string text = assignment.substr(equals + 1);
  if (text.empty() || text[0] != '[') {
    // A word is taken literally, so that URLs and paths need no quotes of YAML within those of the shell.
    entry.kind = Config::Entry::Kind::kScalar;
    entry.scalar = text;
    return entry;
  }
  try {
    SetValue(YAML::Load(text), &entry);
  } catch (const YAML::Exception& error) {
    throw ConfigError(fmt::format("{}: not valid YAML: {}", place, error.msg));
  }
  return entry;
}

Config Config::FromString(const std::string& yaml, const std::string& name) {
  return ConfigParser(name).ParseFile(yaml);
}

Config Config::FromFile(const std::string& path) {
  try {
    return FromString(ReadText(path), path);
  } catch (const ConfigError&) {
    throw;
  } catch (const std::runtime_error& error) {
    throw ConfigError(error.what());
  }
}

void Config::Override(const std::string& assignment) {
  entries_.push_back(ConfigParser::ParseAssignment(assignment));
}

}  // namespace plslam
