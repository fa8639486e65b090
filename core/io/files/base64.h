// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <string_view>

namespace plslam {

/// RFC 4648, with padding.
std::string Base64(std::string_view bytes);

}  // namespace plslam
