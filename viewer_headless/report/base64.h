#pragma once

#include <string>
#include <string_view>

#include "viewer_headless/report/table.h"

namespace plslam {

/// RFC 4648, with padding.
std::string Base64(std::string_view bytes);

/// The numbers as little endian bytes, and what they are called in a page: "f32", "i32", "u16", "u8".
std::string LittleEndianBytes(const Column& column);
std::string TypeName(const Column& column);

}  // namespace plslam
