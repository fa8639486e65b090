// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <lcm/lcm.h>

#include "core/bus/transport/udp_receiver.h"
#include "core/bus/transport/wire.h"

namespace plslam::bus {

/// The URL that counts where `url` may be empty: then LCM_DEFAULT_URL, or LCM's default.
std::string EffectiveUrl(const std::string& url);

/// Names a bus in sentences: "udpm://239.255.76.67:7667?ttl=1 with the prefix team/".
std::string BusText(const std::string& url, const std::string& prefix);

/// Returns a udpm URL that requests a larger receive buffer, if the system grants one and the user has not specified
/// any.
std::string WithReceiveBuffer(const std::string& url);

/// A channel name as a pattern for LCM that matches only itself.
std::string Quoted(const std::string& channel);

/// Requested size of the receive buffer if the system allows more than its default.
inline constexpr int64_t kWantedReceiveBuffer = 2'000'000;

/// One LCM instance: URL, raw publishing and raw reception (of udpm by a receiver of our own, see UdpReceiver).
/// `Send` and `Listen` are safe from any thread; `Receive` belongs to one.
class Transport {
 public:
  enum class Kind { kUdpMulticast, kTcpRelay, kFileRead, kFileWrite, kMemory };
  using Receiver = std::function<void(std::string_view channel, ByteView bytes)>;

  /// Empty URL: LCM_DEFAULT_URL, or LCM's default. Throws std::runtime_error with one sentence.
  explicit Transport(const std::string& url);
  ~Transport();
  Transport(const Transport&) = delete;
  Transport& operator=(const Transport&) = delete;

  Kind kind() const { return kind_; }
  /// URL as given to LCM.
  const std::string& url() const { return url_; }
  /// Whether messages are datagrams that leave this host. Within it, a datagram of any size is one packet.
  bool leaves_host() const { return leaves_host_; }
  /// Returns whether messages can go both ways, as repair requires.
  bool two_way() const { return kind_ != Kind::kFileRead && kind_ != Kind::kFileWrite; }
  /// Bytes of large datagrams that the receiving socket holds.
  int64_t receive_window() const { return window_; }

  /// Returns false if it could not be sent (a closed connection, a log opened for reading).
  bool Send(const std::string& channel, ByteView bytes);
  /// The same in parts of one packet each (`PacketParts`), where messages are datagrams. `seq`: the message's number.
  bool SendInPackets(const std::string& channel, ByteView bytes, int64_t seq);

  /// Passes all messages of `channel` (a name, no pattern) to the receiver from now on.
  void Listen(const std::string& channel);
  /// Passes messages of these channels to this process or to all; some transports pass others, too. Called once.
  void Listen(const AddressedChannels& channels);
  /// Channels with so many packets that they are dropped in the kernel unless they are listened to. Called once.
  void SetBulky(std::set<std::string, std::less<>> channels);
  /// Passes all messages of channels whose name has this ending; over multicast, only small ones (FilterDatagrams).
  void ListenToEnding(std::string_view ending);
  /// Passes all messages of all channels; `Listen` is then not needed.
  void ListenToAll();

  /// Datagrams that held no message of one packet.
  int64_t junk() const { return junk_; }

  void SetReceiver(Receiver receiver) { receiver_ = std::move(receiver); }

  /// Waits at most until `timeout_ms` for messages or `Wake`, and passes at least one available message to the
  /// receiver. Returns false at the end of a log; from then on it waits for `Wake` only.
  bool Receive(int timeout_ms);
  /// Makes `Receive` return soon; from any thread.
  void Wake();

 private:
  void Subscribe(const std::string& pattern);
  bool ReceiveUdp(int timeout_ms);
  /// With listen_mutex_.
  void FilterUdp();
  bool HasListenedEnding(std::string_view channel) const;
  bool IsListenedTo(std::string_view channel);
  bool WantsParts(uint32_t channel_digest);
  bool WaitReadable(int timeout_ms, int fd) const;

  std::string url_;
  Kind kind_;
  int64_t window_ = 0;
  bool leaves_host_ = false;
  lcm_t* lcm_ = nullptr;
  int wake_fd_ = -1;
  std::mutex send_mutex_;  // LCM's tcpq writes a message in pieces, without its own lock
  std::vector<lcm_subscription_t*> subscriptions_;
  bool listens_to_all_ = false;
  bool ended_ = false;  // a log that is read
  std::unique_ptr<UdpReceiver> udp_;
  /// By channel, so that the numbers of two channels' parts never meet; guarded by send_mutex_.
  std::map<std::string, PartsSender> parts_senders_;
  std::mutex listen_mutex_;  // guards the following members, and `listens_to_all_`
  std::set<std::string, std::less<>> names_;
  std::set<uint32_t> digests_;  // of `names_`
  std::set<std::string, std::less<>> bulky_;
  AddressedChannels addressed_;
  std::vector<std::string> endings_;
  std::atomic<int64_t> junk_{0};
  Receiver receiver_;
};

/// The sentence of all programs about a multicast group to which this host has no route: `error_number` is the
/// system's, 0 if unknown. Its remedy: `kMulticastOverLoopback`, as root, for processes of one host.
std::string NoRouteToGroup(const std::string& group, int error_number = 0);
inline constexpr std::array<const char*, 2> kMulticastOverLoopback = {"ip link set lo up multicast on",
                                                                      "ip route replace 224.0.0.0/4 dev lo"};

/// "ADDRESS is no multicast group (...)"; empty if it is one.
std::string WhyNoGroup(const std::string& address);

/// Returns whether datagrams to the multicast group of `url` (udpm; empty: the default) return to this host. `reason`,
/// if given, receives one sentence if they do not.
bool MulticastWorks(const std::string& url, std::string* reason = nullptr);

}  // namespace plslam::bus
