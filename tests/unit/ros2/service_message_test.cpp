// SPDX-License-Identifier: BSD-3-Clause
#include "ros2/graph/service_message.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <stdexcept>

#include "core/ros/ros_services.h"

namespace plslam::ros2 {
namespace {

using Bytes = std::vector<uint8_t>;

TEST(ServiceMessage, RequestAlone) {
  for (const Bytes& bytes : {Bytes{0, 1, 0, 0, 1}, Bytes{0, 0, 0, 0, 1, 0, 0, 0}}) {
    const ServiceRequest request = ParseServiceRequest(bytes);
    EXPECT_FALSE(request.head);
    EXPECT_EQ(request.body[0], 1);
    EXPECT_EQ(ServiceReply(request, true, "ok"), std::string("\0\1\0\0\1\0\0\0\3\0\0\0ok\0", 15));
  }
}

TEST(ServiceMessage, NumbersOfTheCallerAreRepeated) {
  const Bytes numbers{1, 2, 3, 4, 5, 6, 7, 8, 9, 0, 0, 0, 0, 0, 0, 0};
  Bytes little{0, 1, 0, 0}, big{0, 0, 0, 0};
  little.insert(little.end(), numbers.begin(), numbers.end());
  big.insert(big.end(), {8, 7, 6, 5, 4, 3, 2, 1, 0, 0, 0, 0, 0, 0, 0, 9});
  for (Bytes* bytes : {&little, &big}) {
    bytes->push_back(1);
    const ServiceRequest request = ParseServiceRequest(*bytes);
    ASSERT_TRUE(request.head);
    EXPECT_EQ(request.body, Bytes{1});
    EXPECT_EQ(ServiceReply(request, false, "no"), std::string("\0\1\0\0\1\2\3\4\5\6\7\10\11\0\0\0\0\0\0\0", 20) +
                                                      std::string("\0\0\0\0\3\0\0\0no\0", 11));
  }
}

TEST(ServiceMessage, LongSentencesAreCut) {
  EXPECT_EQ(ServiceReply({}, true, std::string(5000, 'x')).size(), 4 + 4 + 4 + kLongestSentence + 1);
}

TEST(ServiceMessage, AnyBytesAreARequestOrRejected) {
  std::mt19937 random(7);
  int n_accepted = 0, n_rejected = 0;
  for (int i = 0; i < 20000; ++i) {
    Bytes bytes(random() % 40);
    std::generate(bytes.begin(), bytes.end(), [&] { return static_cast<uint8_t>(random() % 4); });
    if (bytes.size() > 1 && i % 2 == 0) bytes[0] = 0;
    try {
      const ServiceRequest request = ParseServiceRequest(bytes);
      ASSERT_FALSE(request.body.empty());
      ASSERT_LE(request.body.size(), 4U);
      for (const RosService& service : RosServices()) OrderOf(service, request.body, "map", "plslam_ros2");
      ++n_accepted;
    } catch (const std::runtime_error&) {
      ++n_rejected;
    }
  }
  EXPECT_GT(n_accepted, 500);
  EXPECT_GT(n_rejected, 500);
}

TEST(RosServices, OrdersOfAllRows) {
  const Bytes on{1}, off{0};
  std::string orders;
  for (const RosService& service : RosServices()) {
    for (const Bytes& data : {on, off}) {
      const ServiceOrder order = OrderOf(service, data, "house.plmap", "plslam_ros2");
      orders += std::string(service.name) + ": " + order.verb + " " + order.argument + "\n";
    }
  }
  EXPECT_EQ(orders,
            "save: save house.plmap\nsave: save house.plmap\nload: load house.plmap\nload: load house.plmap\n"
            "reset: reset \nreset: reset \npause: pause \npause: resume \n"
            "localise_only: localise on\nlocalise_only: localise off\n");
}

TEST(RosServices, CallsThatCannotBeCarriedOut) {
  const auto failure = [](size_t row, const Bytes& data) -> std::string {
    try {
      OrderOf(RosServices()[row], data, "", "plslam_ros2");
    } catch (const std::runtime_error& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_EQ(failure(0, {0}), "save has no file: start plslam_ros2 with --map-file FILE");
  EXPECT_EQ(failure(3, {}), "the request has no data");
  EXPECT_EQ(failure(2, {}), "");
}

}  // namespace
}  // namespace plslam::ros2
