// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <charconv>
#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/config/config.h"
#include "core/config/nearest_key.h"
#include "core/errors/error_text.h"

namespace plslam {
namespace {

/// Parses all of `text` as a number into `value`. invalid_argument: it is not a number; result_out_of_range: too large
/// for the type.
template <class T>
std::errc ParseNumber(const std::string& text, T* value) {
  const char* first = text.data();
  const char* last = first + text.size();
  if (text.size() > 1 && text[0] == '+' && text[1] != '-') ++first;
  const auto [end, error] = std::from_chars(first, last, *value);
  return end == last ? error : std::errc::invalid_argument;
}

bool StartsWith(const std::string& text, const std::string& start) { return text.rfind(start, 0) == 0; }

}  // namespace

/// Writes one entry to its field, or throws a sentence about its error.
class FieldReader {
 public:
  using Entry = Config::Entry;
  explicit FieldReader(const Entry& entry) : entry_(entry) {}

  void Into(const Field& field) {
    field_ = &field;
    std::visit([this](const auto& value) { Set(value); }, field.value);
  }

 private:
  [[noreturn]] void Fail(const std::string& what) const {
    throw ConfigError(fmt::format("{}: key '{}' {}", entry_.origin, Shown(entry_.key), what));
  }

  const std::string& Scalar(const char* wanted) const {
    if (entry_.kind == Entry::Kind::kNothing) Fail(fmt::format("has no value; it must be {}", wanted));
    if (entry_.kind == Entry::Kind::kList) Fail(fmt::format("is a list; it must be {}", wanted));
    return entry_.scalar;
  }

  template <class T>
  T Number(const std::string& text, const char* wanted) const {
    T value{};
    const std::errc error = ParseNumber(text, &value);
    if (error == std::errc::invalid_argument) Fail(fmt::format("is '{}'; it must be {}", Shown(text), wanted));
    const double number = static_cast<double>(value);
    if (error != std::errc() || !std::isfinite(number) ||
        !(number >= field_->bounds.min && number <= field_->bounds.max)) {
      Fail(fmt::format("is {}; it must be in [{}, {}]", Shown(text), field_->bounds.min, field_->bounds.max));
    }
    return value;
  }

  void Set(bool* value) const {
    const std::string& text = Scalar("true or false");
    if (text != "true" && text != "false") Fail(fmt::format("is '{}'; it must be true or false", Shown(text)));
    *value = text == "true";
  }
  void Set(int* value) const { *value = Number<int>(Scalar("a whole number"), "a whole number"); }
  void Set(int64_t* value) const { *value = Number<int64_t>(Scalar("a whole number"), "a whole number"); }
  void Set(double* value) const { *value = Number<double>(Scalar("a number"), "a number"); }

  void Set(std::string* value) const { *value = Text(); }
  void Set(const NamedValue& value) const { value.set(Text()); }

  const std::string& Text() const {
    const std::string& text = Scalar("a text");
    const auto& choices = field_->choices;
    if (!choices.empty() && std::find(choices.begin(), choices.end(), text) == choices.end()) {
      Fail(fmt::format("is '{}'; it must be one of {}", Shown(text), fmt::join(choices, ", ")));
    }
    return text;
  }

  void Set(std::vector<double>* value) const {
    if (entry_.kind != Entry::Kind::kList) Fail("must be a list of numbers, like [1, 2.5]");
    value->clear();
    for (const std::string& text : entry_.list) value->push_back(Number<double>(text, "a list of numbers"));
  }

  const Entry& entry_;
  const Field* field_ = nullptr;
};

void Config::ReadFields(const std::string& section, const std::vector<Field>& fields) const {
  std::vector<std::string> known;
  known.reserve(fields.size());
  for (const Field& field : fields) known.push_back(section + "." + field.key);
  for (const Entry& entry : entries_) {
    if (entry.key != section && !StartsWith(entry.key, section + ".")) continue;
    const auto exact = std::find(known.begin(), known.end(), entry.key);
    if (exact != known.end()) {
      FieldReader(entry).Into(fields[exact - known.begin()]);
      continue;
    }
    const bool is_group = entry.key == section || std::any_of(known.begin(), known.end(), [&](const auto& key) {
                            return StartsWith(key, entry.key + ".");
                          });
    if (is_group && entry.kind == Entry::Kind::kNothing) continue;  // all of its keys are commented out
    if (is_group) {
      throw ConfigError(fmt::format("{}: key '{}' is a group of keys and has no value", entry.origin, entry.key));
    }
    throw ConfigError(fmt::format("{}: unknown key '{}'; the nearest known one is '{}'", entry.origin,
                                  Shown(entry.key), NearestKey(entry.key, known)));
  }
}

void Config::RequireSections(std::span<const std::string_view> known) const {
  for (const Entry& entry : entries_) {
    const std::string section = entry.key.substr(0, entry.key.find('.'));
    if (std::find(known.begin(), known.end(), section) != known.end()) continue;
    throw ConfigError(fmt::format("{}: unknown section '{}'; the nearest known one is '{}'", entry.origin,
                                  Shown(section), NearestKey(section, {known.begin(), known.end()})));
  }
}

}  // namespace plslam
