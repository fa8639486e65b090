// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>

namespace plslam::viewer {

using OrderKey = std::array<uint8_t, 32>;

/// Checks that orders of a page come from a holder of the bus's key, which the page never sends: an order carries the
/// hexadecimal HMAC-SHA256, with the key, of "CHALLENGE\nVERB\nARGUMENT". A challenge is good for one order, so that an
/// order that was overheard cannot be sent again. Without a key every order is accepted. Safe from any thread.
class OrderProof {
 public:
  /// Throws std::runtime_error if libsodium cannot be initialised.
  explicit OrderProof(std::optional<OrderKey> key);

  bool needs_key() const { return key_.has_value(); }
  /// Returns the proof of an order by a holder of `key`.
  static std::string Compute(const OrderKey& key, std::string_view challenge, std::string_view verb,
                             std::string_view argument);
  /// 32 hexadecimal digits.
  std::string challenge() const;
  /// Returns whether the order is proved. If so, the next one needs another challenge.
  bool Accept(std::string_view verb, std::string_view argument, std::string_view proof);

 private:
  const std::optional<OrderKey> key_;
  mutable std::mutex mutex_;
  std::string challenge_;
};

}  // namespace plslam::viewer
