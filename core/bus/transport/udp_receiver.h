// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <netinet/in.h>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "core/bus/transport/packet_parts.h"
#include "core/bus/transport/wire.h"

namespace plslam::bus {

/// Larger datagrams (bytes, with UDP header and LCM's head) are filtered by their channel: strips of images, pages of
/// keyframes and maps.
inline constexpr size_t kUnfilteredBytes = 16'384;

/// Channels whose messages name their destination: after the header a string, then the process.
struct AddressedChannels {
  std::set<std::string, std::less<>> names;
  int64_t fingerprint = 0;
  int64_t own = 0;  ///< messages for this process are received, and those for 0, which means all
};

/// Has the kernel drop LCM packets before they take room in the buffer of the UDP socket `fd` and wake its reader
/// (classic BPF, which needs no privileges: socket(7), SO_ATTACH_FILTER): large ones and parts (`PacketParts`) of
/// channels other than `names`, those of `addressed` channels that are for another process, and all of `unwanted`
/// channels. Images that only the tracker reads then cost the other processes no time, and an acknowledgement only the
/// publisher. Parts of other programs' messages, packets that are not LCM's, and addressed messages that are malformed
/// or of another version are received as before. Replaces the previous filter; if the kernel rejects it, everything is
/// received.
void FilterDatagrams(int fd, const std::set<std::string, std::less<>>& names, const AddressedChannels& addressed = {},
                     const std::set<std::string, std::less<>>& unwanted = {});

/// Removes the filter.
void RemoveDatagramFilter(int fd);

/// A packet of LCM: magic and number (both 32 bits), name of the channel, 0, message.
inline constexpr uint32_t kLcmMagic = 0x4c433032;
inline constexpr size_t kLcmHeadBytes = 8;

/// A multicast group in an LCM URL.
struct UdpGroup {
  std::string address = "239.255.76.67";
  uint16_t port = 7667;
  /// Requested size of the receive buffer; 0: the system's default.
  int64_t buffer_bytes = 0;
  int ttl = 0;
};

/// Parses `udpm://[ADDRESS][:PORT][?ttl=N&recv_buf_size=N]`; throws std::runtime_error if it is invalid.
UdpGroup ParseUdpGroup(const std::string& url);

/// Receives LCM messages of one datagram each, as all messages of plslam are, and those of `PacketParts`. LCM 1.3.1 itself crashes on forged parts of
/// longer messages (a first part without a channel name wraps its length) and stores every channel name that it has
/// ever received, so received packets do not pass through it. To be used by one thread.
class UdpReceiver {
 public:
  using Receiver = std::function<void(std::string_view channel, ByteView bytes)>;
  /// Whether parts of messages of a channel with this digest are wanted.
  using Wanted = std::function<bool(uint32_t channel_digest)>;

  /// Throws std::runtime_error where the group cannot be joined.
  explicit UdpReceiver(const std::string& url);
  ~UdpReceiver();
  UdpReceiver(const UdpReceiver&) = delete;
  UdpReceiver& operator=(const UdpReceiver&) = delete;

  /// Readable when there is something.
  int fd() const { return fd_; }

  /// A datagram, valid until the next one; `sender` identifies the sending socket.
  struct Datagram {
    uint64_t sender = 0;
    ByteView bytes;
  };
  /// Returns nullopt if none is there.
  std::optional<Datagram> ReceiveDatagram();

  enum class Outcome { kMessage, kPart, kJunk, kNothing };
  /// Takes one datagram that is there and hands its message on. kPart: it holds a part of a message that is
  /// incomplete, not wanted, or another program's. kJunk: it holds neither.
  Outcome Receive(const Receiver& receiver, const Wanted& wanted);

 private:
  int fd_ = -1;
  std::vector<uint8_t> buffer_;
  PacketParts parts_;
};

/// Sends messages to a multicast group in packets (`PacketParts`), from a socket of its own: the numbers of parts count
/// for a socket. Safe from one thread at a time.
class PartsSender {
 public:
  /// Throws std::runtime_error if there is no socket.
  explicit PartsSender(const std::string& url);
  ~PartsSender();
  PartsSender(const PartsSender&) = delete;
  PartsSender& operator=(const PartsSender&) = delete;

  /// Returns false if a packet could not be sent.
  bool Send(std::string_view channel, ByteView message, int64_t seq);

 private:
  sockaddr_in group_{};
  int fd_ = -1;
  uint32_t attempt_ = 0;
};

/// Parses the message in a packet: channel and bytes within it. Returns false if there is none.
bool ParsePacket(ByteView packet, std::string_view* channel, ByteView* bytes);

}  // namespace plslam::bus
