// SPDX-License-Identifier: BSD-3-Clause
#include "core/datasets/yaml_map.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <iterator>
#include <optional>
#include <set>
#include <sstream>
#include <utility>

#include "core/datasets/dataset.h"
#include "core/errors/error_text.h"
#include "core/files/git_lfs.h"

namespace plslam {
namespace {

constexpr size_t kMaxBytes = 1'000'000;
constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
// Calibration files give six digits and more.
constexpr double kOrthogonalityTolerance = 1e-3;

bool IsPartOfKey(char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '.'; }

/// Returns the position after the colon of a line `key:value`; nullopt for other lines, or if a blank follows the
/// colon. `C:/...` and `http://...` are no keys.
std::optional<size_t> MissingBlank(std::string_view line) {
  const size_t begin = line.find_first_not_of(' ');
  if (begin == std::string_view::npos || std::isdigit(static_cast<unsigned char>(line[begin])) != 0) return {};
  size_t end = begin;
  while (end < line.size() && IsPartOfKey(line[end])) ++end;
  if (end == begin || end + 1 >= line.size() || line[end] != ':') return std::nullopt;
  constexpr std::string_view kNoValue = " \t\r:/\\";
  if (kNoValue.find(line[end + 1]) != std::string_view::npos) return std::nullopt;
  return end + 1;
}

/// OpenCV reads `key:value`, and files that its programs ship are written so. YAML takes such lines for text, and
/// complains of the line after them, or not at all.
std::string WithBlanksAfterColons(const std::string& text) {
  std::string result;
  result.reserve(text.size() + 16);
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    const std::optional<size_t> colon = MissingBlank(line);
    if (colon) line.insert(*colon, 1, ' ');
    result += line;
    if (!lines.eof()) result += '\n';
  }
  return result;
}

std::string ReadText(const std::string& path) {
  const std::string why = WhyUnreadable(path);
  if (!why.empty()) throw DatasetError(path + ": the calibration " + why);
  std::ifstream file(path, std::ios::binary);
  std::string text(kMaxBytes + 1, '\0');
  file.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<size_t>(file.gcount()));
  if (text.size() > kMaxBytes) throw DatasetError(fmt::format("{}: has more than {} bytes", path, kMaxBytes));
  if (IsGitLfsPointer(text)) throw DatasetError(path + ": " + kGitLfsPointer);
  if (text.starts_with(kByteOrderMark)) text.erase(0, kByteOrderMark.size());
  if (text.starts_with("%YAML")) text.front() = '#';
  return WithBlanksAfterColons(text);
}

[[noreturn]] void FailAsDuplicate(const std::string& path, const YAML::Node& key) {
  throw DatasetError(fmt::format("{}:{}: key '{}' is repeated", path, key.Mark().line + 1, Shown(key.Scalar())));
}

void RequireWords(const std::string& path, const YAML::Node& node) {
  for (const auto& entry : node) {
    if (entry.first.IsScalar()) continue;
    throw DatasetError(fmt::format("{}:{}: a key must be a word", path, entry.first.Mark().line + 1));
  }
}

}  // namespace

struct YamlMap::Entry {
  YAML::Node key, value;
};

YamlMap::YamlMap(std::string path, const YAML::Node& node) : path_(std::move(path)), node_(node) {
  if (!node_.IsMap()) {
    throw DatasetError(fmt::format("{}:{}: expected `key: value` lines", path_, node_.Mark().line + 1));
  }
  RequireWords(path_, node_);
}

YamlMap YamlMap::FromFile(const std::string& path) {
  const std::string text = ReadText(path);
  YAML::Node node;
  try {
    node = YAML::Load(text);
  } catch (const YAML::Exception& error) {
    throw DatasetError(YamlComplaint(path, text, error.mark.line, error.msg));
  }
  if (!node.IsDefined() || node.IsNull()) throw DatasetError(path + ": the calibration is empty");
  return {path, node};
}

// By hand, since operator[] of a missing key gives a node that throws at each touch.
std::optional<YamlMap::Entry> YamlMap::Find(const YAML::Node& map, std::string_view key) const {
  std::optional<Entry> found;
  for (const auto& entry : map) {
    if (!entry.first.IsScalar() || entry.first.Scalar() != key) continue;
    if (found) FailAsDuplicate(path_, entry.first);
    found = Entry{entry.first, entry.second};
  }
  const size_t dot = key.find('.');
  if (found || dot == std::string_view::npos) return found;
  const std::optional<Entry> outer = Find(map, key.substr(0, dot));
  return outer && outer->value.IsMap() ? Find(outer->value, key.substr(dot + 1)) : std::nullopt;
}

bool YamlMap::Has(std::string_view key) const { return Find(node_, key).has_value(); }

YAML::Node YamlMap::Get(std::string_view key) const {
  if (const std::optional<Entry> found = Find(node_, key)) return found->value;
  Fail(key, "is missing");
}

bool YamlMap::IsMap(std::string_view key) const {
  const std::optional<Entry> found = Find(node_, key);
  return found && found->value.IsMap();
}

bool YamlMap::IsListOfMaps(std::string_view key) const {
  const std::optional<Entry> found = Find(node_, key);
  if (!found || !found->value.IsSequence()) return false;
  return std::all_of(found->value.begin(), found->value.end(), [](const YAML::Node& node) { return node.IsMap(); });
}

std::string YamlMap::Text(std::string_view key) const {
  const YAML::Node node = Get(key);
  if (!node.IsScalar()) Fail(key, "must be a single value");
  return Shown(node.Scalar());
}

std::vector<std::string> YamlMap::Texts(std::string_view key) const {
  std::vector<std::string> texts = WholeTexts(key);
  for (std::string& text : texts) text = Shown(text);
  return texts;
}

std::vector<std::string> YamlMap::WholeTexts(std::string_view key) const {
  const YAML::Node node = Get(key);
  if (node.IsScalar()) return {node.Scalar()};
  if (!node.IsSequence()) Fail(key, "must be a word or a list of words");
  std::vector<std::string> texts;
  for (const YAML::Node& element : node) {
    if (!element.IsScalar()) Fail(key, "must be a word or a list of words");
    texts.push_back(element.Scalar());
  }
  return texts;
}

double YamlMap::ToNumber(std::string_view key, const YAML::Node& node) const {
  if (!node.IsScalar()) Fail(key, "must consist of numbers");
  std::string_view text = node.Scalar();
  if (text.starts_with('+')) text.remove_prefix(1);
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || text.empty() || !std::isfinite(value)) {
    Fail(key, fmt::format("= '{}' is not a finite number", Shown(node.Scalar())));
  }
  return value;
}

double YamlMap::Number(std::string_view key) const { return ToNumber(key, Get(key)); }

std::vector<double> YamlMap::Numbers(std::string_view key, size_t min_count, size_t max_count) const {
  const YAML::Node node = Get(key);
  if (!node.IsSequence()) Fail(key, "must be a list of numbers [a, b, ...]");
  if (node.size() < min_count || node.size() > max_count) {
    Fail(key, fmt::format("has {} numbers, not {}", node.size(),
                          min_count == max_count ? fmt::format("{}", min_count)
                                                 : fmt::format("{} to {}", min_count, max_count)));
  }
  std::vector<double> numbers;
  for (const YAML::Node& element : node) numbers.push_back(ToNumber(key, element));
  return numbers;
}

std::vector<std::vector<Eigen::Vector2d>> YamlMap::Polygons(std::string_view key) const {
  const YAML::Node node = Get(key);
  if (!node.IsSequence()) Fail(key, "must be a list of polygons [[[x, y], [x, y], [x, y], ...], ...]");
  std::vector<std::vector<Eigen::Vector2d>> polygons;
  for (const YAML::Node& outline : node) {
    const std::string name = fmt::format("polygon {}", polygons.size() + 1);
    if (!outline.IsSequence()) Fail(key, name + " is not a list of corners [[x, y], [x, y], [x, y], ...]");
    if (outline.size() < 3)
      Fail(key, fmt::format("{} has {} corners, but at least 3 are needed", name, outline.size()));
    std::vector<Eigen::Vector2d> corners;
    for (const YAML::Node& corner : outline) {
      if (!corner.IsSequence() || corner.size() != 2) {
        Fail(key, fmt::format("{}, corner {} is not a pair [x, y]", name, corners.size() + 1));
      }
      corners.emplace_back(ToNumber(key, *corner.begin()), ToNumber(key, *std::next(corner.begin())));
    }
    polygons.push_back(std::move(corners));
  }
  return polygons;
}

YamlMap YamlMap::Map(std::string_view key) const {
  const YAML::Node node = Get(key);
  if (!node.IsMap()) Fail(key, "must contain `key: value` lines");
  return {path_, node};
}

std::vector<YamlMap> YamlMap::Maps(std::string_view key) const {
  const YAML::Node node = Get(key);
  if (!node.IsSequence()) Fail(key, "must be a list of maps");
  std::vector<YamlMap> maps;
  for (const YAML::Node& element : node) maps.push_back(YamlMap(path_, element));
  return maps;
}

std::vector<std::pair<int, YamlMap>> YamlMap::NumberedMaps(std::string_view key) const {
  const YAML::Node node = Get(key);
  if (!node.IsSequence()) Fail(key, "must be a list of pairs [number, map]");
  std::vector<std::pair<int, YamlMap>> maps;
  for (const YAML::Node& element : node) {
    if (!element.IsSequence() || element.size() != 2) Fail(key, "must be a list of pairs [number, map]");
    const double number = ToNumber(key, *element.begin());
    if (!(number >= 0.0 && number <= 100.0 && number == std::floor(number))) {
      Fail(key, fmt::format("has the number {}, which is not from 0 to 100", number));
    }
    maps.emplace_back(static_cast<int>(number), YamlMap(path_, *std::next(element.begin())));
  }
  return maps;
}

std::vector<double> YamlMap::Matrix(std::string_view key, size_t min_count, size_t max_count,
                                    size_t n_columns) const {
  const YAML::Node node = Get(key);
  if (node.IsMap()) return Map(key).Numbers("data", min_count, max_count);
  if (!node.IsSequence() || node.size() == 0 || !node.begin()->IsSequence()) {
    return Numbers(key, min_count, max_count);
  }
  std::vector<double> numbers;
  if (n_columns == 0) n_columns = node.begin()->size();
  for (const YAML::Node& row : node) {
    if (!row.IsSequence() || row.size() != n_columns || numbers.size() > max_count) {
      Fail(key, fmt::format("must have rows of {} numbers, {} to {} in all", n_columns, min_count, max_count));
    }
    for (const YAML::Node& element : row) numbers.push_back(ToNumber(key, element));
  }
  if (numbers.size() < min_count || numbers.size() > max_count) {
    Fail(key, fmt::format("has {} numbers, not {} to {}", numbers.size(), min_count, max_count));
  }
  return numbers;
}

SE3 YamlMap::Transform(std::string_view key) const {
  const std::vector<double> rows = Matrix(key, 12, 16, 4);
  SE3 T;
  const std::string complaint = TransformFrom(rows, &T);
  if (!complaint.empty()) Fail(key, complaint);
  return T;
}

void YamlMap::AllowOnly(const std::vector<std::string>& known) const {
  std::set<std::string> keys;
  for (const auto& entry : node_) {
    const std::string& key = entry.first.Scalar();
    if (!keys.insert(key).second) FailAsDuplicate(path_, entry.first);
    if (std::find(known.begin(), known.end(), key) != known.end()) continue;
    Fail(key, fmt::format("is not a known key ({})", fmt::join(known, ", ")));
  }
}

std::string YamlMap::Place(std::string_view key) const {
  const std::optional<Entry> found = Find(node_, key);
  return fmt::format("{}:{}", path_, (found ? found->key.Mark().line : node_.Mark().line) + 1);
}

void YamlMap::Fail(std::string_view key, const std::string& what) const {
  throw DatasetError(fmt::format("{}: {} {}", Place(key), Shown(std::string(key)), what));
}

void YamlMap::Require(std::string_view key, const std::string& complaint) const {
  if (!complaint.empty()) Fail(key, "is not usable: " + complaint);
}

std::string TransformFrom(const std::vector<double>& rows, SE3* T) {
  if (rows.size() != 12 && rows.size() != 16) return fmt::format("has {} numbers, not 12 or 16", rows.size());
  Eigen::Matrix<double, 3, 4> m;
  for (int i = 0; i < 12; ++i) m(i / 4, i % 4) = rows[static_cast<size_t>(i)];
  const Eigen::Matrix3d R = m.leftCols<3>();
  const double error = (R * R.transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
  if (!(error <= kOrthogonalityTolerance) || !(R.determinant() > 0.0)) {
    return fmt::format("is not a rotation (determinant {:.6g}, off by {:.3g}, at most {})", R.determinant(), error,
                       kOrthogonalityTolerance);
  }
  if (!m.col(3).allFinite()) return "is not finite";
  if (rows.size() == 16 && (rows[12] != 0.0 || rows[13] != 0.0 || rows[14] != 0.0 || rows[15] != 1.0)) {
    return fmt::format("has a last row {} {} {} {}, not 0 0 0 1", rows[12], rows[13], rows[14], rows[15]);
  }
  *T = SE3(R, Eigen::Vector3d(m.col(3)));
  return "";
}

}  // namespace plslam
