// SPDX-License-Identifier: BSD-3-Clause
#include "core/process/order_sender.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cstdint>
#include <memory>
#include <string>

#include "core/run/process_names.h"
#include "plslam/command_answer_t.hpp"
#include "plslam/command_t.hpp"
#include "plslam/status_t.hpp"
#include "tests/unit/bus/bus_fixture.h"

namespace plslam::launcher {
namespace {

using bus::test::Eventually;

/// A sender of orders, and a stand-in for the process that receives them.
class OrderSenderTest : public testing::Test {
 protected:
  OrderSenderTest() {
    process_->Subscribe<command_t>(bus::kCommand, [this](const command_t& command) {
      source_ = command.header.source;
      EXPECT_EQ(command.argument, "house.plmap");
      seq_ = command.header.seq;
      ++n_;
    });
    process_.Start();
    tool_.Start();
  }
  ~OrderSenderTest() override {
    tool_.Join();
    process_.Join();
  }

  void SayAlive(int64_t pid, double uptime_s) {
    status_t status{};
    status.process = process_name::kMapping;
    status.pid = pid;
    status.uptime_s = uptime_s;
    process_->Publish(bus::kStatus, status);
  }
  void SayAnswer(int64_t source, const std::string& failure, const std::string& process = process_name::kMapping) {
    command_answer_t answer{};
    answer.command_source = source;
    answer.command_seq = seq_;
    answer.failure = failure;
    answer.process = process;
    process_->Publish(bus::kCommandAnswer, answer);
  }
  bool HasAnswer() {
    auto has = std::make_shared<std::atomic<bool>>(false);
    return Eventually([&] {
      tool_->Post([this, has] { *has = order_.answer().has_value(); });
      return has->load();
    });
  }

  const bus::BusOptions options_ = [] {
    bus::BusOptions options;
    options.url = bus::test::PrivateUrl();
    return options;
  }();
  std::atomic<int> n_{0};
  std::atomic<int64_t> source_{0};
  std::atomic<int64_t> seq_{0};
  bus::test::RunningBus process_{options_, "mapping"};
  bus::test::RunningBus tool_{options_, "plslam"};
  bus::OrderSender order_{*tool_};
};

TEST_F(OrderSenderTest, IsPublishedAgainForARestartedProcess) {
  tool_->Post([this] { order_.Send(*bus::FindOrder(command_verb::kSave), "house.plmap"); });
  EXPECT_TRUE(Eventually([this] { return n_ == 1; }));
  SayAlive(7, 1000.0);
  SayAlive(7, 1001.0);
  SayAlive(8, 0.0);
  EXPECT_TRUE(Eventually([this] { return n_ == 2; }));
  SayAnswer(source_ + 1, "is that of another order");
  SayAnswer(source_, "no room");
  ASSERT_TRUE(HasAnswer());
  EXPECT_EQ(*order_.answer(), "no room");
}

TEST_F(OrderSenderTest, SentenceNamesTheFile) {
  SayAlive(7, 1000.0);
  tool_->Post([this] { order_.Send(*bus::FindOrder(command_verb::kSave), "house.plmap"); });
  EXPECT_TRUE(Eventually([this] { return n_ >= 1; }));
  SayAnswer(source_, "");
  ASSERT_TRUE(HasAnswer());
  EXPECT_EQ(order_.Result()->sentence, "the map is saved in house.plmap");
  EXPECT_TRUE(order_.Result()->done);
  EXPECT_EQ(n_, 1);
}

// dense_process saves the surfaces after mapping_process has saved the map.
TEST_F(OrderSenderTest, OthersThatActOnItAreKnown) {
  SayAlive(7, 1000.0);
  tool_->Post([this] { order_.Send(*bus::FindOrder(command_verb::kSave), "house.plmap"); });
  EXPECT_TRUE(Eventually([this] { return n_ >= 1; }));
  SayAnswer(source_, "no room for the surfaces", process_name::kDense);
  SayAnswer(source_, "");
  ASSERT_TRUE(HasAnswer());
  EXPECT_EQ(*order_.answer(), "");
  EXPECT_TRUE(order_.HasAnswered(process_name::kDense));
}

TEST_F(OrderSenderTest, LateAnswerIsNotOfTheNextOrder) {
  tool_->Post([this] { order_.Send(*bus::FindOrder(command_verb::kSave), "house.plmap"); });
  EXPECT_TRUE(Eventually([this] { return n_ == 1; }));
  const int64_t first = seq_;
  tool_->Post([this] { order_.Send(*bus::FindOrder(command_verb::kLoad), "house.plmap"); });
  EXPECT_TRUE(Eventually([this] { return n_ == 2; }));
  const int64_t second = seq_;
  seq_ = first;
  SayAnswer(source_, "of the first");
  seq_ = second;
  SayAnswer(source_, "of the second");
  ASSERT_TRUE(HasAnswer());
  EXPECT_EQ(order_.Result()->sentence, "of the second");
  EXPECT_FALSE(order_.Result()->done);
}

TEST(OrderTable, HasTheVerbsOfUsersOnly) {
  for (const char* verb : {"save", "load", "reset", "localise", "pause", "resume"}) {
    EXPECT_NE(bus::FindOrder(verb), nullptr) << verb;
  }
  for (const char* verb : {"finish", "go_back", "send_keyframes", "", "Save"}) {
    EXPECT_EQ(bus::FindOrder(verb), nullptr) << verb;
  }
}

}  // namespace
}  // namespace plslam::launcher
