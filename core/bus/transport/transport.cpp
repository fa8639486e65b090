// SPDX-License-Identifier: BSD-3-Clause
#include "core/bus/transport/transport.h"

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cstdlib>
#include <fstream>
#include <stdexcept>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <unistd.h>

#include "core/bus/transport/udp_receiver.h"
#include "core/errors/error_text.h"

namespace plslam::bus {
namespace {

constexpr char kDefaultUrl[] = "udpm://239.255.76.67:7667?ttl=0";
constexpr int64_t kLinuxDefaultBuffer = 212'992;
/// Window where the kernel's receive buffer is no limit: memory, and TCP.
constexpr int64_t kStreamWindow = 1'000'000;

int64_t SystemLimit(const char* name) {
  std::ifstream in(std::string("/proc/sys/net/core/") + name);
  int64_t value = 0;
  return in >> value && value > 0 ? value : kLinuxDefaultBuffer;
}

Transport::Kind KindOf(const std::string& url) {
  if (url.starts_with("udpm://")) return Transport::Kind::kUdpMulticast;
  if (url.starts_with("tcpq://")) return Transport::Kind::kTcpRelay;
  if (url.starts_with("memq://")) return Transport::Kind::kMemory;
  if (!url.starts_with("file://")) {
    throw std::runtime_error("bus.url: " + url + " is not an LCM URL (udpm://, tcpq://, file:// or memq://)");
  }
  const bool writes = url.find("mode=w") != std::string::npos || url.find("mode=a") != std::string::npos;
  return writes ? Transport::Kind::kFileWrite : Transport::Kind::kFileRead;
}

/// LCM ignores parameters that it does not know: a mistyped "ttl" would keep messages on this machine.
void CheckParameters(const std::string& url, Transport::Kind kind) {
  const size_t question = url.find('?');
  if (question == std::string::npos) return;
  const bool file = kind == Transport::Kind::kFileRead || kind == Transport::Kind::kFileWrite;
  const std::vector<std::string> known = file ? std::vector<std::string>{"mode", "speed", "start_timestamp"}
                                         : kind == Transport::Kind::kUdpMulticast
                                             ? std::vector<std::string>{"ttl", "recv_buf_size"}
                                             : std::vector<std::string>{};
  for (size_t begin = question + 1; begin < url.size();) {
    const size_t end = std::min(url.find('&', begin), url.size());
    const std::string name = url.substr(begin, std::min(url.find('=', begin), end) - begin);
    begin = end + 1;
    if (name.empty() || std::ranges::find(known, name) != known.end()) continue;
    throw std::runtime_error(
        fmt::format("bus.url: {} has the unknown parameter '{}' ({})", url, name,
                    known.empty() ? "there are none" : fmt::format("known: {}", fmt::join(known, ", "))));
  }
}

/// Returns why the host of tcpq://HOST:PORT has no address; empty if it has one.
std::string WhyUnknownHost(const std::string& url) {
  const std::string network = url.substr(std::string("tcpq://").size());
  const std::string host = network.substr(0, network.find_first_of(":?"));
  if (host.empty()) return "";
  addrinfo* found = nullptr;
  const int error = getaddrinfo(host.c_str(), nullptr, nullptr, &found);
  if (error != 0) return fmt::format("the host {} is not known ({})", host, gai_strerror(error));
  freeaddrinfo(found);
  return "";
}

/// The share of the socket's buffer that flow control may fill; the rest is for other senders. The kernel counts its
/// own overhead too, and doubles the requested size to make room for that.
int64_t UdpWindow(const std::string& url) {
  const int64_t requested = ParseUdpGroup(url).buffer_bytes;
  const int64_t buffer =
      requested > 0 ? 2 * std::min(requested, SystemLimit("rmem_max")) : SystemLimit("rmem_default");
  return buffer * 5 / 8;
}

void OnLcmMessage(const lcm_recv_buf_t* buffer, const char* channel, void* user) {
  const auto& receiver = *static_cast<const Transport::Receiver*>(user);
  if (receiver) receiver(channel, {static_cast<const uint8_t*>(buffer->data), buffer->data_size});
}

}  // namespace

std::string EffectiveUrl(const std::string& url) {
  if (!url.empty()) return url;
  const char* environment = std::getenv("LCM_DEFAULT_URL");
  return environment != nullptr && *environment != '\0' ? environment : kDefaultUrl;
}

std::string BusText(const std::string& url, const std::string& prefix) {
  return EffectiveUrl(url) + (prefix.empty() ? "" : " with the prefix " + prefix);
}

std::string WithReceiveBuffer(const std::string& url) {
  const int64_t limit = SystemLimit("rmem_max");
  if (ParseUdpGroup(url).buffer_bytes > 0 || 2 * limit <= SystemLimit("rmem_default")) return url;
  const char* separator = url.find('?') == std::string::npos ? "?" : "&";
  return url + separator + "recv_buf_size=" + std::to_string(std::min(limit, kWantedReceiveBuffer));
}

std::string Quoted(const std::string& channel) {
  std::string pattern;
  for (const char c : channel) {
    const bool plain = std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '-' || c == '/';
    pattern += plain ? std::string(1, c) : std::string("[") + c + "]";
  }
  return pattern;
}

Transport::Transport(const std::string& url) : url_(EffectiveUrl(url)), kind_(KindOf(url_)), window_(kStreamWindow) {
  CheckParameters(url_, kind_);
  if (kind_ == Kind::kUdpMulticast) {
    url_ = WithReceiveBuffer(url_);
    window_ = UdpWindow(url_);
    leaves_host_ = ParseUdpGroup(url_).ttl > 0;
    udp_ = std::make_unique<UdpReceiver>(url_);
  }
  errno = 0;
  lcm_ = lcm_create(url_.c_str());
  if (lcm_ == nullptr) {
    throw std::runtime_error(
        fmt::format("bus.url: LCM cannot open {}{}", url_, errno == 0 ? "" : ": " + ReasonOf(errno)));
  }
  if (kind_ == Kind::kTcpRelay) {
    const int reason = errno;
    const int fd = lcm_get_fileno(lcm_);
    if (fd < 0) {
      lcm_destroy(lcm_);
      const std::string why = WhyUnknownHost(url_);
      if (!why.empty()) throw std::runtime_error(fmt::format("bus.url: {}: {}", url_, why));
      throw std::runtime_error(
          fmt::format("bus.url: no relay answers at {}{} (start one with plslam relay; plslam doctor "
                      "checks the network)",
                      url_, reason == 0 ? "" : ": " + ReasonOf(reason)));
    }
    // LCM writes a message in five pieces; without this each waits for the acknowledgement of the one before.
    const int on = 1;
    setsockopt(fd, IPPROTO_TCP, TCP_NODELAY, &on, sizeof(on));
  }
  wake_fd_ = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
}

Transport::~Transport() {
  // LCM's tcpq frees the name of a subscription only when it is ended, for which it may try to connect again.
  const bool connected = kind_ == Kind::kTcpRelay && lcm_get_fileno(lcm_) >= 0;
  for (lcm_subscription_t* subscription : subscriptions_) {
    if (connected) lcm_unsubscribe(lcm_, subscription);
  }
  lcm_destroy(lcm_);
  close(wake_fd_);
}

bool Transport::Send(const std::string& channel, ByteView bytes) {
  if (kind_ == Kind::kFileRead) return false;
  const std::lock_guard lock(send_mutex_);
  return lcm_publish(lcm_, channel.c_str(), bytes.data(), static_cast<unsigned>(bytes.size())) == 0;
}

bool Transport::SendInPackets(const std::string& channel, ByteView bytes, int64_t seq) {
  if (udp_ == nullptr || bytes.size() <= kPartBytes) return Send(channel, bytes);
  const std::lock_guard lock(send_mutex_);
  return parts_senders_.try_emplace(channel, url_).first->second.Send(channel, bytes, seq);
}

void Transport::Listen(const std::string& channel) {
  {
    const std::lock_guard lock(listen_mutex_);
    if (!names_.insert(channel).second) return;
    digests_.insert(ChannelDigest(channel));
    if (udp_ != nullptr) {
      return FilterUdp();
    }
    // LCM hands a message to each pattern that matches it.
    if (HasListenedEnding(channel)) return;
  }
  Subscribe(Quoted(channel));
}

/// With listen_mutex_.
void Transport::FilterUdp() {
  if (listens_to_all_) return;
  std::set<std::string, std::less<>> unwanted;
  std::ranges::set_difference(bulky_, names_, std::inserter(unwanted, unwanted.end()));
  FilterDatagrams(udp_->fd(), names_, addressed_, unwanted);
}

void Transport::SetBulky(std::set<std::string, std::less<>> channels) {
  const std::lock_guard lock(listen_mutex_);
  bulky_ = std::move(channels);
  if (udp_ != nullptr) FilterUdp();
}

void Transport::Listen(const AddressedChannels& channels) {
  {
    const std::lock_guard lock(listen_mutex_);
    addressed_ = channels;
  }
  for (const std::string& name : channels.names) Listen(name);
}

void Transport::ListenToEnding(std::string_view ending) {
  {
    const std::lock_guard lock(listen_mutex_);
    endings_.emplace_back(ending);
  }
  if (udp_ == nullptr) Subscribe(".*" + Quoted(std::string(ending)));
}

void Transport::ListenToAll() {
  {
    // LCM hands a message to each pattern that matches it: once is enough.
    const std::lock_guard lock(send_mutex_);
    if (kind_ == Kind::kFileWrite || listens_to_all_) return;
    for (lcm_subscription_t* subscription : subscriptions_) lcm_unsubscribe(lcm_, subscription);
    subscriptions_.clear();
  }
  if (udp_ == nullptr) Subscribe(".*");
  const std::scoped_lock lock(send_mutex_, listen_mutex_);
  listens_to_all_ = true;
  if (udp_ != nullptr) RemoveDatagramFilter(udp_->fd());
}

/// With send_mutex_: for tcpq this writes to the socket, too.
void Transport::Subscribe(const std::string& pattern) {
  const std::lock_guard lock(send_mutex_);
  if (kind_ == Kind::kFileWrite || listens_to_all_) return;
  lcm_subscription_t* subscription = lcm_subscribe(lcm_, pattern.c_str(), &OnLcmMessage, &receiver_);
  if (subscription == nullptr) throw std::runtime_error("bus.url: LCM cannot receive on " + url_);
  // LCM's own queue drops the newest of 30. Our queue follows it, and it is drained at once.
  lcm_subscription_set_queue_capacity(subscription, 0);
  subscriptions_.push_back(subscription);
}

bool Transport::WaitReadable(int timeout_ms, int fd) const {
  pollfd fds[2] = {{wake_fd_, POLLIN, 0}, {fd, POLLIN, 0}};
  if (poll(fds, fd < 0 ? 1 : 2, timeout_ms) <= 0) return false;
  uint64_t count = 0;
  if ((fds[0].revents & POLLIN) != 0 && read(wake_fd_, &count, sizeof(count)) < 0) return false;
  return fd >= 0 && fds[1].revents != 0;
}

bool Transport::HasListenedEnding(std::string_view channel) const {
  return std::any_of(endings_.begin(), endings_.end(), [&](const std::string& e) { return channel.ends_with(e); });
}

bool Transport::IsListenedTo(std::string_view channel) {
  const std::lock_guard lock(listen_mutex_);
  return listens_to_all_ || names_.contains(channel) || HasListenedEnding(channel);
}

bool Transport::WantsParts(uint32_t channel_digest) {
  const std::lock_guard lock(listen_mutex_);
  return listens_to_all_ || digests_.contains(channel_digest);
}

bool Transport::ReceiveUdp(int timeout_ms) {
  static constexpr int kBatch = 32;
  if (!WaitReadable(timeout_ms, udp_->fd())) return true;
  const auto take = [this](std::string_view channel, ByteView bytes) {
    if (receiver_ && IsListenedTo(channel)) receiver_(channel, bytes);
  };
  for (int i = 0; i < kBatch; ++i) {
    const UdpReceiver::Outcome outcome =
        udp_->Receive(take, [this](uint32_t channel_digest) { return WantsParts(channel_digest); });
    if (outcome == UdpReceiver::Outcome::kNothing) break;
    if (outcome == UdpReceiver::Outcome::kJunk) ++junk_;
  }
  return true;
}

bool Transport::Receive(int timeout_ms) {
  if (udp_ != nullptr) return ReceiveUdp(timeout_ms);
  if (kind_ == Kind::kFileWrite || ended_) {
    WaitReadable(timeout_ms, -1);
    return !ended_;
  }
  const int fd = lcm_get_fileno(lcm_);
  if (fd < 0) {  // tcpq without its relay: LCM tries to connect again within lcm_handle
    WaitReadable(std::min(timeout_ms, 500), -1);
    lcm_handle(lcm_);
    return true;
  }
  if (!WaitReadable(timeout_ms, fd)) return true;
  static constexpr int kBatch = 8;
  for (int i = 0; i < kBatch; ++i) {
    if (lcm_handle(lcm_) != 0) {
      ended_ = kind_ == Kind::kFileRead;
      return !ended_;
    }
    pollfd more = {fd, POLLIN, 0};
    if (poll(&more, 1, 0) <= 0) break;
  }
  return true;
}

void Transport::Wake() {
  const uint64_t one = 1;
  // Fails only if the counter is full, and then the receiver wakes all the same.
  if (write(wake_fd_, &one, sizeof(one)) < 0) return;
}

}  // namespace plslam::bus
