// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <exception>
#include <string>

namespace plslam {

/// Whether the bytes could be appended; false where no memory is left. For callbacks of C libraries, which no
/// exception may pass through.
inline bool AppendBytes(std::string& file, const void* bytes, size_t n) noexcept {
  try {
    file.append(static_cast<const char*>(bytes), n);
    return true;
  } catch (const std::exception&) {
    return false;
  }
}

}  // namespace plslam
