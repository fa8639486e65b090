// SPDX-License-Identifier: BSD-3-Clause
#include "core/bus/outboxes.h"

#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <stdexcept>
#include <system_error>
#include <utility>

#include "plslam/header_t.hpp"

namespace plslam::bus {
namespace {

void CheckFolder(const std::string& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (access(folder.c_str(), W_OK | X_OK) != 0) {
    throw std::runtime_error("bus.history_dir: " + folder + " is not a writable folder");
  }
}

}  // namespace

int64_t SteadyNow_ns() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

Outboxes::Outboxes(const BusOptions& options, const ChannelNames& names, const Authenticator& authenticator,
                   Transport& transport, SourceId source)
    : options_(options),
      names_(names),
      authenticator_(authenticator),
      transport_(transport),
      source_(source),
      history_folder_(options.history_dir.empty() ? TemporaryFolder(source) : options.history_dir) {
  if (!options.history_dir.empty()) CheckFolder(history_folder_);
}

Outboxes::Outbox& Outboxes::OutboxOf(const Channel& channel) {
  const std::lock_guard lock(mutex_);
  std::unique_ptr<Outbox>& outbox = outboxes_[std::string(channel.name)];
  if (outbox != nullptr) return *outbox;
  outbox = std::make_unique<Outbox>();
  outbox->channel = channel;
  outbox->wire_name = names_.WireName(channel);
  if (channel.scope == Scope::kToMap) outbox->map_name = names_.NameForMap(channel);
  if (channel.delivery == Delivery::kEvery || channel.pace == Pace::kPaced) {
    const std::string path =
        history_folder_ + "/" + std::string(channel.name) + "-" + std::to_string(source_.value) + ".lcmlog";
    outbox->log = std::make_unique<HistoryLog>(outbox->wire_name, path, !options_.history_dir.empty());
    outbox->writer = std::make_unique<OrderedWriter>(channel.retention, options_.history_bytes);
    outbox->writer->KeepReadersFor(2 * static_cast<int64_t>(options_.give_up_s * 1e9));
    for (const auto& [reader, hello] : hellos_[std::string(channel.name)]) {
      outbox->writer->OnHello(reader, hello.window, hello.heard);
    }
  }
  return *outbox;
}

int Outboxes::ReaderCount(const Channel& channel) const {
  const std::lock_guard lock(mutex_);
  const auto found = hellos_.find(channel.name);
  if (found == hellos_.end()) return 0;
  const int64_t now = SteadyNow_ns();
  return static_cast<int>(std::count_if(found->second.begin(), found->second.end(), [&](const auto& entry) {
    return now - entry.second.heard <= OrderedWriter::Times().reader_alive_ns;
  }));
}

bool Outboxes::sends_packets() const {
  const std::lock_guard lock(mutex_);
  return size_.IsSmall(SteadyNow_ns());
}

std::string Outboxes::LossText() const {
  const std::lock_guard lock(mutex_);
  if (!size_.IsSmall(SteadyNow_ns())) return "";
  return "packets are lost: " + std::to_string(size_.percent()) +
         " % of the large messages had to be sent again, so they are sent as single packets";
}

int64_t Outboxes::acknowledged() const {
  const std::lock_guard lock(mutex_);
  int64_t sum = 0;
  for (const auto& [name, outbox] : outboxes_) {
    if (outbox->writer != nullptr) sum += outbox->writer->acknowledged();
  }
  return sum;
}

/// Encoded message with its MAC.
Bytes Outboxes::Sealed(const std::string& wire_name, int64_t seq, header_t& header,
                       const std::function<int()>& encoded_size, const Encode& encode) const {
  header.schema = kSchemaVersion;
  header.source = source_.value;
  header.seq = seq;
  const int bytes = encoded_size();
  if (bytes < 0 || static_cast<size_t>(bytes) + authenticator_.overhead() > kMaxMessageBytes) {
    throw std::length_error(wire_name + ": a message of " + std::to_string(bytes) + " bytes exceeds " +
                            std::to_string(kMaxMessageBytes));
  }
  auto message = std::make_shared<std::vector<uint8_t>>();
  message->reserve(static_cast<size_t>(bytes) + authenticator_.overhead());
  message->resize(static_cast<size_t>(bytes));
  if (encode(message->data(), bytes) != bytes) throw std::logic_error(wire_name + ": the message cannot be encoded");
  authenticator_.Append(wire_name, *message);
  return message;
}

int64_t Outboxes::PatienceWithReaders(const Channel& channel) const {
  // A live frame that waits longer is outdated.
  static constexpr int64_t kPacedWait_ms = 5;
  if (channel.delivery == Delivery::kLatest) return std::min(kPacedWait_ms, options_.max_wait_ms) * kMs;
  // A stopping process does not wait for readers, which may be stopping, too.
  if (channel.pace == Pace::kLockstep && !stopped_) return static_cast<int64_t>(options_.give_up_s * 1e9);
  return options_.max_wait_ms * kMs;
}

void Outboxes::WaitForWindow(Outbox& outbox, size_t bytes) {
  // A reader that exits falls silent without notice, so check again now and then.
  static constexpr std::chrono::milliseconds kSlice{20};
  std::unique_lock lock(mutex_);
  const bool paced = outbox.channel.delivery == Delivery::kLatest;
  int64_t words = outbox.writer->acknowledged();
  int64_t since = SteadyNow_ns();
  while (!outbox.writer->WindowOpen(bytes, SteadyNow_ns())) {
    const bool got_on = std::exchange(words, outbox.writer->acknowledged()) != words;
    if (got_on && outbox.channel.pace == Pace::kLockstep) since = SteadyNow_ns();
    if (SteadyNow_ns() - since >= PatienceWithReaders(outbox.channel)) {
      outbox.writer->SuspendSlowReaders(bytes, SteadyNow_ns());
      return;
    }
    acknowledged_.wait_for(lock, paced ? std::chrono::milliseconds(1) : kSlice);
  }
}

/// With `publish_mutex`, so that one thread moves messages at a time.
void Outboxes::MoveToLog(Outbox& outbox) {
  std::unique_lock lock(mutex_);
  while (const Bytes oldest = outbox.writer->ToMove()) {
    lock.unlock();
    const std::optional<int64_t> offset = outbox.log->Write(oldest);
    lock.lock();
    const int64_t needed_from = outbox.writer->Moved(offset);
    lock.unlock();
    outbox.log->Release(needed_from);
    lock.lock();
  }
}

std::optional<int64_t> Outboxes::Publish(const Channel& channel, header_t& header,
                                         const std::function<int()>& encoded_size, const Encode& encode) {
  Outbox& outbox = OutboxOf(channel);
  const std::lock_guard publishing(outbox.publish_mutex);
  const Bytes message = Sealed(outbox.wire_name, outbox.seq, header, encoded_size, encode);
  const Bytes for_map =
      outbox.map_name.empty() ? nullptr : Sealed(outbox.map_name, outbox.seq, header, encoded_size, encode);
  std::optional<int64_t> announce_time;
  if (outbox.writer != nullptr) {
    WaitForWindow(outbox, message->size());
    {
      const std::lock_guard lock(mutex_);
      size_.OnSent(static_cast<int64_t>(message->size()));
      outbox.writer->Sent(message, SteadyNow_ns());
      if (channel.delivery == Delivery::kEvery) announce_time = outbox.writer->announce_time();
    }
    MoveToLog(outbox);
  }
  ++outbox.seq;
  const auto send = [&](const std::string& wire_name, const Bytes& bytes) {
    outbox.writer != nullptr ? SendRepairable(wire_name, *bytes) : void(transport_.Send(wire_name, *bytes));
  };
  send(outbox.wire_name, message);
  if (for_map != nullptr) send(outbox.map_name, for_map);
  ++sent_;
  const std::lock_guard lock(mutex_);
  outbox.sent = outbox.seq;
  return announce_time;
}

void Outboxes::SendRepairable(const std::string& wire_name, ByteView message) {
  if (sends_packets()) {
    transport_.SendInPackets(wire_name, message, ReadHeader(message).seq);
  } else {
    transport_.Send(wire_name, message);
  }
}

bool Outboxes::Flush(std::chrono::milliseconds limit, bool to_silent) {
  static constexpr std::chrono::milliseconds kSlice{20};
  std::unique_lock lock(mutex_);
  const int64_t deadline = SteadyNow_ns() + std::chrono::nanoseconds(limit).count();
  const auto all_delivered = [&] {
    for (const auto& [name, outbox] : outboxes_) {
      if (outbox->channel.delivery != Delivery::kEvery) continue;
      const OrderedWriter& writer = *outbox->writer;
      const int64_t now = SteadyNow_ns();
      if (!(to_silent ? writer.AllDeliveredToSilent(now) : writer.AllDelivered(now))) return false;
    }
    return true;
  };
  while (!all_delivered()) {
    if (SteadyNow_ns() >= deadline) return false;
    acknowledged_.wait_for(lock, kSlice);
  }
  return true;
}

Outboxes::Announcement Outboxes::AnnouncementOf(const Outbox& outbox, int64_t now) const {
  return {outbox.channel, std::min(outbox.writer->history().first_seq(), outbox.sent), outbox.sent,
          std::min(outbox.writer->join_seq(now), outbox.sent)};
}

std::optional<Outboxes::Announcement> Outboxes::OnHello(const Channel& channel, SourceId reader, int64_t window,
                                                        int64_t now) {
  const std::lock_guard lock(mutex_);
  std::map<SourceId, Hello>& known = hellos_[std::string(channel.name)];
  std::erase_if(known, [&](const auto& e) { return now - e.second.heard > kRemembered_ns; });
  if (known.size() < kMaxReaders || known.contains(reader)) known[reader] = {now, window};
  const auto found = outboxes_.find(channel.name);
  if (found == outboxes_.end() || found->second->writer == nullptr) return std::nullopt;
  Outbox& outbox = *found->second;
  outbox.writer->OnHello(reader, window, now);
  const bool ordered = outbox.channel.delivery == Delivery::kEvery;
  if (!ordered || !outbox.writer->AnnounceDue(now)) return std::nullopt;
  return AnnouncementOf(outbox, now);
}

Outboxes::Answer Outboxes::OnRequest(const std::string& channel, SourceId reader, int64_t delivered, int64_t window,
                                     const std::vector<SeqRange>& ranges, int64_t now) {
  Answer answer;
  HistoryLog* log = nullptr;
  std::vector<History::Kept> kept;
  {
    const std::lock_guard lock(mutex_);
    const auto found = outboxes_.find(channel);
    if (found == outboxes_.end() || found->second->writer == nullptr) return answer;
    Outbox& outbox = *found->second;
    OrderedWriter::Answer words = outbox.writer->OnRequest(reader, delivered, window, ranges, now);
    kept = std::move(words.resend);
    if (words.n_lost > 0 && transport_.leaves_host()) size_.OnLost(words.n_lost, now);
    log = outbox.log.get();
    answer.wire_name = outbox.wire_name;
    if (words.announce && outbox.channel.delivery == Delivery::kEvery) {
      answer.announcement = AnnouncementOf(outbox, now);
    }
  }
  acknowledged_.notify_all();
  for (History::Kept& one : kept) {
    Bytes message = one.message != nullptr ? std::move(one.message) : log->Read(one.offset);
    if (message != nullptr) answer.resend.push_back(std::move(message));
  }
  resent_ += static_cast<int64_t>(answer.resend.size());
  return answer;
}

std::vector<Outboxes::Announcement> Outboxes::Poll(int64_t now, int64_t& next) {
  const std::lock_guard lock(mutex_);
  std::vector<Announcement> due;
  for (auto& [name, outbox] : outboxes_) {
    if (outbox->channel.delivery != Delivery::kEvery) continue;
    if (outbox->writer->AnnounceDue(now)) due.push_back(AnnouncementOf(*outbox, now));
    next = std::min(next, std::max(outbox->writer->announce_time(), now + kMs));
  }
  return due;
}

}  // namespace plslam::bus
