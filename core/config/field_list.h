// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "core/config/choices.h"
#include "core/config/fields.h"

namespace plslam {

/// An option that is an enum, by the names of its values.
struct NamedValue {
  std::function<std::string()> name;
  /// Takes one of the names.
  std::function<void(const std::string&)> set;
};

/// One option: the address of its value, its bounds, and its meaning.
struct Field {
  /// Dotted, without the section ("orb.max_points").
  std::string key;
  std::variant<bool*, int*, int64_t*, double*, std::string*, std::vector<double>*, NamedValue> value;
  Bounds bounds;
  /// Texts that are allowed; empty: any.
  std::vector<std::string> choices;
  std::string help;
};

/// The visitor that flattens an option struct, nested ones included, into a list in the order of its VisitFields.
class FieldLister {
 public:
  template <class T>
  void operator()(const char* name, T& value, const char* help) {
    if constexpr (std::is_constructible_v<decltype(Field::value), T*>) {
      fields_.push_back({prefix_ + name, &value, {}, {}, help});
    } else if constexpr (std::is_enum_v<T>) {
      NamedValue named{[&value] { return NameOf(value); },
                       [&value](const std::string& text) { value = ChoiceFromName<T>(text).value(); }};
      fields_.push_back({prefix_ + name, std::move(named), {}, ChoiceNames<T>(), help});
    } else {
      const std::string outer = prefix_;
      prefix_ += std::string(name) + ".";
      VisitFields(*this, value);
      prefix_ = outer;
    }
  }

  template <class T>
  void operator()(const char* name, T& value, const Bounds& bounds, const char* help) {
    static_assert(!std::is_same_v<T, bool> && !std::is_same_v<T, std::string>, "bounds are for numbers");
    fields_.push_back({prefix_ + name, &value, bounds, {}, help});
  }

  void operator()(const char* name, std::string& value, const OneOf& choices, const char* help) {
    fields_.push_back({prefix_ + name, &value, {}, choices.values, help});
  }

  std::vector<Field> TakeFields() { return std::move(fields_); }

 private:
  std::string prefix_;
  std::vector<Field> fields_;
};

/// All options of a struct; the result points into `options`.
template <class Options>
std::vector<Field> ListFields(Options& options) {
  FieldLister lister;
  VisitFields(lister, options);
  return lister.TakeFields();
}

}  // namespace plslam
