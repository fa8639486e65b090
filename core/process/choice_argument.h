// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <optional>
#include <string>

#include "core/config/choices.h"

namespace plslam {

template <HasChoices E>
CLI::Option* AddChoice(CLI::App* app, const std::string& name, const std::string& help, std::function<void(E)> take) {
  return app
      ->add_option_function<std::string>(
          name, [take = std::move(take)](const std::string& text) { take(ChoiceFromName<E>(text).value()); }, help)
      ->check(CLI::IsMember(ChoiceNames<E>()));
}

/// Adds an argument that takes the names of an enum; `value` holds the default, which the help text shows.
template <HasChoices E>
CLI::Option* AddChoice(CLI::App* app, const std::string& name, E& value, const std::string& help) {
  return AddChoice<E>(app, name, help, [&value](E chosen) { value = chosen; })->default_str(NameOf(value));
}

/// The same without a default.
template <HasChoices E>
CLI::Option* AddChoice(CLI::App* app, const std::string& name, std::optional<E>& value, const std::string& help) {
  return AddChoice<E>(app, name, help, [&value](E chosen) { value = chosen; });
}

}  // namespace plslam
