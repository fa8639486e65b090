// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <span>
#include <string_view>

namespace plslam {

/// Types of the LCM language.
enum class WireType : uint8_t { kBoolean, kByte, kInt8, kInt16, kInt32, kInt64, kFloat, kDouble, kString, kStruct };

/// Extent of an array: a constant, or the value of an earlier integer member.
struct LayoutDimension {
  int32_t constant = 0;
  int16_t size_member = -1;  ///< index in the struct; -1: `constant` counts
};

/// One member of a struct, in the order of the wire.
struct LayoutMember {
  std::string_view name;
  WireType type = WireType::kByte;
  int16_t struct_index = -1;  ///< for kStruct: row of the table that the layout is of
  std::span<const LayoutDimension> dimensions;
};

/// The layout in the .lcm file of a type, as a table.
struct MessageLayout {
  std::string_view name;
  int64_t (*fingerprint)() = nullptr;
  std::span<const LayoutMember> members;
  /// Table that contains it.
  std::span<const MessageLayout> (*table)() = nullptr;
};

/// All types of lcmtypes/, by name. Generated at build time from the .lcm files.
std::span<const MessageLayout> MessageLayouts();

/// Row of a type; nullptr if there is none.
const MessageLayout* FindMessageLayout(std::string_view type);

}  // namespace plslam
