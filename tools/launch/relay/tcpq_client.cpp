// SPDX-License-Identifier: BSD-3-Clause
#include "tools/launch/relay/tcpq_client.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cerrno>

#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>
#include <unistd.h>

#include "tools/launch/relay/tcpq_relay.h"

namespace plslam::bus {
namespace {

// LCM's protocol, all words big-endian. Client: magic, version; server: magic, version. Then from the client
// {type, length, channel, [length, data]} and to it the same with type "publish".
constexpr uint32_t kServerMagic = 0x287617fa;
constexpr uint32_t kClientMagic = 0x287617fb;
constexpr uint32_t kProtocolVersion = 0x0100;
constexpr uint32_t kMaxNameBytes = 1024;
constexpr size_t kMaxPatterns = 256;
constexpr size_t kMaxAnswers = 4096;

void AppendWord(std::vector<uint8_t>& bytes, uint32_t word) {
  for (int shift = 24; shift >= 0; shift -= 8) bytes.push_back(static_cast<uint8_t>(word >> shift));
}

/// Back references and counts make matching or compiling explode.
bool Harmless(const std::string& pattern) {
  for (size_t i = 0; i < pattern.size(); ++i) {
    if (pattern[i] == '{') return false;
    if (pattern[i] == '\\' && i + 1 < pattern.size() &&
        std::isdigit(static_cast<unsigned char>(pattern[i + 1])) != 0) {
      return false;
    }
  }
  return pattern.size() <= 256;
}

}  // namespace

ChannelPattern::ChannelPattern(const std::string& pattern) : text_(pattern) {
  const std::string whole = "^(" + pattern + ")$";
  valid_ = Harmless(pattern) && regcomp(&regex_, whole.c_str(), REG_EXTENDED | REG_NOSUB) == 0;
}

ChannelPattern::~ChannelPattern() {
  if (valid_) regfree(&regex_);
}

bool ChannelPattern::Matches(const std::string& channel) const {
  return valid_ && regexec(&regex_, channel.c_str(), 0, nullptr, 0) == 0;
}

TcpqClient::TcpqClient(int fd) : fd_(fd), high_(TcpqRelay::kQueueBytes) {
  const int on = 1;
  setsockopt(fd_, IPPROTO_TCP, TCP_NODELAY, &on, sizeof(on));
}

TcpqClient::~TcpqClient() { close(fd_); }

uint32_t TcpqClient::Word(size_t at) const {
  return uint32_t{input_[at]} << 24 | uint32_t{input_[at + 1]} << 16 | uint32_t{input_[at + 2]} << 8 | input_[at + 3];
}

bool TcpqClient::Read(std::vector<Publication>& published) {
  static thread_local std::array<uint8_t, 262'144> buffer;
  const ssize_t n = recv(fd_, buffer.data(), buffer.size(), MSG_DONTWAIT);
  if (n == 0 || (n < 0 && errno != EAGAIN && errno != EINTR)) return false;
  // LCM writes a message in five small pieces and its kernel waits for our acknowledgement in between; do not let
  // ours wait for something to ride on.
  const int on = 1;
  setsockopt(fd_, IPPROTO_TCP, TCP_QUICKACK, &on, sizeof(on));
  if (n > 0) input_.insert(input_.end(), buffer.begin(), buffer.begin() + n);
  malformed_ = !Parse(published);
  return !malformed_;
}

bool TcpqClient::Parse(std::vector<Publication>& published) {
  size_t at = 0;
  if (!greeted_) {
    if (input_.size() < 8) return true;
    if (Word(0) != kClientMagic) return false;
    std::vector<uint8_t> greeting;
    AppendWord(greeting, kServerMagic);
    AppendWord(greeting, kProtocolVersion);
    Queue(std::make_shared<const std::vector<uint8_t>>(std::move(greeting)));
    greeted_ = true;
    at = 8;
  }
  bool complete = true;
  while (complete) {
    if (!ParseOne(at, published, complete)) return false;
  }
  input_.erase(input_.begin(), input_.begin() + static_cast<std::ptrdiff_t>(at));
  return true;
}

/// Parses one message at `at`, which is moved to its end. `complete` false: more bytes are needed. Returns false for
/// invalid bytes.
bool TcpqClient::ParseOne(size_t& at, std::vector<Publication>& published, bool& complete) {
  complete = false;
  const size_t left = input_.size() - at;
  if (left < 8) return true;
  const auto type = static_cast<Type>(Word(at));
  const uint32_t name_bytes = Word(at + 4);
  if (type < Type::kPublish || type > Type::kUnsubscribe || name_bytes > kMaxNameBytes) return false;
  if (left < 8 + size_t{name_bytes}) return true;
  const auto name_at = input_.begin() + static_cast<std::ptrdiff_t>(at + 8);
  const std::string name(name_at, name_at + name_bytes);
  if (name.find('\0') != std::string::npos) return false;
  size_t size = 8 + size_t{name_bytes};
  if (type == Type::kPublish) {
    if (left < size + 4) return true;
    const uint32_t data_bytes = Word(at + size);
    if (data_bytes > TcpqRelay::kMaxMessageBytes) return false;
    size += 4 + size_t{data_bytes};
    if (left < size) return true;
    const auto begin = input_.begin() + static_cast<std::ptrdiff_t>(at);
    published.push_back(
        {name, std::make_shared<const std::vector<uint8_t>>(begin, begin + static_cast<std::ptrdiff_t>(size))});
  } else if (!Subscription(type, name)) {
    return false;
  }
  at += size;
  complete = true;
  return true;
}

bool TcpqClient::Subscription(Type type, const std::string& pattern) {
  wanted_.clear();
  if (type == Type::kSubscribe) {
    if (patterns_.size() >= kMaxPatterns) return false;
    patterns_.push_back(std::make_unique<ChannelPattern>(pattern));
    return true;
  }
  const auto found =
      std::find_if(patterns_.begin(), patterns_.end(), [&](const auto& p) { return p->text() == pattern; });
  if (found != patterns_.end()) patterns_.erase(found);
  return true;
}

bool TcpqClient::Wants(const std::string& channel) {
  const auto known = wanted_.find(channel);
  if (known != wanted_.end()) return known->second;
  if (wanted_.size() >= kMaxAnswers) wanted_.clear();
  const bool wants =
      std::any_of(patterns_.begin(), patterns_.end(), [&](const auto& p) { return p->Matches(channel); });
  wanted_[channel] = wants;
  return wants;
}

int64_t TcpqClient::Queue(const Packet& packet) {
  output_.push_back(packet);
  queued_bytes_ += static_cast<int64_t>(packet->size());
  int64_t dropped = 0;
  // The first may be half written.
  while (stalled_ && queued_bytes_ > high_ && output_.size() > 1) {
    queued_bytes_ -= static_cast<int64_t>(output_[1]->size());
    output_.erase(output_.begin() + 1);
    ++dropped;
  }
  return dropped;
}

bool TcpqClient::Write() {
  while (!output_.empty()) {
    const Packet& packet = output_.front();
    const ssize_t n = send(fd_, packet->data() + written_, packet->size() - written_, MSG_DONTWAIT | MSG_NOSIGNAL);
    if (n < 0) return errno == EAGAIN || errno == EINTR;
    written_ += static_cast<size_t>(n);
    if (written_ < packet->size()) continue;
    queued_bytes_ -= static_cast<int64_t>(packet->size());
    written_ = 0;
    output_.pop_front();
  }
  if (queued_bytes_ < high_ / 2) {
    stalled_ = false;
    full_since_ = Clock::time_point::max();
  }
  return true;
}

void TcpqClient::CheckPatience(Clock::time_point now) {
  if (!Congests()) return;
  full_since_ = std::min(full_since_, now);
  if (now - full_since_ > std::chrono::milliseconds(TcpqRelay::kPatience_ms)) stalled_ = true;
}

}  // namespace plslam::bus
