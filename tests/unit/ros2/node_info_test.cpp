// SPDX-License-Identifier: BSD-3-Clause
#include "ros2/graph/node_info.h"

#include <gtest/gtest.h>

namespace plslam::ros2 {
namespace {

TEST(NodeInfoMessage, IdentitiesOfBothSizes) {
  Guid one{}, two{};
  one.fill('1');
  two.fill('2');
  const NodeInfo info{.participant = one, .space = "/", .name = "abc", .readers = {}, .writers = {one, two}};
  const std::string ones(16, '1'), twos(16, '2'), none(8, '\0');
  const auto number = [](char value) { return std::string{value, '\0', '\0', '\0'}; };
  const std::string head("\0\1\0\0", 4), names = number(1) + number(2) + std::string("/\0\0\0", 4) + number(4) +
                                                 std::string("abc\0", 4) + number(0) + number(2);
  EXPECT_EQ(NodeInfoMessage(info, kGidBytes), head + ones + names + ones + twos);
  EXPECT_EQ(NodeInfoMessage(info, kGidBytesBeforeIron), head + ones + none + names + ones + none + twos + none);
}

}  // namespace
}  // namespace plslam::ros2
