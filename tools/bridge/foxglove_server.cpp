// SPDX-License-Identifier: BSD-3-Clause
#include "tools/bridge/foxglove_server.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <stdexcept>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/errors/error_text.h"
#include "core/files/bytes.h"
#include "core/ros/cdr_writer.h"
#include "core/ros/ros_definitions.h"

namespace plslam::bridge {
namespace {

using nlohmann::json;

/// Opcodes of binary messages, as the protocol numbers them.
constexpr uint8_t kMessageData = 1, kServiceResponse = 3;
constexpr uint8_t kServiceRequest = 2;
enum StatusLevel { kInfo = 0, kWarning = 1, kError = 2 };

constexpr size_t kMostTextBytes = 64 << 10;
constexpr size_t kMostSubscriptions = 256;

constexpr std::string_view kNamespace = "/plslam/";

json ServiceJson(uint32_t id, const RosService& row) {
  const std::string type(row.type()), request = row.is_switch() ? "bool data\n" : "";
  const std::string response = "bool success\nstring message\n";
  const auto described = [&](const char* part, const std::string& schema) {
    return json{{"encoding", "cdr"}, {"schemaName", type + part}, {"schemaEncoding", "ros2msg"}, {"schema", schema}};
  };
  // Older viewers read the two schemas alone.
  return {{"id", id},
          {"name", std::string(kNamespace).append(row.name)},
          {"type", type},
          {"request", described("_Request", request)},
          {"response", described("_Response", response)},
          {"requestSchema", request},
          {"responseSchema", response}};
}

std::vector<RosTopic> LiveTopics() {
  std::vector<RosTopic> topics;
  for (const RosTopic& topic : RosTopics()) {
    if (topic.is_live) topics.push_back(topic);
  }
  return topics;
}

/// The channels are the live rows; their ids are their positions.
const std::vector<RosTopic>& Channels() {
  static const std::vector<RosTopic> kChannels = LiveTopics();
  return kChannels;
}

json ChannelsJson() {
  json channels = json::array();
  for (size_t id = 0; id < Channels().size(); ++id) {
    const RosTopic& topic = Channels()[id];
    channels.push_back({{"id", id},
                        {"topic", topic.name},
                        {"encoding", "cdr"},
                        {"schemaName", topic.type},
                        {"schemaEncoding", "ros2msg"},
                        {"schema", RosDefinition(std::string(topic.type))}});
  }
  return channels;
}

OutFrame TextFrame(const json& text) {
  // Texts of users and files may not be UTF-8.
  return {text.dump(-1, ' ', false, json::error_handler_t::replace), nullptr, false};
}

/// A parameter has the type that its text has in YAML.
json ValueOf(const std::string& text) {
  if (text == "true" || text == "false") return text == "true";
  const json number = json::parse(text, nullptr, false);
  return number.is_number() ? number : json(text);
}

uint32_t GetUint32(std::span<const uint8_t>& bytes) {
  uint32_t value = 0;
  if (bytes.size() < sizeof(value)) throw std::runtime_error("a message ends before its last field");
  std::memcpy(&value, bytes.data(), sizeof(value));
  bytes = bytes.subspan(sizeof(value));
  return value;
}

uint32_t IdIn(const json& object, const char* key) {
  const json& id = object.at(key);
  if (!id.is_number_unsigned() || id.get<uint64_t>() > UINT32_MAX) {
    throw std::runtime_error(fmt::format("'{}' is no number of 32 bits", key));
  }
  return id.get<uint32_t>();
}

}  // namespace

FoxgloveServer::FoxgloveServer(std::string session, bool offers_orders, std::string map_file, Listener listener)
    : session_(std::move(session)),
      offers_orders_(offers_orders),
      map_file_(std::move(map_file)),
      listener_(std::move(listener)) {}

void FoxgloveServer::Open(int64_t id) {
  {
    const std::scoped_lock lock(mutex_);
    Client& client = clients_[id];
    json capabilities = json::array({"parameters"});
    if (offers_orders_) capabilities.push_back("services");
    client.queue.PutEvery(TextFrame({{"op", "serverInfo"},
                                     {"name", "plslam"},
                                     {"capabilities", capabilities},
                                     {"supportedEncodings", {"cdr"}},
                                     {"metadata", json::object()},
                                     {"sessionId", session_}}));
    client.queue.PutEvery(TextFrame({{"op", "advertise"}, {"channels", ChannelsJson()}}));
    if (offers_orders_) {
      json services = json::array();
      for (size_t i = 0; i < RosServices().size(); ++i) {
        services.push_back(ServiceJson(static_cast<uint32_t>(i), RosServices()[i]));
      }
      client.queue.PutEvery(TextFrame({{"op", "advertiseServices"}, {"services", services}}));
    }
  }
  listener_.on_output();
}

void FoxgloveServer::Close(int64_t id) {
  const std::scoped_lock lock(mutex_);
  const auto client = clients_.find(id);
  if (client == clients_.end()) return;
  n_dropped_ += client->second.queue.n_dropped();
  clients_.erase(client);
  CountImageSubscriptions();
}

void FoxgloveServer::TakeText(int64_t id, std::string_view text) {
  {
    const std::scoped_lock lock(mutex_);
    const auto found = clients_.find(id);
    if (found == clients_.end()) return;
    Client& client = found->second;
    try {
      if (text.size() > kMostTextBytes) throw std::runtime_error("the message is too long");
      const json message = json::parse(text);
      const auto op = message.at("op").get<std::string>();
      if (op == "subscribe") {
        for (const json& one : message.at("subscriptions"))
          Subscribe(client, IdIn(one, "id"), IdIn(one, "channelId"));
      } else if (op == "unsubscribe") {
        for (const json& one : message.at("subscriptionIds")) {
          const auto subscription = one.get<uint32_t>();
          client.channels.erase(subscription);
          client.queue.Forget(subscription);
        }
      } else if (op == "getParameters" || op == "setParameters") {
        std::vector<std::string> names;
        if (op == "getParameters") names = message.value("parameterNames", names);
        if (op == "setParameters") {
          PutStatus(client, kError, "parameters are read-only: change the configuration and restart the processes");
          for (const json& one : message.at("parameters")) names.push_back(one.at("name").get<std::string>());
        }
        SendParameters(client, names, message.value("id", std::string()));
      } else if (op != "subscribeParameterUpdates" && op != "unsubscribeParameterUpdates") {
        PutStatus(client, kWarning, fmt::format("'{}' is not offered here", Shown(op)));
      }
    } catch (const std::exception& error) {
      PutStatus(client, kError, fmt::format("the message cannot be read: {}", Shown(error.what())));
    }
    CountImageSubscriptions();
  }
  listener_.on_output();
}

void FoxgloveServer::Subscribe(Client& client, uint32_t subscription, uint32_t channel) {
  if (channel >= Channels().size()) return PutStatus(client, kError, fmt::format("there is no channel {}", channel));
  if (client.channels.size() >= kMostSubscriptions)
    return PutStatus(client, kError, "there are too many subscriptions");
  if (!client.channels.emplace(subscription, channel).second) {
    return PutStatus(client, kError, fmt::format("the subscription {} exists already", subscription));
  }
  const auto latched = latched_.find(channel);
  if (latched != latched_.end()) Put(client, subscription, channel, latched->second.t_ns, latched->second.cdr);
}

void FoxgloveServer::SendParameters(Client& client, const std::vector<std::string>& names, const std::string& id) {
  json values = json::array();
  for (const auto& [process, parameters] : parameters_) {
    for (const auto& [name, value] : parameters) {
      if (!names.empty() && std::find(names.begin(), names.end(), name) == names.end()) continue;
      values.push_back({{"name", name}, {"value", ValueOf(value)}});
    }
  }
  json message{{"op", "parameterValues"}, {"parameters", values}};
  if (!id.empty()) message["id"] = id;
  client.queue.PutEvery(TextFrame(message));
}

void FoxgloveServer::CountImageSubscriptions() {
  int n = 0;
  for (const auto& [id, client] : clients_) {
    for (const auto& [subscription, channel] : client.channels) n += Channels()[channel].rate == RosRate::kImage;
  }
  n_image_subscriptions_ = n;
}

/// Completes the call; returns the reason why it cannot be carried out, or an empty text.
std::string FoxgloveServer::FailureOf(ServiceCall& call, std::string_view encoding,
                                      std::span<const uint8_t> payload) const {
  constexpr size_t kCdrHeadBytes = 4;
  if (!offers_orders_ || call.service >= RosServices().size()) {
    return fmt::format("there is no service {}", call.service);
  }
  if (encoding != "cdr") return fmt::format("requests are in cdr, not in '{}'", Shown(encoding));
  try {
    call.order = OrderOf(RosServices()[call.service], payload.subspan(std::min(kCdrHeadBytes, payload.size())),
                         map_file_, "plslam bridge");
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "";
}

void FoxgloveServer::TakeBinary(int64_t id, std::span<const uint8_t> bytes) {
  std::optional<ServiceCall> accepted;
  {
    const std::scoped_lock lock(mutex_);
    const auto found = clients_.find(id);
    if (found == clients_.end()) return;
    Client& client = found->second;
    try {
      if (bytes.empty() || bytes[0] != kServiceRequest) throw std::runtime_error("its opcode is not offered here");
      bytes = bytes.subspan(1);
      ServiceCall call{id, GetUint32(bytes), GetUint32(bytes), {}};
      const uint32_t n_encoding = GetUint32(bytes);
      if (n_encoding > bytes.size()) throw std::runtime_error("a message ends before its last field");
      const std::string_view encoding(reinterpret_cast<const char*>(bytes.data()), n_encoding);
      const std::string failure = FailureOf(call, encoding, bytes.subspan(n_encoding));
      if (failure.empty()) {
        accepted = std::move(call);
      } else {
        client.queue.PutEvery(TextFrame({{"op", "serviceCallFailure"},
                                         {"serviceId", call.service},
                                         {"callId", call.call},
                                         {"message", failure}}));
      }
    } catch (const std::exception& error) {
      PutStatus(client, kError, fmt::format("the binary message cannot be read: {}", error.what()));
    }
  }
  if (accepted) listener_.on_call(*std::move(accepted));
  listener_.on_output();
}

void FoxgloveServer::Answer(const ServiceCall& call, bool done, const std::string& sentence) {
  {
    const std::scoped_lock lock(mutex_);
    const auto client = clients_.find(call.client);
    if (client == clients_.end()) return;
    CdrWriter cdr;
    cdr.Put(done);
    cdr.Put(std::string_view(sentence));
    std::string head(1, static_cast<char>(kServiceResponse));
    for (const uint32_t number : {call.service, call.call, 3U}) AppendLittleEndian(number, head);
    head += "cdr";
    client->second.queue.PutEvery({head, std::make_shared<std::string>(std::move(cdr).Take()), true});
  }
  listener_.on_output();
}

void FoxgloveServer::SetParameters(const std::string& process, std::map<std::string, std::string> values) {
  const std::scoped_lock lock(mutex_);
  parameters_[process] = std::move(values);
}

void FoxgloveServer::PutStatus(Client& client, int level, const std::string& sentence) {
  client.queue.PutEvery(TextFrame({{"op", "status"}, {"level", level}, {"message", sentence}}));
}

void FoxgloveServer::Put(Client& client, uint32_t subscription, uint32_t channel, int64_t t_ns,
                         const std::shared_ptr<const std::string>& cdr) {
  std::string head(1, static_cast<char>(kMessageData));
  AppendLittleEndian(subscription, head);
  AppendLittleEndian(static_cast<uint64_t>(t_ns), head);
  OutFrame frame{std::move(head), cdr, true};
  if (Channels()[channel].qos == RosQos::kReliable) return client.queue.PutEvery(std::move(frame));
  client.queue.PutNewest(subscription, std::move(frame));
}

void FoxgloveServer::Write(const RosTopic& topic, int64_t t_ns, std::string cdr) {
  const auto row = std::find_if(Channels().begin(), Channels().end(),
                                [&](const RosTopic& channel) { return channel.name == topic.name; });
  if (row == Channels().end()) throw std::logic_error(fmt::format("{} is no live topic", topic.name));
  const auto channel = static_cast<uint32_t>(row - Channels().begin());
  const auto shared = std::make_shared<const std::string>(std::move(cdr));
  {
    const std::scoped_lock lock(mutex_);
    if (topic.qos == RosQos::kLatched) latched_[channel] = {t_ns, shared};
    for (auto& [id, client] : clients_) {
      for (const auto& [subscription, subscribed] : client.channels) {
        if (subscribed == channel) Put(client, subscription, channel, t_ns, shared);
      }
    }
  }
  listener_.on_output();
}

std::optional<OutFrame> FoxgloveServer::Next(int64_t id) {
  const std::scoped_lock lock(mutex_);
  const auto client = clients_.find(id);
  return client == clients_.end() ? std::nullopt : client->second.queue.Take();
}

bool FoxgloveServer::HasOutput(int64_t id) const {
  const std::scoped_lock lock(mutex_);
  const auto client = clients_.find(id);
  return client != clients_.end() && !client->second.queue.empty();
}

bool FoxgloveServer::IsTooSlow(int64_t id) const {
  const std::scoped_lock lock(mutex_);
  const auto client = clients_.find(id);
  return client != clients_.end() && client->second.queue.is_too_slow();
}

size_t FoxgloveServer::n_clients() const {
  const std::scoped_lock lock(mutex_);
  return clients_.size();
}

int64_t FoxgloveServer::n_dropped() const {
  const std::scoped_lock lock(mutex_);
  int64_t n = n_dropped_;
  for (const auto& [id, client] : clients_) n += client.queue.n_dropped();
  return n;
}

}  // namespace plslam::bridge
