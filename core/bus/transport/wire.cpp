// SPDX-License-Identifier: BSD-3-Clause
#include "core/bus/transport/wire.h"

#include <array>
#include <cstring>

namespace plslam::bus {
namespace {

size_t FixedSize(WireType type) {
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
    case WireType::kStruct:
      break;
  }
  return 0;
}

/// Walks over bytes by a layout; every step is checked against the remaining bytes.
class Walker {
 public:
  explicit Walker(ByteView bytes) : bytes_(bytes) {}

  size_t position() const { return position_; }

  bool Skip(size_t n) {
    if (n > bytes_.size() - position_) return false;
    position_ += n;
    return true;
  }

  bool Struct(const MessageLayout& layout) {
    std::array<int32_t, kMaxMembers> sizes{};
    if (layout.members.size() > kMaxMembers) return false;
    for (size_t i = 0; i < layout.members.size(); ++i) {
      const LayoutMember& member = layout.members[i];
      const size_t at = position_;
      if (!Member(layout, member, sizes)) return false;
      if (member.type == WireType::kInt32 && member.dimensions.empty()) sizes[i] = ReadInt32(&bytes_[at]);
    }
    return true;
  }

 private:
  static constexpr size_t kMaxMembers = 32;

  bool Member(const MessageLayout& owner, const LayoutMember& member, const std::array<int32_t, kMaxMembers>& sizes) {
    size_t count = 1;
    for (const LayoutDimension& dimension : member.dimensions) {
      const int32_t extent = dimension.size_member < 0 ? dimension.constant : sizes[dimension.size_member];
      // Each element takes at least a byte, so a count above the remaining bytes is invalid; nor can it overflow.
      if (extent < 0 || static_cast<size_t>(extent) > bytes_.size()) return false;
      count *= static_cast<size_t>(extent);
      if (count > bytes_.size()) return false;
    }
    const size_t size = FixedSize(member.type);
    if (size > 0) return Skip(size * count);
    for (size_t i = 0; i < count; ++i) {
      const bool ok = member.type == WireType::kString ? String() : Struct(owner.table()[member.struct_index]);
      if (!ok) return false;
    }
    return true;
  }

  /// Length with the terminator, text, terminator. A terminator inside the text would be lost when encoded again.
  bool String() {
    const size_t at = position_;
    if (!Skip(4)) return false;
    const int32_t length = ReadInt32(&bytes_[at]);
    if (length < 1 || !Skip(static_cast<size_t>(length))) return false;
    const void* end = std::memchr(&bytes_[at + 4], 0, static_cast<size_t>(length));
    return end == &bytes_[position_ - 1];
  }

  ByteView bytes_;
  size_t position_ = 0;
};

}  // namespace

int64_t ReadInt64(const uint8_t* p) {
  uint64_t value = 0;
  for (int i = 0; i < 8; ++i) value = value << 8 | p[i];
  return static_cast<int64_t>(value);
}

int32_t ReadInt32(const uint8_t* p) {
  uint32_t value = 0;
  for (int i = 0; i < 4; ++i) value = value << 8 | p[i];
  return static_cast<int32_t>(value);
}

WireHeader ReadHeader(ByteView message) {
  const uint8_t* p = message.data() + 8;
  return {ReadInt32(p), SourceId(ReadInt64(p + 4)), SessionId(ReadInt64(p + 12)), ReadInt64(p + 20),
          ReadInt64(p + 28)};
}

std::optional<size_t> MessageLength(const MessageLayout& layout, ByteView bytes) {
  if (bytes.size() < 8 || ReadInt64(bytes.data()) != layout.fingerprint()) return std::nullopt;
  Walker walker(bytes);
  if (!walker.Skip(8) || !walker.Struct(layout)) return std::nullopt;
  return walker.position();
}

}  // namespace plslam::bus
