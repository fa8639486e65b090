// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <map>
#include <memory>
#include <optional>
#include <random>
#include <string>
#include <string_view>
#include <thread>

#include "core/bus/bus.h"
#include "core/bus/channel_names.h"
#include "core/bus/inboxes.h"
#include "core/bus/outboxes.h"
#include "core/bus/run_loop.h"
#include "core/bus/transport/authenticator.h"
#include "core/bus/transport/live_peers.h"
#include "core/bus/transport/rejections.h"
#include "core/bus/transport/transport.h"
#include "core/ids/ids.h"

namespace plslam::bus {

/// The two halves of a bus and their connection: a thread that receives datagrams, checks them, and dispatches messages
/// to the inboxes, and acknowledgements and repair requests to the outboxes.
struct Bus::Impl {
  Impl(const BusOptions& options, std::string process);
  ~Impl();

  void Subscribe(const Channel& channel, const char* type, std::shared_ptr<Subscription> subscription);
  void SubscribeRest(Inboxes::Rest rest);
  void Publish(const Channel& channel, const char* type, header_t& header, const std::function<int()>& encoded_size,
               const Encode& encode);
  void MayReceive();
  BusCounters counters() const;
  std::string Problems() const;
  bool hears_other_key() const;

  const BusOptions options;
  const std::string process;
  const ChannelNames names;
  const SourceId source;
  const Authenticator authenticator;
  Transport transport;
  RunLoop loop;
  Outboxes outboxes;
  ReceiverCounts counts;
  Inboxes inboxes;

 private:
  // The following functions run on the receiving thread.
  void ReceiveLoop();
  void OnDatagram(std::string_view wire_name, ByteView bytes);
  bool Drop();
  void Reject(Rejection why, std::string_view wire_name, int64_t now);
  std::optional<Rejection> WhyNot(std::string_view wire_name, const MessageLayout& layout, ByteView bytes,
                                  size_t* length) const;
  /// Checked message without its MAC; empty if it is rejected.
  ByteView Checked(std::string_view wire_name, const MessageLayout& layout, ByteView bytes, int64_t now);
  bool IsAlive(std::string_view wire_name, ByteView message, int64_t now);
  void NoticePrefix(std::string_view wire_name, int64_t now);

  void OnRepairRequest(std::string_view wire_name, ByteView message, int64_t now);
  void OnAnnounce(std::string_view wire_name, ByteView message, int64_t now);
  void Announce(const Outboxes::Announcement& what);
  void Request(const Channel& channel, SourceId publisher, const OrderedReader::Request& request);
  void SendHello(SourceId peer, bool question);
  template <class T>
  void SendControl(const Channel& channel, Scope scope, T message);

  const MessageLayout* request_layout_ = nullptr;
  const MessageLayout* announce_layout_ = nullptr;
  std::map<std::string, int64_t, std::less<>> control_seq_;
  std::mt19937_64 drop_random_;
  LivePeers peers_;  // with a key
  Rejections rejections_;
  std::atomic<int64_t> wake_time_ = 0;
  std::atomic<bool> stopping_ = false;
  /// A log that is read does not wait for subscriptions: it is begun when they have been made, with `Run`.
  std::atomic<bool> may_receive_{false};
  std::thread receiver_;
};

}  // namespace plslam::bus
