// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace plslam::bus {

/// The bytes of a generated message.
template <class Message>
std::vector<uint8_t> Encoded(const Message& message) {
  std::vector<uint8_t> bytes(static_cast<size_t>(message.getEncodedSize()));
  message.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
  return bytes;
}

/// The message that `Encoded` made these bytes of; nullopt where they are damaged.
template <class Message>
std::optional<Message> Decoded(std::span<const uint8_t> bytes) {
  // A new one each time: LCM's decoders leave what was in an array of numbers where it now has none.
  std::optional<Message> message(std::in_place);
  if (message->decode(bytes.data(), 0, static_cast<int>(bytes.size())) < 0) message.reset();
  return message;
}

}  // namespace plslam::bus
