// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "core/bus/transport/wire.h"

namespace plslam::bus {

/// Larger datagrams (bytes, with UDP header and LCM's head) are filtered by their channel: strips of images, pages of
/// keyframes and maps.
inline constexpr size_t kUnfilteredBytes = 16'384;

/// Has the kernel drop large LCM packets of channels other than `names` before they take room in the buffer of the
/// UDP socket `fd` and wake its reader (classic BPF, which needs no privileges: socket(7), SO_ATTACH_FILTER). Images
/// that only the tracker reads then cost the other processes nothing. Parts of longer messages, and what is no LCM
/// packet, come as before. Takes the place of the filter before; where the kernel refuses, everything comes.
void FilterLargeDatagrams(int fd, const std::set<std::string, std::less<>>& names);

/// Everything comes again.
void RemoveDatagramFilter(int fd);

/// A packet of LCM: magic and number (both 32 bits), name of the channel, 0, message.
inline constexpr uint32_t kLcmMagic = 0x4c433032;
inline constexpr size_t kLcmHeadBytes = 8;

/// A multicast group in an LCM URL.
struct UdpGroup {
  std::string address = "239.255.76.67";
  uint16_t port = 7667;
  /// Receive buffer to ask for; 0: the system's.
  int64_t buffer_bytes = 0;
};

/// Group of a `udpm://[ADDRESS][:PORT][?ttl=N&recv_buf_size=N]`; throws std::runtime_error where it is none.
UdpGroup ParseUdpGroup(const std::string& url);

/// Receives LCM messages of one packet each, which all of ours are. LCM 1.3.1 itself crashes on forged parts of
/// longer messages (a first part without a channel name wraps its length) and remembers every channel name that it
/// has ever seen, so what comes from a network does not go through it. For one thread.
class UdpReceiver {
 public:
  using Receiver = std::function<void(std::string_view channel, ByteView bytes)>;

  /// Throws std::runtime_error where the group cannot be joined.
  explicit UdpReceiver(const std::string& url);
  ~UdpReceiver();
  UdpReceiver(const UdpReceiver&) = delete;
  UdpReceiver& operator=(const UdpReceiver&) = delete;

  /// Readable when there is something.
  int fd() const { return fd_; }

  /// A datagram as it came, until the next one; `sender` tells the sockets apart that send. nullopt: there is none.
  struct Datagram {
    uint64_t sender = 0;
    ByteView bytes;
  };
  std::optional<Datagram> ReceiveDatagram();

  enum class Outcome { kMessage, kPart, kJunk, kNothing };
  /// Takes one datagram that is there and hands its message on. kPart: it holds a part of a long message, which is
  /// another program's. kJunk: it holds neither.
  Outcome Receive(const Receiver& receiver);

 private:
  int fd_ = -1;
  std::vector<uint8_t> buffer_;
};

/// The message in a packet: channel and bytes within it. False where there is none.
bool ParsePacket(ByteView packet, std::string_view* channel, ByteView* bytes);

}  // namespace plslam::bus
