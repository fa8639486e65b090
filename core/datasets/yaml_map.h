// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <yaml-cpp/yaml.h>

#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/geometry/se3.h"

namespace plslam {

/// A map of a YAML calibration file, read strictly. Every error is a DatasetError `FILE:LINE: KEY...`. Files above 1
/// MB, duplicates of a key that is read, and non-finite numbers are rejected. Two habits of OpenCV's reader are
/// supported: a first line `%YAML:1.0` is skipped, and `key:value` needs no blank.
///
/// A key with dots matches itself as well as a nested map: `Camera.fx` is the line `Camera.fx: 400` or the `fx` below
/// `Camera:`.
class YamlMap {
 public:
  static YamlMap FromFile(const std::string& path);

  bool Has(std::string_view key) const;
  std::string Text(std::string_view key) const;
  /// One word, or a list of words.
  std::vector<std::string> Texts(std::string_view key) const;
  /// The words without truncation: `Text` and `Texts` are made for display, and truncate long words.
  std::vector<std::string> WholeTexts(std::string_view key) const;
  double Number(std::string_view key) const;
  /// A list of `min_count` to `max_count` numbers.
  std::vector<double> Numbers(std::string_view key, size_t min_count, size_t max_count) const;
  /// A list of polygons, each a list of at least three corners [x, y].
  std::vector<std::vector<Eigen::Vector2d>> Polygons(std::string_view key) const;
  YamlMap Map(std::string_view key) const;
  /// A list of maps.
  std::vector<YamlMap> Maps(std::string_view key) const;
  /// A list of pairs [number, map], numbers from 0 to 100.
  std::vector<std::pair<int, YamlMap>> NumberedMaps(std::string_view key) const;
  /// Return whether the key holds a map, or a list of maps, respectively; false also without the key.
  bool IsMap(std::string_view key) const;
  bool IsListOfMaps(std::string_view key) const;
  /// Returns `min_count` to `max_count` numbers, row by row: a list of them, a list for each row (of `n_columns`,
  /// unless 0), or a map with the list in `data` (OpenCV, ROS).
  std::vector<double> Matrix(std::string_view key, size_t min_count, size_t max_count, size_t n_columns = 0) const;

  /// Returns a rigid transform from 12 or 16 numbers, row by row; `Fail`s for an invalid rotation or if the last row is
  /// not 0 0 0 1. `key` may also hold a map with the list in `data` (ASL, OpenCV), or a list for each row (Kalibr).
  SE3 Transform(std::string_view key) const;

  /// `Fail`s at a key that is not among `known`.
  void AllowOnly(const std::vector<std::string>& known) const;

  /// Returns `FILE:LINE` of the key (or of the map, if it is absent).
  std::string Place(std::string_view key) const;

  /// Throws `FILE:LINE: KEY WHAT`, at the line of the key (or of the map, if it is absent).
  [[noreturn]] void Fail(std::string_view key, const std::string& what) const;

  /// `Fail`s if `complaint` is not empty.
  void Require(std::string_view key, const std::string& complaint) const;

  const std::string& path() const { return path_; }

 private:
  YamlMap(std::string path, const YAML::Node& node);
  struct Entry;
  /// Returns the entry of this key; nullopt if there is none.
  std::optional<Entry> Find(const YAML::Node& map, std::string_view key) const;
  YAML::Node Get(std::string_view key) const;
  double ToNumber(std::string_view key, const YAML::Node& node) const;

  std::string path_;
  YAML::Node node_;
};

/// Sets a rigid transform from 12 or 16 numbers, row by row; returns an error, or an empty string.
std::string TransformFrom(const std::vector<double>& rows, SE3* T);

}  // namespace plslam
