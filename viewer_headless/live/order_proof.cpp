// SPDX-License-Identifier: BSD-3-Clause
#include "viewer_headless/live/order_proof.h"

#include <fmt/format.h>
#include <sodium.h>

#include <span>
#include <stdexcept>

namespace plslam::viewer {
namespace {

std::string Hex(std::span<const uint8_t> bytes) {
  std::string text(2 * bytes.size() + 1, '\0');
  sodium_bin2hex(text.data(), text.size(), bytes.data(), bytes.size());
  text.pop_back();
  return text;
}

std::string NewChallenge() {
  std::array<uint8_t, 16> bytes{};
  randombytes_buf(bytes.data(), bytes.size());
  return Hex(bytes);
}

}  // namespace

OrderProof::OrderProof(std::optional<OrderKey> key) : key_(key) {
  if (sodium_init() < 0) throw std::runtime_error("libsodium cannot be initialised");
  challenge_ = NewChallenge();
}

std::string OrderProof::Compute(const OrderKey& key, std::string_view challenge, std::string_view verb,
                                std::string_view argument) {
  crypto_auth_hmacsha256_state state;
  crypto_auth_hmacsha256_init(&state, key.data(), key.size());
  const std::string text = fmt::format("{}\n{}\n{}", challenge, verb, argument);
  crypto_auth_hmacsha256_update(&state, reinterpret_cast<const uint8_t*>(text.data()), text.size());
  std::array<uint8_t, crypto_auth_hmacsha256_BYTES> mac{};
  crypto_auth_hmacsha256_final(&state, mac.data());
  return Hex(mac);
}

std::string OrderProof::challenge() const {
  const std::scoped_lock lock(mutex_);
  return challenge_;
}

bool OrderProof::Accept(std::string_view verb, std::string_view argument, std::string_view proof) {
  if (!key_) return true;
  const std::scoped_lock lock(mutex_);
  const std::string expected = Compute(*key_, challenge_, verb, argument);
  if (proof.size() != expected.size() || sodium_memcmp(proof.data(), expected.data(), expected.size()) != 0) {
    return false;
  }
  challenge_ = NewChallenge();
  return true;
}

}  // namespace plslam::viewer
