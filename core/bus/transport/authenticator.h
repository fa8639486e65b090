// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/bus/transport/wire.h"

namespace plslam::bus {

using Key = std::array<uint8_t, 32>;

/// Returns the key of a file with 64 hex digits. Throws std::runtime_error if it cannot be read or is no key.
Key ReadKey(const std::string& path);

/// Appends a keyed MAC to messages and checks it: BLAKE2b-256 (libsodium's crypto_generichash) over the channel name, a
/// zero byte and the message. Without a key it appends nothing, and accepts messages with or without a MAC.
///
/// The MAC proves that the message was written by a holder of the key for this channel. It does not encrypt the
/// message, and old messages stay valid: the numbers in the header distinguish a replayed message from a new one.
class Authenticator {
 public:
  static constexpr size_t kMacBytes = 32;

  /// `key_file` holds 64 hex digits; empty: no key. Throws std::runtime_error if it cannot be read or is no key; warns
  /// if its mode lets other users than its owner read it.
  explicit Authenticator(const std::string& key_file);

  bool has_key() const { return key_.has_value(); }
  /// Bytes that `Append` adds.
  size_t overhead() const { return has_key() ? kMacBytes : 0; }

  void Append(std::string_view channel, std::vector<uint8_t>& message) const;

  /// Returns whether `bytes`, of which the message itself is the first `length`, are genuine.
  bool Accept(std::string_view channel, ByteView bytes, size_t length) const;

 private:
  using Mac = std::array<uint8_t, kMacBytes>;
  Mac Compute(std::string_view channel, ByteView message) const;

  std::optional<Key> key_;
};

}  // namespace plslam::bus
