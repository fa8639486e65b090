#pragma once

#include <string>
#include <string_view>

namespace plslam {

/// Replaces the file by `content`: writes to `PATH.part` in the same folder, then renames, so that a reader sees the
/// old file or the new one, whole. Throws std::runtime_error, naming the file and the reason of the system.
void WriteFileAtomically(const std::string& path, std::string_view content);

}  // namespace plslam
