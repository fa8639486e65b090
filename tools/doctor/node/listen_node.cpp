// SPDX-License-Identifier: BSD-3-Clause
#include "tools/doctor/node/listen_node.h"

#include <algorithm>
#include <string_view>

#include "core/bus/channels.h"
#include "core/bus/transport/authenticator.h"
#include "core/bus/transport/transport.h"
#include "plslam/status_t.hpp"

namespace plslam::doctor {
namespace {

/// Returns the row of a channel with any prefix; nullptr if it is no channel of plslam. The longest name is used:
/// STEREO_FRAME is no FRAME with a prefix.
const bus::Channel* ChannelOf(std::string_view wire_name) {
  const bus::Channel* best = nullptr;
  for (const bus::Channel& channel : bus::Channels()) {
    if (wire_name.ends_with(channel.name) && (best == nullptr || channel.name.size() > best->name.size())) {
      best = &channel;
    }
  }
  return best;
}

class Listener {
 public:
  explicit Listener(const std::string& key_file) : authenticator_(key_file) {}

  void Take(std::string_view wire_name, bus::ByteView bytes) {
    const bus::Channel* channel = ChannelOf(wire_name);
    if (channel == nullptr) {
      ++heard_.other_channels;
      return;
    }
    const MessageLayout* layout = FindMessageLayout(channel->type);
    const auto length = bus::MessageLength(*layout, bytes);
    if (!length) {
      ++heard_.foreign_types[std::string(wire_name)];
    } else if (*length >= bus::kWireHeaderBytes && channel->name == bus::kStatus.name) {
      TakeStatus(wire_name, bytes, *length);
    }
  }

  Heard Result() && { return std::move(heard_); }

 private:
  Signature SignatureOf(std::string_view wire_name, bus::ByteView bytes, size_t length) const {
    const bool is_signed = bytes.size() == length + bus::Authenticator::kMacBytes;
    if (!is_signed) return Signature::kNone;
    if (!authenticator_.has_key()) return Signature::kUnchecked;
    return authenticator_.Accept(wire_name, bytes, length) ? Signature::kGood : Signature::kWrong;
  }

  void TakeStatus(std::string_view wire_name, bus::ByteView bytes, size_t length) {
    status_t status;
    if (status.decode(bytes.data(), 0, static_cast<int>(length)) < 0) return;
    HeardProcess p;
    p.prefix = wire_name.substr(0, wire_name.size() - bus::kStatus.name.size());
    p.process = status.process;
    p.host = status.host;
    p.pid = status.pid;
    p.version = status.version;
    p.state = status.state;
    p.reason = status.reason;
    p.source = SourceId(status.header.source);
    p.schema = status.header.schema;
    p.signature = SignatureOf(wire_name, bytes, length);
    for (const counter_t& counter : status.counters) p.counters[counter.name] = counter.value;
    if (const auto clock = p.counters.find("clock.utc_s"); clock != p.counters.end()) {
      const auto now = std::chrono::system_clock::now().time_since_epoch();
      p.clock_ahead_s = clock->second - std::chrono::duration<double>(now).count();
    }
    const auto same = std::find_if(heard_.processes.begin(), heard_.processes.end(), [&](const HeardProcess& other) {
      return other.source == p.source && other.prefix == p.prefix;
    });
    if (same == heard_.processes.end()) {
      heard_.processes.push_back(std::move(p));
    } else {
      *same = std::move(p);
    }
  }

  bus::Authenticator authenticator_;
  Heard heard_;
};

}  // namespace

Heard ListenToAll(const std::string& url, const std::string& key_file, std::chrono::milliseconds duration) {
  Listener listener(key_file);
  bus::Transport transport(url);
  transport.SetReceiver([&](std::string_view name, bus::ByteView bytes) { listener.Take(name, bytes); });
  transport.ListenToAll();
  const auto end = std::chrono::steady_clock::now() + duration;
  for (auto now = end - duration; now < end; now = std::chrono::steady_clock::now()) {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(end - now);
    if (!transport.Receive(static_cast<int>(left.count()))) break;
  }
  return std::move(listener).Result();
}

}  // namespace plslam::doctor
