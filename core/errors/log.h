// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <fmt/format.h>

#include <string>
#include <utility>

namespace plslam {

enum class LogLevel { kDebug, kInfo, kWarning, kError };

/// Writes a line to the log of this process: standard error, with the format that bus::SetUpLogging states. Safe in all
/// threads. Sources that log include this header instead of spdlog's, which cost 2.5 s of compiling each.
void Log(LogLevel level, const std::string& line);

template <class... Arguments>
void LogDebug(fmt::format_string<Arguments...> text, Arguments&&... arguments) {
  Log(LogLevel::kDebug, fmt::vformat(text, fmt::make_format_args(arguments...)));
}

template <class... Arguments>
void LogInfo(fmt::format_string<Arguments...> text, Arguments&&... arguments) {
  Log(LogLevel::kInfo, fmt::vformat(text, fmt::make_format_args(arguments...)));
}

template <class... Arguments>
void LogWarning(fmt::format_string<Arguments...> text, Arguments&&... arguments) {
  Log(LogLevel::kWarning, fmt::vformat(text, fmt::make_format_args(arguments...)));
}

template <class... Arguments>
void LogError(fmt::format_string<Arguments...> text, Arguments&&... arguments) {
  Log(LogLevel::kError, fmt::vformat(text, fmt::make_format_args(arguments...)));
}

}  // namespace plslam
