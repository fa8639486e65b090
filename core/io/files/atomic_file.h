// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <initializer_list>
#include <string>
#include <string_view>

namespace plslam {

/// Replaces the file by `content`: writes to `PATH.part` in the same folder, then renames, so that a reader sees the
/// old file or the new one, whole. Throws std::runtime_error, naming the file and the reason of the system.
void WriteFileAtomically(const std::string& path, std::string_view content);
/// One part behind the other.
void WriteFileAtomically(const std::string& path, std::initializer_list<std::string_view> parts);

/// Makes the folder, and those above it, where they are not there. An empty name is this folder: nothing is to be
/// made. Throws std::runtime_error with one sentence.
void MakeFolder(const std::string& folder);

}  // namespace plslam
