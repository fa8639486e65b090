// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace plslam::ros2 {

// Requests and answers of std_srvs/srv/Trigger and SetBool as the two middlewares of ROS 2 send them. rmw_fastrtps
// (the default of ROS) sends the request alone, with the identity of the client beside the sample; rmw_cyclonedds puts
// 16 bytes before it: a number of the client and one of the call, which the answer repeats.

struct ServiceRequest {
  /// Client and call of rmw_cyclonedds; nullopt: the form of rmw_fastrtps.
  std::optional<std::array<uint64_t, 2>> head;
  std::vector<uint8_t> body;  ///< in CDR, without the bytes of its encoding
};

/// Parses a request in plain CDR of either endianness; the form follows from its length. Throws std::runtime_error with
/// the reason if it is no such request.
ServiceRequest ParseServiceRequest(std::span<const uint8_t> cdr);

/// Returns the answer (bool success, string message) in CDR; longer sentences than `kLongestSentence` are cut.
std::string ServiceReply(const ServiceRequest& request, bool done, std::string_view sentence);

inline constexpr size_t kLongestSentence = 1024;

}  // namespace plslam::ros2
