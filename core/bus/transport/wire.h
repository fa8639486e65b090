// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "core/ids/ids.h"
#include "lcmtypes/message_layout.h"

namespace plslam::bus {

/// The bytes of a generated message.
template <class Message>
std::vector<uint8_t> Encoded(const Message& message) {
  std::vector<uint8_t> bytes(static_cast<size_t>(message.getEncodedSize()));
  message.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
  return bytes;
}

/// Decodes the bytes of `Encoded`; nullopt if they are damaged.
template <class Message>
std::optional<Message> Decoded(std::span<const uint8_t> bytes) {
  // A new object each time: LCM's decoders keep the old elements of a number array that is now empty.
  std::optional<Message> message(std::in_place);
  if (message->decode(bytes.data(), 0, static_cast<int>(bytes.size())) < 0) message.reset();
  return message;
}

/// Bytes of one message, as sent: fingerprint, members, MAC if there is a key. Shared by history and senders.
using Bytes = std::shared_ptr<const std::vector<uint8_t>>;
using ByteView = std::span<const uint8_t>;

/// Largest message that always fits into one datagram.
inline constexpr size_t kMaxMessageBytes = 60000;

/// Largest accepted message number: far from any number that a publisher can reach, and sums with it do not overflow.
inline constexpr int64_t kMaxNumber = int64_t{1} << 62;

/// `header_t` as encoded at the beginning of every message.
struct WireHeader {
  int32_t schema = 0;
  SourceId source;
  SessionId session;
  int64_t seq = 0;
  int64_t t_ns = 0;
};

/// Bytes of the fingerprint and the header.
inline constexpr size_t kWireHeaderBytes = 8 + 4 + 4 * 8;

/// Big-endian integer of the wire. Precondition: 8 (4) bytes are there.
int64_t ReadInt64(const uint8_t* p);
int32_t ReadInt32(const uint8_t* p);

/// Header of a message of at least kWireHeaderBytes.
WireHeader ReadHeader(ByteView message);

/// Returns the length of the message of type `layout` at the beginning of `bytes`; nullopt if its fingerprint, sizes,
/// array lengths or strings are not allowed by the type or do not fit in `bytes`. LCM's generated decoders allocate
/// whatever size they read; after this check they allocate at most a small multiple of `bytes`.
std::optional<size_t> MessageLength(const MessageLayout& layout, ByteView bytes);

}  // namespace plslam::bus
