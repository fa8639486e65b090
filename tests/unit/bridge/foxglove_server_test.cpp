// SPDX-License-Identifier: BSD-3-Clause
#include "tools/bridge/foxglove_server.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "core/files/bytes.h"

namespace plslam::bridge {
namespace {

using nlohmann::json;
using testing::HasSubstr;

class Foxglove : public testing::Test {
 protected:
  std::vector<json> Texts() {
    std::vector<json> texts;
    while (const auto frame = server_.Next(1)) {
      if (!frame->is_binary) texts.push_back(json::parse(frame->head));
    }
    return texts;
  }
  std::string StatusAfter(const std::string& text) {
    server_.TakeText(1, text);
    const std::vector<json> texts = Texts();
    return texts.empty() ? "" : texts.back().value("message", "");
  }
  static std::string Request(uint32_t service, const std::string& encoding, const std::string& payload) {
    std::string bytes(1, '\2');
    for (const uint32_t number : {service, 7U, static_cast<uint32_t>(encoding.size())}) {
      AppendLittleEndian(number, bytes);
    }
    return bytes + encoding + payload;
  }
  void Call(const std::string& bytes) {
    server_.TakeBinary(1, {reinterpret_cast<const uint8_t*>(bytes.data()), bytes.size()});
  }

  std::vector<ServiceCall> calls_;
  FoxgloveServer server_{
      "1", true, "", {.on_output = [] {}, .on_call = [this](ServiceCall call) { calls_.push_back(call); }}};
};

TEST_F(Foxglove, ChannelsAreTheLiveRowsOfTheTable) {
  server_.Open(1);
  const std::vector<json> texts = Texts();
  ASSERT_EQ(texts.size(), 3U);
  EXPECT_EQ(texts[0]["op"], "serverInfo");
  size_t n_live = 0;
  for (const RosTopic& topic : RosTopics()) n_live += topic.is_live;
  ASSERT_EQ(texts[1]["channels"].size(), n_live);
  for (const json& channel : texts[1]["channels"]) EXPECT_NE(channel["schema"], "");
  EXPECT_EQ(texts[2]["services"].size(), 5U);
}

TEST_F(Foxglove, LateSubscriberReceivesTheMap) {
  server_.Write(ros_topic::kMapPoints, 5, "old");
  server_.Write(ros_topic::kMapPoints, 6, "points");
  server_.Write(ros_topic::kOdom, 6, "odom");
  server_.Open(1);
  const json channels = Texts()[1]["channels"];
  for (const json& channel : channels) {
    server_.TakeText(
        1,
        json{{"op", "subscribe"}, {"subscriptions", {{{"id", channel["id"]}, {"channelId", channel["id"]}}}}}.dump());
  }
  const auto frame = server_.Next(1);
  ASSERT_TRUE(frame && frame->is_binary);
  EXPECT_EQ(*frame->payload, "points");
  EXPECT_EQ(frame->head.size(), 13U);
  EXPECT_EQ(frame->head[5], 6);
  EXPECT_FALSE(server_.Next(1));
  EXPECT_TRUE(server_.wants_images());
  server_.Close(1);
  EXPECT_FALSE(server_.wants_images());
}

TEST_F(Foxglove, ServicesBecomeOrders) {
  server_.Open(1);
  Texts();
  const std::string head("\0\1\0\0", 4);
  Call(Request(3, "cdr", head + '\1'));
  Call(Request(3, "cdr", head + '\0'));
  Call(Request(4, "cdr", head + '\1'));
  Call(Request(2, "cdr", head));
  ASSERT_EQ(calls_.size(), 4U);
  EXPECT_EQ(calls_[0].order.verb, "pause");
  EXPECT_EQ(calls_[1].order.verb, "resume");
  EXPECT_EQ(calls_[2].order.verb + calls_[2].order.argument, "localiseon");
  EXPECT_EQ(calls_[3].order.verb, "reset");
  server_.Answer(calls_[0], true, "paused");
  EXPECT_THAT(*server_.Next(1)->payload, HasSubstr("paused"));
  for (const std::string& wrong : {Request(0, "cdr", head), Request(3, "cdr", head), Request(3, "json", "{}"),
                                   Request(99, "cdr", head), std::string("\2\1")}) {
    Call(wrong);
    const std::vector<json> texts = Texts();
    ASSERT_EQ(texts.size(), 1U);
    EXPECT_GT(texts[0]["message"].get<std::string>().size(), 10U);
  }
  EXPECT_EQ(calls_.size(), 4U);
}

TEST_F(Foxglove, ParametersAreReadOnly) {
  server_.SetParameters("vo", {{"vo.features.use", "both"}, {"vo.size", "7"}, {"vo.on", "true"}});
  server_.Open(1);
  Texts();
  server_.TakeText(1, R"({"op": "setParameters", "parameters": [{"name": "vo.size", "value": 8}], "id": "x"})");
  std::vector<json> texts = Texts();
  ASSERT_EQ(texts.size(), 2U);
  EXPECT_THAT(texts[0]["message"].get<std::string>(), HasSubstr("parameters are read-only"));
  EXPECT_EQ(texts[1]["parameters"], json::parse(R"([{"name": "vo.size", "value": 7}])"));
  server_.TakeText(1, R"({"op": "getParameters", "parameterNames": []})");
  texts = Texts();
  ASSERT_EQ(texts[0]["parameters"].size(), 3U);
  EXPECT_EQ(texts[0]["parameters"][1]["value"], true);
}

TEST_F(Foxglove, InvalidMessagesAreAnsweredWithASentence) {
  server_.Open(1);
  Texts();
  EXPECT_THAT(StatusAfter("{"), HasSubstr("the message cannot be read"));
  EXPECT_THAT(StatusAfter("[]"), HasSubstr("the message cannot be read"));
  EXPECT_THAT(StatusAfter(R"({"op": "advertise"})"), HasSubstr("'advertise' is not offered here"));
  EXPECT_THAT(StatusAfter(R"({"op": "subscribe", "subscriptions": [{"id": 0, "channelId": 99}]})"),
              HasSubstr("there is no channel 99"));
  EXPECT_THAT(StatusAfter(R"({"op": "subscribe", "subscriptions": [{"id": -1, "channelId": 0}]})"),
              HasSubstr("'id' is no number of 32 bits"));
  EXPECT_THAT(StatusAfter(std::string(100'000, '[')), HasSubstr("the message is too long"));
  EXPECT_THAT(StatusAfter(std::string(60'000, '[')), HasSubstr("the message cannot be read"));
}

}  // namespace
}  // namespace plslam::bridge
