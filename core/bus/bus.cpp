// SPDX-License-Identifier: BSD-3-Clause
#include "core/bus/bus.h"

#include <algorithm>
#include <filesystem>
#include <stdexcept>

#include <sodium.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include "core/bus/bus_impl.h"
#include "core/bus/delivery/history.h"

namespace plslam::bus {
namespace {

/// Positive and never zero, which means "any" on the wire.
int64_t RandomSource() {
  int64_t source = 0;
  while (source == 0) {
    randombytes_buf(&source, sizeof(source));
    source &= INT64_MAX;
  }
  return source;
}

void CheckPrefix(const std::string& key, const std::string& prefix) {
  const bool plain = std::all_of(prefix.begin(), prefix.end(), [](unsigned char c) {
    return std::isalnum(c) != 0 || c == '_' || c == '-' || c == '/' || c == '.';
  });
  if (!plain || prefix.size() > 32) {
    throw std::runtime_error("bus." + key + ": '" + prefix + "' must be at most 32 letters, digits or _ - / .");
  }
}

void CheckFolder(const std::string& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (access(folder.c_str(), W_OK | X_OK) != 0) {
    throw std::runtime_error("bus.history_dir: " + folder + " is no folder that can be written to");
  }
}

}  // namespace

Bus::Impl::Impl(const BusOptions& options_in, std::string process_in)
    : options(options_in),
      process(std::move(process_in)),
      authenticator(options.key_file),
      transport(options.url),
      request_layout_(FindMessageLayout(kRepairRequest.type)),
      announce_layout_(FindMessageLayout(kAnnounce.type)),
      drop_random_(static_cast<uint64_t>(options.drop_seed)) {
  CheckPrefix("prefix", options.prefix);
  CheckPrefix("map_prefix", options.map_prefix);
  source = RandomSource();
  spdlog::default_logger_raw();  // made here, before the thread that may use it
  temporary_folder = options.history_dir.empty();
  history_folder = temporary_folder ? TemporaryFolder(source) : options.history_dir;
  if (!temporary_folder) CheckFolder(history_folder);
  transport.SetReceiver([this](std::string_view channel, ByteView bytes) { OnDatagram(channel, bytes); });
  for (const Channel& control : {kRepairRequest, kAnnounce}) {
    transport.Listen(WireName(control));
    if (const std::string name = NameForMap(control); !name.empty()) transport.Listen(name);
  }
  transport.ListenToEnding(kStatus.name);
  receiver_ = std::thread([this] { ReceiveLoop(); });
}

std::string Bus::Impl::WireName(const Channel& channel) const {
  return std::string(PrefixOf(channel.scope)).append(channel.name);
}

std::string Bus::Impl::NameForMap(const Channel& channel) const {
  const std::string name = std::string(MapPrefix()).append(channel.name);
  return name == WireName(channel) ? std::string() : name;
}

bool Bus::Impl::IsNamed(std::string_view wire_name, const Channel& channel) const {
  if (!wire_name.ends_with(channel.name)) return false;
  const std::string_view prefix = wire_name.substr(0, wire_name.size() - channel.name.size());
  return prefix == options.prefix || prefix == MapPrefix();
}

Bus::Impl::~Impl() {
  // What was published last may still be asked for; afterwards nobody can answer.
  static constexpr std::chrono::milliseconds kFarewell{300};
  Flush(kFarewell);
  stopping_ = true;
  MayReceive();
  transport.Wake();
  receiver_.join();
  outboxes.clear();
}

Bus::Bus(const BusOptions& options, const std::string& process) : impl_(std::make_unique<Impl>(options, process)) {}
Bus::~Bus() = default;

int64_t Bus::source() const { return impl_->source; }
const BusOptions& Bus::options() const { return impl_->options; }

std::string Bus::WireName(const Channel& channel) const { return impl_->WireName(channel); }

int64_t Bus::page_bytes() const {
  return impl_->options.max_message_bytes - static_cast<int64_t>(impl_->authenticator.overhead());
}

int64_t Bus::largest_message_bytes() const {
  return static_cast<int64_t>(kMaxMessageBytes - impl_->authenticator.overhead());
}

void Bus::Post(std::function<void()> f) { impl_->loop.Post(std::move(f)); }
void Bus::Every(std::chrono::milliseconds period, std::function<void()> f) {
  impl_->loop.Every(period, std::move(f));
}
void Bus::Run() {
  impl_->MayReceive();
  impl_->loop.Run();
}
void Bus::Stop() {
  impl_->stopped = true;
  impl_->loop.Stop();
}
void Bus::StopWhenHandled() {
  {
    const std::lock_guard lock(impl_->mutex);
    impl_->takes_more = false;
  }
  impl_->loop.Post([this] { Stop(); });
}

void Bus::SubscribeDecoded(const Channel& channel, const char* type, bool best_effort, Deliver deliver) {
  using Kind = Subscription::Kind;
  const Kind kind = channel.delivery == Delivery::kLatest ? Kind::kNewest
                    : best_effort                         ? Kind::kAsItComes
                                                          : Kind::kOrdered;
  impl_->Subscribe(channel, type, std::make_shared<Subscription>(Subscription{kind, std::move(deliver), nullptr}));
}

void Bus::SubscribeBytes(const Channel& channel, Reading reading, std::function<bool()> ready,
                         std::function<void(std::span<const uint8_t>)> take) {
  using Kind = Subscription::Kind;
  const Kind kind = reading == Reading::kOrdered ? Kind::kOrderedBytes
                    : reading == Reading::kPaced ? Kind::kPacedBytes
                                                 : Kind::kBytes;
  Subscription subscription{kind,
                            [take = std::move(take)](ByteView bytes) {
                              take(bytes);
                              return true;
                            },
                            std::move(ready)};
  impl_->Subscribe(channel, std::string(channel.type).c_str(),
                   std::make_shared<Subscription>(std::move(subscription)));
}

void Bus::SubscribeRest(std::function<void(std::string_view, std::span<const uint8_t>)> take) {
  {
    const std::lock_guard lock(impl_->mutex);
    impl_->rest = std::move(take);
  }
  impl_->transport.ListenToAll();
}

void Bus::CountRejected() { ++impl_->nonsense; }
void Bus::CountSkipped(int64_t n) { impl_->passed_over += n; }

int Bus::ReaderCount(const Channel& channel) const { return impl_->ReaderCount(channel); }

bool Bus::Flush(std::chrono::milliseconds limit) { return impl_->Flush(limit); }
bool Bus::FlushToSilent(std::chrono::milliseconds limit) { return impl_->Flush(limit, true); }

int64_t Bus::acknowledged() const {
  const std::lock_guard lock(impl_->mutex);
  int64_t sum = 0;
  for (const auto& [name, outbox] : impl_->outboxes) {
    if (outbox->writer != nullptr) sum += outbox->writer->acknowledged();
  }
  return sum;
}

std::string Bus::Complaints() const {
  const std::lock_guard lock(impl_->mutex);
  return impl_->rejections.Line(Impl::Now());
}

BusCounters Bus::counters() const {
  const std::lock_guard lock(impl_->mutex);
  BusCounters counts = impl_->counts;
  counts.rejected += impl_->nonsense + impl_->transport.junk();
  counts.skipped += impl_->passed_over;
  counts.lost += impl_->given_lost;
  counts.repaired += impl_->given_repaired;
  for (const auto& [name, inbox] : impl_->inboxes) {
    for (const auto& [source, reader] : inbox.readers) {
      counts.lost += reader.lost();
      counts.repaired += reader.repaired();
    }
  }
  return counts;
}

}  // namespace plslam::bus
