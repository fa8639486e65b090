// SPDX-License-Identifier: BSD-3-Clause
#include "tools/plslam/yaml_to_json.h"

#include <yaml-cpp/yaml.h>

#include <charconv>

namespace plslam::launcher {
namespace {

template <class T>
bool Parses(const std::string& text, T* value) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), *value);
  return error == std::errc() && end == text.data() + text.size();
}

nlohmann::json Convert(const YAML::Node& node) {
  if (node.IsNull()) return nullptr;
  if (node.IsMap()) {
    auto object = nlohmann::json::object();
    for (const auto& item : node) object[item.first.Scalar()] = Convert(item.second);
    return object;
  }
  if (node.IsSequence()) {
    auto list = nlohmann::json::array();
    for (const YAML::Node& item : node) list.push_back(Convert(item));
    return list;
  }
  const std::string& text = node.Scalar();
  int64_t whole = 0;
  double number = 0.0;
  if (node.Tag() == "!") return text;  // quoted
  if (text == "true" || text == "false") return text == "true";
  if (Parses(text, &whole)) return whole;
  if (Parses(text, &number)) return number;
  return text;
}

}  // namespace

nlohmann::json YamlToJson(const std::string& yaml) {
  try {
    return Convert(YAML::Load(yaml));
  } catch (const YAML::Exception&) {
    return yaml;
  }
}

}  // namespace plslam::launcher
