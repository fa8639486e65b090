// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/ros/ros_services.h"
#include "core/ros/ros_topics.h"
#include "tools/bridge/client_queue.h"

namespace plslam::bridge {

/// A call of a service, which is an order to the system.
struct ServiceCall {
  int64_t client = 0;
  uint32_t service = 0, call = 0;
  ServiceOrder order;
};

/// The server's side of the Foxglove WebSocket protocol (foxglove.websocket.v1, and foxglove.sdk.v1, which has the same
/// messages): the live rows of the table of topics as channels in CDR, orders as services, the configuration of the
/// processes as parameters, which cannot be set. It knows nothing of sockets: clients are numbers, and what is to be
/// sent to one is taken with `Next`. Safe from any thread.
class FoxgloveServer {
 public:
  struct Listener {
    /// Something waits to be sent.
    std::function<void()> on_output;
    std::function<void(ServiceCall call)> on_call;
  };
  /// `map_file` of the services save and load; empty: they fail with a sentence. Without `offers_orders` there are no
  /// services. `session` differs from start to start.
  FoxgloveServer(std::string session, bool offers_orders, std::string map_file, Listener listener);

  // Events of the socket.
  void Open(int64_t client);
  void Close(int64_t client);
  /// Messages of a client. Invalid ones are answered with a status.
  void TakeText(int64_t client, std::string_view json);
  void TakeBinary(int64_t client, std::span<const uint8_t> bytes);
  /// Returns the next message to this client.
  std::optional<OutFrame> Next(int64_t client);
  bool HasOutput(int64_t client) const;
  /// The client does not take its messages, and is to be disconnected.
  bool IsTooSlow(int64_t client) const;

  // Events of the run.
  void Write(const RosTopic& topic, int64_t t_ns, std::string cdr);
  void Answer(const ServiceCall& call, bool done, const std::string& sentence);
  /// Sets the parameters of a process, by their names ("vo.features.kind").
  void SetParameters(const std::string& process, std::map<std::string, std::string> values);

  /// Whether a client is subscribed to images.
  bool wants_images() const { return n_image_subscriptions_ > 0; }
  size_t n_clients() const;
  int64_t n_dropped() const;

 private:
  struct Client {
    std::map<uint32_t, uint32_t> channels;  ///< by subscription
    ClientQueue queue;
  };
  /// The last message of a channel whose late subscribers receive it.
  struct Latched {
    int64_t t_ns = 0;
    std::shared_ptr<const std::string> cdr;
  };

  void Put(Client& client, uint32_t subscription, uint32_t channel, int64_t t_ns,
           const std::shared_ptr<const std::string>& cdr);
  void PutStatus(Client& client, int level, const std::string& sentence);
  void Subscribe(Client& client, uint32_t subscription, uint32_t channel);
  void SendParameters(Client& client, const std::vector<std::string>& names, const std::string& id);
  void CountImageSubscriptions();
  std::string FailureOf(ServiceCall& call, std::string_view encoding, std::span<const uint8_t> payload) const;

  const std::string session_;
  const bool offers_orders_;
  const std::string map_file_;
  const Listener listener_;
  mutable std::mutex mutex_;
  std::map<int64_t, Client> clients_;
  std::map<uint32_t, Latched> latched_;  ///< by channel
  std::map<std::string, std::map<std::string, std::string>> parameters_;
  int64_t n_dropped_ = 0;  ///< of clients that have left
  std::atomic<int> n_image_subscriptions_ = 0;
};

}  // namespace plslam::bridge
