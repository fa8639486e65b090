// SPDX-License-Identifier: BSD-3-Clause
#include "core/bus/transport/udp_receiver.h"

#include <arpa/inet.h>
#include <linux/filter.h>
#include <netinet/in.h>
#include <unistd.h>

#include <sys/socket.h>
#include <algorithm>
#include <cerrno>
#include <charconv>
#include <chrono>
#include <cstdint>
#include <cstring>
#include <stdexcept>
#include <vector>

#include "core/bus/transport/long_messages.h"
#include "core/bus/transport/transport.h"
#include "core/errors/error_text.h"

namespace plslam::bus {
namespace {

// The filter sees a datagram from its UDP header on.
constexpr uint32_t kPacketAt = 8;
constexpr uint32_t kNameAt = kPacketAt + kLcmHeadBytes;
// BPF's answers: how many bytes of the datagram are kept.
constexpr uint32_t kAll = 0xffffffff;
constexpr uint32_t kNone = 0;

using Program = std::vector<sock_filter>;

void Load(Program& program, uint16_t size, uint32_t at) {
  program.push_back({static_cast<uint16_t>(BPF_LD | size | BPF_ABS), 0, 0, at});
}

void Return(Program& program, uint32_t answer) { program.push_back({BPF_RET | BPF_K, 0, 0, answer}); }

// Skips `skipped` instructions if the loaded value is not `value`.
void Expect(Program& program, uint32_t value, size_t skipped) {
  program.push_back({BPF_JMP | BPF_JEQ | BPF_K, 0, static_cast<uint8_t>(skipped), value});
}

// Runs `rest` for a datagram on this channel, and continues after it for other channels. At most 64 bytes are compared
// by words, then by single bytes, two instructions each.
void IfChannel(Program& program, const std::string& name, const Program& rest) {
  const size_t size = name.size() + 1;  // with the terminating zero
  const size_t words = size / 4;
  const size_t comparisons = words + size % 4;
  const auto byte = [&name](size_t i) { return static_cast<uint32_t>(static_cast<unsigned char>(name.c_str()[i])); };
  size_t at = 0;
  for (size_t i = 0; i < comparisons; ++i) {
    const bool word = i < words;
    const uint32_t value = word ? byte(at) << 24 | byte(at + 1) << 16 | byte(at + 2) << 8 | byte(at + 3) : byte(at);
    Load(program, word ? BPF_W : BPF_B, kNameAt + static_cast<uint32_t>(at));
    Expect(program, value, 2 * (comparisons - i - 1) + rest.size());
    at += word ? 4 : 1;
  }
  program.insert(program.end(), rest.begin(), rest.end());
}

// Answers for a datagram of the channel that is long enough for a message to begin in it.
Program DropForOthers(const AddressedChannels& addressed, uint32_t message_at, uint32_t string_at) {
  const auto high = [](int64_t value) { return static_cast<uint32_t>(static_cast<uint64_t>(value) >> 32); };
  const auto low = [](int64_t value) { return static_cast<uint32_t>(value); };
  Program program;
  // The program continues if the loaded value is (equal to, or at least) `value`; otherwise it accepts the datagram.
  const auto keep_unless = [&program](uint16_t jump, uint32_t value) {
    program.push_back({static_cast<uint16_t>(BPF_JMP | jump | BPF_K), 1, 0, value});
    Return(program, kAll);
  };
  const auto load_process = [&program, string_at](uint32_t word) {
    program.push_back({BPF_LD | BPF_W | BPF_IND, 0, 0, string_at + 4 * word});
  };
  Load(program, BPF_W, message_at);
  keep_unless(BPF_JEQ, high(addressed.fingerprint));
  Load(program, BPF_W, message_at + 4);
  keep_unless(BPF_JEQ, low(addressed.fingerprint));
  // The length of the string, where the process is looked for.
  Load(program, BPF_W, string_at - 4);
  program.push_back({BPF_JMP | BPF_JGT | BPF_K, 0, 1, static_cast<uint32_t>(kMaxChannelBytes) + 1});
  Return(program, kAll);
  program.push_back({BPF_MISC | BPF_TAX, 0, 0, 0});
  program.push_back({BPF_LD | BPF_W | BPF_LEN, 0, 0, 0});
  program.push_back({BPF_ALU | BPF_SUB | BPF_X, 0, 0, 0});
  keep_unless(BPF_JGE, string_at + 8);
  for (const int64_t process : {addressed.own, int64_t{0}}) {
    load_process(0);
    Expect(program, high(process), 3);
    load_process(1);
    Expect(program, low(process), 1);
    Return(program, kAll);
  }
  Return(program, kNone);
  return program;
}

// Appends the filter of an addressed channel. Short datagrams are accepted: a program that reads beyond the end would
// drop them.
void AppendAddressed(Program& program, const AddressedChannels& addressed, const std::string& name) {
  const uint32_t message_at = kNameAt + static_cast<uint32_t>(name.size()) + 1;
  const uint32_t string_at = message_at + static_cast<uint32_t>(kWireHeaderBytes) + 4;
  Program rest;
  IfChannel(rest, name, DropForOthers(addressed, message_at, string_at));
  program.push_back({BPF_LD | BPF_W | BPF_LEN, 0, 0, 0});
  program.push_back({BPF_JMP | BPF_JGE | BPF_K, 0, static_cast<uint8_t>(rest.size()), string_at});
  program.insert(program.end(), rest.begin(), rest.end());
}

// Answers for a part of a message: other programs' parts are accepted, and those of `names`.
Program AnswerParts(const std::set<std::string, std::less<>>& names) {
  Program program;
  Load(program, BPF_W, kPacketAt + 4);
  program.push_back({BPF_ALU | BPF_RSH | BPF_K, 0, 0, kDigestShift});
  std::set<uint32_t> digests;
  for (const std::string& name : names) digests.insert(PartsNumber(name, 0, 0) >> kDigestShift);
  // Marked digests are at least this.
  program.push_back({BPF_JMP | BPF_JGE | BPF_K, 1, 0, kDigestMark});
  Return(program, kAll);
  for (const uint32_t digest : digests) {
    Expect(program, digest, 1);
    Return(program, kAll);
  }
  Return(program, kNone);
  return program;
}

}  // namespace

void FilterDatagrams(int fd, const std::set<std::string, std::less<>>& names, const AddressedChannels& addressed,
                     const std::set<std::string, std::less<>>& unwanted) {
  Program program;
  const Program keep{{BPF_RET | BPF_K, 0, 0, kAll}}, drop{{BPF_RET | BPF_K, 0, 0, kNone}};
  program.push_back({BPF_LD | BPF_W | BPF_LEN, 0, 0, 0});
  program.push_back({BPF_JMP | BPF_JGE | BPF_K, 1, 0, kNameAt});
  Return(program, kAll);
  Load(program, BPF_W, kPacketAt);
  const Program parts = AnswerParts(names);
  // Too many for a jump: all parts are received.
  if (parts.size() < 256) {
    Expect(program, kPartMagic, parts.size());
    program.insert(program.end(), parts.begin(), parts.end());
  }
  program.push_back({BPF_JMP | BPF_JEQ | BPF_K, 1, 0, kLcmMagic});
  Return(program, kAll);
  for (const std::string& name : addressed.names) AppendAddressed(program, addressed, name);
  for (const std::string& name : unwanted) IfChannel(program, name, drop);
  program.push_back({BPF_LD | BPF_W | BPF_LEN, 0, 0, 0});
  program.push_back({BPF_JMP | BPF_JGT | BPF_K, 1, 0, static_cast<uint32_t>(kUnfilteredBytes)});
  Return(program, kAll);
  for (const std::string& name : names) IfChannel(program, name, keep);
  Return(program, kNone);
  if (program.size() > BPF_MAXINSNS) return RemoveDatagramFilter(fd);
  const sock_fprog filter{static_cast<unsigned short>(program.size()), program.data()};
  // The one before would keep new channels out.
  if (setsockopt(fd, SOL_SOCKET, SO_ATTACH_FILTER, &filter, sizeof filter) != 0) RemoveDatagramFilter(fd);
}

void RemoveDatagramFilter(int fd) {
  const int unused = 0;
  setsockopt(fd, SOL_SOCKET, SO_DETACH_FILTER, &unused, sizeof unused);
}

namespace {

constexpr std::string_view kScheme = "udpm://";
constexpr size_t kMaxDatagram = 65'536;

template <class T>
bool ParseNumber(std::string_view text, T* value) {
  const auto result = std::from_chars(text.data(), text.data() + text.size(), *value);
  return result.ec == std::errc() && result.ptr == text.data() + text.size();
}

bool Join(int fd, const UdpGroup& group) {
  const int yes = 1, no = 0;
  sockaddr_in name{};
  name.sin_family = AF_INET;
  name.sin_port = htons(group.port);
  ip_mreq membership{};
  const int wanted = static_cast<int>(std::min<int64_t>(group.buffer_bytes, INT32_MAX));
  // Other groups that processes of this machine have joined at the same port are not for us. QEMU does without.
  setsockopt(fd, IPPROTO_IP, IP_MULTICAST_ALL, &no, sizeof no);
  return inet_pton(AF_INET, group.address.c_str(), &membership.imr_multiaddr) == 1 &&
         setsockopt(fd, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes) == 0 &&
         (wanted <= 0 || setsockopt(fd, SOL_SOCKET, SO_RCVBUF, &wanted, sizeof wanted) == 0) &&
         bind(fd, reinterpret_cast<const sockaddr*>(&name), sizeof name) == 0 &&
         setsockopt(fd, IPPROTO_IP, IP_ADD_MEMBERSHIP, &membership, sizeof membership) == 0;
}

std::string WhyNotJoined(const UdpGroup& group, int error_number) {
  if (error_number != ENODEV && error_number != ENETUNREACH) return "cannot listen there: " + ReasonOf(error_number);
  return NoRouteToGroup(group.address, error_number) + "; as root: " + kMulticastOverLoopback[0] + " && " +
         kMulticastOverLoopback[1] +
         "; or 'plslam relay' and --url tcpq://127.0.0.1:7700; 'plslam doctor' gives details";
}

}  // namespace

UdpGroup ParseUdpGroup(const std::string& url) {
  UdpGroup group;
  const auto fail = [&] {
    throw std::runtime_error("bus.url: " + url +
                             " is not a URL of the form udpm://ADDRESS:PORT?ttl=N, with a PORT of 1 to 65535");
  };
  if (!url.starts_with(kScheme)) fail();
  const std::string_view rest = std::string_view(url).substr(kScheme.size());
  const std::string_view network = rest.substr(0, rest.find('?'));
  const size_t colon = network.find(':');
  if (const std::string_view address = network.substr(0, colon); !address.empty()) group.address = address;
  if (colon != std::string_view::npos && !ParseNumber(network.substr(colon + 1), &group.port)) fail();
  const auto read = [&](std::string_view name, auto* value) {
    const size_t at = rest.find(name);
    if (at == std::string_view::npos) return;
    const std::string_view text = rest.substr(at + name.size());
    if (!ParseNumber(text.substr(0, text.find('&')), value)) fail();
  };
  read("recv_buf_size=", &group.buffer_bytes);
  read("ttl=", &group.ttl);
  return group;
}

bool ParsePacket(ByteView packet, std::string_view* channel, ByteView* bytes) {
  if (packet.size() <= kLcmHeadBytes || static_cast<uint32_t>(ReadInt32(packet.data())) != kLcmMagic) return false;
  const ByteView rest = packet.subspan(kLcmHeadBytes);
  const void* end = std::memchr(rest.data(), 0, std::min(rest.size(), kMaxChannelBytes + 1));
  if (end == nullptr) return false;
  const auto length = static_cast<size_t>(static_cast<const uint8_t*>(end) - rest.data());
  *channel = {reinterpret_cast<const char*>(rest.data()), length};
  *bytes = rest.subspan(length + 1);
  return true;
}

UdpReceiver::UdpReceiver(const std::string& url)
    : fd_(socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0)), buffer_(kMaxDatagram) {
  try {
    const UdpGroup group = ParseUdpGroup(url);
    const std::string why_no_group = WhyNoGroup(group.address);
    if (!why_no_group.empty()) throw std::runtime_error("bus.url: " + url + ": " + why_no_group);
    if (fd_ >= 0 && Join(fd_, group)) return;
    throw std::runtime_error("bus.url: " + url + ": " + WhyNotJoined(group, errno));
  } catch (...) {
    if (fd_ >= 0) close(fd_);
    throw;
  }
}

UdpReceiver::~UdpReceiver() { close(fd_); }

std::optional<UdpReceiver::Datagram> UdpReceiver::ReceiveDatagram() {
  sockaddr_in from{};
  socklen_t length = sizeof from;
  const ssize_t n =
      recvfrom(fd_, buffer_.data(), buffer_.size(), MSG_DONTWAIT, reinterpret_cast<sockaddr*>(&from), &length);
  if (n < 0) return std::nullopt;
  return Datagram{uint64_t{from.sin_addr.s_addr} << 16 | from.sin_port,
                  ByteView(buffer_).first(static_cast<size_t>(n))};
}

UdpReceiver::Outcome UdpReceiver::Receive(const Receiver& receiver, const Wanted& wanted) {
  const std::optional<Datagram> datagram = ReceiveDatagram();
  if (!datagram) return Outcome::kNothing;
  std::string_view channel;
  ByteView bytes;
  if (ParsePacket(datagram->bytes, &channel, &bytes)) {
    receiver(channel, bytes);
    return Outcome::kMessage;
  }
  const std::optional<MessagePart> part = ParsePart(datagram->bytes);
  if (!part) return Outcome::kJunk;
  const std::optional<uint32_t> digest = DigestOf(part->number);
  if (!digest || !wanted(*digest)) return Outcome::kPart;
  const int64_t now = std::chrono::nanoseconds(std::chrono::steady_clock::now().time_since_epoch()).count();
  const auto message = parts_.Add(datagram->sender, *part, now);
  if (!message) return Outcome::kPart;
  receiver(message->channel, message->bytes);
  return Outcome::kMessage;
}

PartsSender::PartsSender(const std::string& url) : fd_(socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {
  const UdpGroup group = ParseUdpGroup(url);
  const auto ttl = static_cast<unsigned char>(std::clamp(group.ttl, 0, 255));
  group_.sin_family = AF_INET;
  group_.sin_port = htons(group.port);
  const bool is_address = inet_pton(AF_INET, group.address.c_str(), &group_.sin_addr) == 1;
  if (is_address && fd_ >= 0 && setsockopt(fd_, IPPROTO_IP, IP_MULTICAST_TTL, &ttl, sizeof ttl) == 0) return;
  const int reason = errno;
  if (fd_ >= 0) close(fd_);
  throw std::runtime_error("bus.url: " + url + ": cannot send there: " + ReasonOf(reason));
}

PartsSender::~PartsSender() { close(fd_); }

bool PartsSender::Send(std::string_view channel, ByteView message, int64_t seq) {
  bool sent = true;
  ForEachPart(channel, message, PartsNumber(channel, seq, attempt_++), [&](ByteView packet) {
    const ssize_t n =
        sendto(fd_, packet.data(), packet.size(), 0, reinterpret_cast<const sockaddr*>(&group_), sizeof group_);
    sent = sent && n == static_cast<ssize_t>(packet.size());
  });
  return sent;
}

}  // namespace plslam::bus
