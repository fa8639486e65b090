// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <chrono>
#include <stdexcept>
#include <utility>

#include "core/bus/bus_impl.h"
#include "plslam/header_t.hpp"

namespace plslam::bus {

Outbox& Bus::Impl::OutboxOf(const Channel& channel) {
  const std::lock_guard lock(mutex);
  std::unique_ptr<Outbox>& outbox = outboxes[std::string(channel.name)];
  if (outbox != nullptr) return *outbox;
  outbox = std::make_unique<Outbox>();
  outbox->channel = channel;
  outbox->wire_name = WireName(channel);
  if (channel.scope == Scope::kToMap) outbox->map_name = NameForMap(channel);
  if (channel.delivery == Delivery::kEvery || IsPaced(channel)) {
    outbox->writer = std::make_unique<OrderedWriter>(channel.retention, options.history_bytes, outbox->wire_name,
                                                     HistoryPath(channel), !temporary_folder);
    outbox->writer->KeepReadersFor(2 * static_cast<int64_t>(options.give_up_s * 1e9));
    for (const auto& [reader, hello] : hellos[std::string(channel.name)]) {
      outbox->writer->OnHello(reader, hello.window, hello.heard);
    }
  }
  return *outbox;
}

int Bus::Impl::ReaderCount(const Channel& channel) const {
  const std::lock_guard lock(mutex);
  const auto found = hellos.find(channel.name);
  if (found == hellos.end()) return 0;
  const int64_t now = Now();
  return static_cast<int>(std::count_if(found->second.begin(), found->second.end(), [&](const auto& entry) {
    return now - entry.second.heard <= OrderedWriter::Times().reader_alive_ns;
  }));
}

std::string Bus::Impl::HistoryPath(const Channel& channel) {
  return history_folder + "/" + std::string(channel.name) + "-" + std::to_string(source) + ".lcmlog";
}

/// Encoded message with its MAC.
Bytes Bus::Impl::Sealed(const std::string& wire_name, int64_t seq, header_t& header, const std::function<int()>& size,
                        const Encode& encode) const {
  header.schema = kSchemaVersion;
  header.source = source;
  header.seq = seq;
  const int bytes = size();
  if (bytes < 0 || static_cast<size_t>(bytes) + authenticator.overhead() > kMaxMessageBytes) {
    throw std::length_error(wire_name + ": a message of " + std::to_string(bytes) + " bytes exceeds " +
                            std::to_string(kMaxMessageBytes));
  }
  auto message = std::make_shared<std::vector<uint8_t>>();
  message->reserve(static_cast<size_t>(bytes) + authenticator.overhead());
  message->resize(static_cast<size_t>(bytes));
  if (encode(message->data(), bytes) != bytes) throw std::logic_error(wire_name + ": message cannot be encoded");
  authenticator.Append(wire_name, *message);
  return message;
}

void Bus::Impl::WaitForWindow(Outbox& outbox, size_t bytes) {
  // A reader that dies falls silent without telling, so look again now and then.
  static constexpr std::chrono::milliseconds kSlice{20};
  std::unique_lock lock(mutex);
  const bool paced = outbox.channel.delivery == Delivery::kLatest;
  int64_t words = outbox.writer->acknowledged();
  int64_t since = Now();
  while (!outbox.writer->WindowOpen(bytes, Now())) {
    if (IsInLockstep(outbox.channel) && std::exchange(words, outbox.writer->acknowledged()) != words) since = Now();
    if (Now() - since >= PatienceWithReaders(outbox.channel)) {
      outbox.writer->LeaveBehind(bytes, Now());
      return;
    }
    acknowledged.wait_for(lock, paced ? std::chrono::milliseconds(1) : kSlice);
  }
}

int64_t Bus::Impl::PatienceWithReaders(const Channel& channel) const {
  // A live frame that waits longer is late anyway.
  static constexpr int64_t kPacedWait_ms = 5;
  if (channel.delivery == Delivery::kLatest) return std::min(kPacedWait_ms, options.max_wait_ms) * kMs;
  // Who ends does not wait for readers that may be ending, too.
  if (IsInLockstep(channel) && !stopped) return static_cast<int64_t>(options.give_up_s * 1e9);
  return options.max_wait_ms * kMs;
}

void Bus::PublishEncoded(const Channel& channel, const char* type, header_t& header,
                         const std::function<int()>& encoded_size, const Encode& encode) {
  if (channel.type != type) {
    throw std::logic_error(std::string(channel.name) + " carries " + std::string(channel.type) + ", not " + type);
  }
  Outbox& outbox = impl_->OutboxOf(channel);
  const std::lock_guard publishing(outbox.publish_mutex);
  const Bytes message = impl_->Sealed(outbox.wire_name, outbox.seq, header, encoded_size, encode);
  const Bytes for_map =
      outbox.map_name.empty() ? nullptr : impl_->Sealed(outbox.map_name, outbox.seq, header, encoded_size, encode);
  bool wake = false;
  if (outbox.writer != nullptr) {
    impl_->WaitForWindow(outbox, message->size());
    const std::lock_guard lock(impl_->mutex);
    outbox.writer->Sent(message, Impl::Now());
    wake = channel.delivery == Delivery::kEvery && outbox.writer->announce_time() < impl_->wake_time_;
  }
  ++outbox.seq;
  impl_->transport.Send(outbox.wire_name, *message);
  if (for_map != nullptr) impl_->transport.Send(outbox.map_name, *for_map);
  {
    const std::lock_guard lock(impl_->mutex);
    outbox.sent = outbox.seq;
    ++impl_->counts.sent;
  }
  if (wake) impl_->transport.Wake();
}

bool Bus::Impl::Flush(std::chrono::milliseconds limit, bool to_silent) {
  static constexpr std::chrono::milliseconds kSlice{20};
  std::unique_lock lock(mutex);
  const int64_t deadline = Now() + std::chrono::nanoseconds(limit).count();
  const auto all_delivered = [&] {
    for (const auto& [name, outbox] : outboxes) {
      if (outbox->channel.delivery != Delivery::kEvery) continue;
      const OrderedWriter& writer = *outbox->writer;
      if (!(to_silent ? writer.AllDeliveredToSilent(Now()) : writer.AllDelivered(Now()))) return false;
    }
    return true;
  };
  while (!all_delivered()) {
    if (Now() >= deadline) return false;
    acknowledged.wait_for(lock, kSlice);
  }
  return true;
}

}  // namespace plslam::bus
