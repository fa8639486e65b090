// SPDX-License-Identifier: BSD-3-Clause
#include "ros2/graph/service_message.h"

#include <algorithm>
#include <cstring>
#include <stdexcept>

#include <fmt/format.h>

#include "core/ros/cdr_writer.h"

namespace plslam::ros2 {

ServiceRequest ParseServiceRequest(std::span<const uint8_t> cdr) {
  constexpr size_t kEncodingBytes = 4, kHeadBytes = 16;
  // One byte of data, and up to three that fill a word.
  constexpr size_t kMostBodyBytes = 4;
  if (cdr.size() <= kEncodingBytes) throw std::runtime_error(fmt::format("has {} bytes", cdr.size()));
  if (cdr[0] != 0 || cdr[1] > 1) throw std::runtime_error("is not in plain CDR");
  const bool is_little_endian = cdr[1] == 1;
  std::span<const uint8_t> rest = cdr.subspan(kEncodingBytes);
  ServiceRequest request;
  if (rest.size() > kMostBodyBytes) {
    if (rest.size() <= kHeadBytes || rest.size() > kHeadBytes + kMostBodyBytes) {
      throw std::runtime_error(fmt::format("has {} bytes", cdr.size()));
    }
    request.head.emplace();
    for (uint64_t& number : *request.head) {
      std::array<uint8_t, sizeof(number)> bytes{};
      std::copy_n(rest.begin(), bytes.size(), bytes.begin());
      if (!is_little_endian) std::reverse(bytes.begin(), bytes.end());
      std::memcpy(&number, bytes.data(), bytes.size());
      rest = rest.subspan(bytes.size());
    }
  }
  request.body.assign(rest.begin(), rest.end());
  return request;
}

std::string ServiceReply(const ServiceRequest& request, bool done, std::string_view sentence) {
  CdrWriter cdr;
  if (request.head) {
    for (const uint64_t number : *request.head) cdr.Put(number);
  }
  cdr.Put(done);
  cdr.Put(sentence.substr(0, kLongestSentence));
  return std::move(cdr).Take();
}

}  // namespace plslam::ros2
