// SPDX-License-Identifier: BSD-3-Clause
#include "tests/integration/message_walk.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <functional>
#include <string_view>

namespace plslam::test {
namespace {

using bus::ByteView;

size_t SizeOf(WireType type, ByteView at) {
  switch (type) {
    case WireType::kBoolean:
    case WireType::kByte:
    case WireType::kInt8:
      return 1;
    case WireType::kInt16:
      return 2;
    case WireType::kInt32:
    case WireType::kFloat:
      return 4;
    case WireType::kInt64:
    case WireType::kDouble:
      return 8;
    case WireType::kString:
      return 4 + static_cast<size_t>(bus::ReadInt32(at.data()));
    case WireType::kStruct:
      break;
  }
  return 0;
}

/// Visits the values of a message in their order, down to numbers and strings. The message must be whole
/// (`bus::MessageLength`).
class MessageWalk {
 public:
  struct Value {
    const MessageLayout& layout;  ///< the struct it is a member of
    const LayoutMember& member;
    size_t offset;
    size_t size;
  };
  /// Ends the walk with false.
  using Visit = std::function<bool(const Value&)>;

  MessageWalk(ByteView bytes, Visit visit) : bytes_(bytes), visit_(std::move(visit)) {}

  bool Struct(const MessageLayout& layout) {
    std::vector<int32_t> sizes(layout.members.size());
    for (size_t i = 0; i < layout.members.size(); ++i) {
      const LayoutMember& member = layout.members[i];
      if (member.type == WireType::kInt32 && member.dimensions.empty()) sizes[i] = bus::ReadInt32(&bytes_[offset_]);
      if (!Member(layout, member, sizes)) return false;
    }
    return true;
  }

  /// Path of the visited value: "points[3].u_px".
  std::string Path() const {
    std::string path;
    for (const auto& [name, index] : path_) {
      path += fmt::format("{}{}", path.empty() ? "" : ".", name);
      if (index >= 0) path += fmt::format("[{}]", index);
    }
    return path;
  }

 private:
  bool Member(const MessageLayout& layout, const LayoutMember& member, const std::vector<int32_t>& sizes) {
    int count = 1;
    for (const LayoutDimension& dimension : member.dimensions) {
      count *= dimension.size_member < 0 ? dimension.constant : sizes[static_cast<size_t>(dimension.size_member)];
    }
    path_.emplace_back(member.name, -1);
    for (int i = 0; i < count; ++i) {
      if (!member.dimensions.empty()) path_.back().second = i;
      if (!Element(layout, member)) return false;
    }
    path_.pop_back();
    return true;
  }

  bool Element(const MessageLayout& layout, const LayoutMember& member) {
    if (member.type == WireType::kStruct) return Struct(MessageLayouts()[static_cast<size_t>(member.struct_index)]);
    const size_t size = SizeOf(member.type, bytes_.subspan(offset_));
    if (!visit_({layout, member, offset_, size})) return false;
    offset_ += size;
    return true;
  }

  ByteView bytes_;
  Visit visit_;
  size_t offset_ = 8;  // behind the fingerprint
  std::vector<std::pair<std::string_view, int>> path_;
};

std::string TextOf(WireType type, ByteView at) {
  const uint8_t* p = at.data();
  switch (type) {
    case WireType::kBoolean:
    case WireType::kByte:
      return fmt::format("{}", *p);
    case WireType::kInt8:
      return fmt::format("{}", static_cast<int8_t>(*p));
    case WireType::kInt16:
      return fmt::format("{}", static_cast<int16_t>(p[0] << 8 | p[1]));
    case WireType::kInt32:
      return fmt::format("{}", bus::ReadInt32(p));
    case WireType::kFloat:
      return fmt::format("{}", std::bit_cast<float>(bus::ReadInt32(p)));
    case WireType::kInt64:
      return fmt::format("{}", bus::ReadInt64(p));
    case WireType::kDouble:
      return fmt::format("{}", std::bit_cast<double>(bus::ReadInt64(p)));
    case WireType::kString:
      return fmt::format("\"{}\"", reinterpret_cast<const char*>(p + 4));
    case WireType::kStruct:
      break;
  }
  return "";
}

}  // namespace

std::string FirstDifference(const MessageLayout& layout, ByteView message, ByteView logged,
                            const std::set<std::string>& ignored) {
  if (!bus::MessageLength(layout, message)) return fmt::format("it is no {}", layout.name);
  if (!bus::MessageLength(layout, logged)) return fmt::format("in the log it is no {}", layout.name);
  std::string difference;
  // All previous values were equal, so a value is at the same offset in both.
  MessageWalk* position = nullptr;
  MessageWalk walk(message, [&](const MessageWalk::Value& value) {
    const ByteView one = message.subspan(value.offset, value.size);
    const ByteView other = logged.subspan(value.offset, SizeOf(value.member.type, logged.subspan(value.offset)));
    if (std::ranges::equal(one, other)) return true;
    if (!ignored.empty() && ignored.contains(fmt::format("{}.{}", value.layout.name, value.member.name))) return true;
    difference = fmt::format("{} is {}, in the log {}", position->Path(), TextOf(value.member.type, one),
                             TextOf(value.member.type, other));
    return false;
  });
  position = &walk;
  walk.Struct(layout);
  return difference;
}

void Rename(const MessageLayout& layout, const std::map<int64_t, int64_t>& names, std::vector<uint8_t>* message) {
  if (!bus::MessageLength(layout, *message)) return;
  MessageWalk walk(*message, [&](const MessageWalk::Value& value) {
    if (value.member.type != WireType::kInt64) return true;
    const auto name = names.find(bus::ReadInt64(&(*message)[value.offset]));
    if (name == names.end()) return true;
    for (size_t i = 0; i < 8; ++i) {
      (*message)[value.offset + i] = static_cast<uint8_t>(static_cast<uint64_t>(name->second) >> (56 - 8 * i));
    }
    return true;
  });
  walk.Struct(layout);
}

}  // namespace plslam::test
