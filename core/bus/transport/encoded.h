#pragma once

#include <cstdint>
#include <vector>

namespace plslam::bus {

/// The bytes of a generated message.
template <class Message>
std::vector<uint8_t> Encoded(const Message& message) {
  std::vector<uint8_t> bytes(static_cast<size_t>(message.getEncodedSize()));
  message.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
  return bytes;
}

}  // namespace plslam::bus
