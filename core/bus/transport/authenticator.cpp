// SPDX-License-Identifier: BSD-3-Clause
#include "core/bus/transport/authenticator.h"

#include <fstream>
#include <stdexcept>

#include <sodium.h>
#include <sys/stat.h>

#include "core/errors/error_text.h"
#include "core/errors/log.h"

namespace plslam::bus {
namespace {

/// A user who can read the key can forge messages.
void WarnOfReaders(const std::string& path) {
  struct stat status {};
  if (stat(path.c_str(), &status) != 0 || (status.st_mode & (S_IRWXG | S_IRWXO)) == 0) return;
  LogWarning("bus.key_file: {} is accessible to users other than its owner (mode {:04o}): chmod 600 {}", path,
             status.st_mode & 07777, path);
}

}  // namespace

Key ReadKey(const std::string& path) {
  const std::string why = WhyUnreadable(path);
  if (!why.empty()) throw std::runtime_error("bus.key_file: " + path + " " + why);
  std::ifstream in(path);
  std::string digits;
  in >> digits;
  std::string rest;
  Key key{};
  size_t length = 0;
  const int bad = sodium_hex2bin(key.data(), key.size(), digits.c_str(), digits.size(), nullptr, &length, nullptr);
  if (bad != 0 || length != key.size() || digits.size() != 64 || in >> rest) {
    throw std::runtime_error("bus.key_file: " + path +
                             " must contain one key of 64 hex digits, as written by 'openssl rand -hex 32'");
  }
  return key;
}

Authenticator::Authenticator(const std::string& key_file) {
  if (sodium_init() < 0) throw std::runtime_error("libsodium cannot be initialised");
  if (key_file.empty()) return;
  key_ = ReadKey(key_file);
  WarnOfReaders(key_file);
}

Authenticator::Mac Authenticator::Compute(std::string_view channel, ByteView message) const {
  crypto_generichash_state state;
  crypto_generichash_init(&state, key_->data(), key_->size(), kMacBytes);
  const std::string name(channel);  // for its terminator, which ends the name unmistakably
  crypto_generichash_update(&state, reinterpret_cast<const uint8_t*>(name.c_str()), name.size() + 1);
  crypto_generichash_update(&state, message.data(), message.size());
  Mac mac;
  crypto_generichash_final(&state, mac.data(), mac.size());
  return mac;
}

void Authenticator::Append(std::string_view channel, std::vector<uint8_t>& message) const {
  if (!has_key()) return;
  const Mac mac = Compute(channel, message);
  message.insert(message.end(), mac.begin(), mac.end());
}

bool Authenticator::Accept(std::string_view channel, ByteView bytes, size_t length) const {
  const bool has_mac = bytes.size() == length + kMacBytes;
  if (!has_key()) return has_mac || bytes.size() == length;
  if (!has_mac) return false;
  const Mac mac = Compute(channel, bytes.first(length));
  return sodium_memcmp(mac.data(), bytes.data() + length, mac.size()) == 0;
}

}  // namespace plslam::bus
