// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include "core/bus/transport/wire.h"

namespace plslam::bus::test {

/// A valid message of the type with random content: arrays of 0 to 3 elements, short strings.
std::vector<uint8_t> RandomMessage(const MessageLayout& layout, std::mt19937_64& random);

/// Result of LCM's generated decoder and encoder on bytes that have been checked.
struct DecodedAgain {
  bool decoded = false;
  std::vector<uint8_t> encoded;
};

/// Names of all types, and the way of a message through the generated class of `type`.
std::vector<std::string> GeneratedTypes();
DecodedAgain DecodeAndEncode(const std::string& type, ByteView bytes);

}  // namespace plslam::bus::test
