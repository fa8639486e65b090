// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string_view>

namespace plslam {

/// Git LFS stores a pointer of three lines instead of a file that was not fetched; `start` is the beginning of a file.
inline bool IsGitLfsPointer(std::string_view start) { return start.starts_with("version https://git-lfs"); }

/// The phrase about such a file that follows its name, with the remedy.
inline constexpr const char* kGitLfsPointer =
    "is a pointer of Git LFS, not the file itself: fetch it with `git lfs pull`";

}  // namespace plslam
