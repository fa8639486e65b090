// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

namespace plslam {

/// A value of an enum, and its name in options, messages and on command lines.
template <class E>
struct Choice {
  const char* name;
  E value;
};

/// An enum whose values have names. Beside it stands a function that lists them in the order of help texts, one for
/// each value:
///
///   enum class Corners { kHarris, kFast };
///   constexpr auto ChoicesOf(Corners) {
///     return std::array{Choice{"harris", Corners::kHarris}, Choice{"fast", Corners::kFast}};
///   }
template <class E>
concept HasChoices = std::is_enum_v<E> && requires {
  ChoicesOf(E{});
};

/// Returns "" for a value that is not listed.
template <HasChoices E>
constexpr const char* NameOf(E value) {
  for (const Choice<E>& choice : ChoicesOf(E{})) {
    if (choice.value == value) return choice.name;
  }
  return "";
}

/// Returns the value of this name, case included; nullopt: there is none.
template <HasChoices E>
constexpr std::optional<E> ChoiceFromName(std::string_view name) {
  for (const Choice<E>& choice : ChoicesOf(E{})) {
    if (choice.name == name) return choice.value;
  }
  return std::nullopt;
}

template <HasChoices E>
std::vector<std::string> ChoiceNames() {
  std::vector<std::string> names;
  for (const Choice<E>& choice : ChoicesOf(E{})) names.emplace_back(choice.name);
  return names;
}

}  // namespace plslam

#ifdef __clang__
namespace plslam {
// Clang deduces aggregates, as C++20 does, from version 17 on.
template <class E>
Choice(const char*, E) -> Choice<E>;
}  // namespace plslam
#endif
