// SPDX-License-Identifier: BSD-3-Clause
#include "core/bus/bus.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

#include <sodium.h>
#include <spdlog/spdlog.h>

#include "core/bus/bus_impl.h"
#include "core/errors/error_text.h"

namespace plslam::bus {
namespace {

/// Positive and never zero, which means "any" on the wire.
SourceId RandomSource() {
  int64_t source = 0;
  while (source == 0) {
    randombytes_buf(&source, sizeof(source));
    source &= INT64_MAX;
  }
  return SourceId(source);
}

}  // namespace

Bus::Impl::Impl(const BusOptions& options_in, std::string process_in)
    : options(options_in),
      process(std::move(process_in)),
      names(options),
      source(RandomSource()),
      authenticator(options.key_file),
      transport(options.url),
      outboxes(options, names, authenticator, transport, source),
      inboxes(options, transport.two_way(), loop, counts,
              [this](const Channel& channel, SourceId publisher, const OrderedReader::Request& request) {
                Request(channel, publisher, request);
              }),
      request_layout_(FindMessageLayout(kRepairRequest.type)),
      announce_layout_(FindMessageLayout(kAnnounce.type)),
      drop_random_(static_cast<uint64_t>(options.drop_seed)) {
  spdlog::default_logger_raw();  // made here, before the thread that may use it
  transport.SetReceiver([this](std::string_view channel, ByteView bytes) { OnDatagram(channel, bytes); });
  const auto names_of = [this](const Channel& control) {
    std::set<std::string, std::less<>> both{names.WireName(control)};
    if (std::string name = names.NameForMap(control); !name.empty()) both.insert(std::move(name));
    return both;
  };
  std::set<std::string, std::less<>> bulky;
  for (const Channel* channel :
       {&kStereoFrame, &kStereoFrameLive, &kTracks, &kTracksLive, &kKeyframe, &kMapUpdate, &kMask}) {
    bulky.merge(names_of(*channel));
  }
  transport.SetBulky(std::move(bulky));
  transport.Listen({names_of(kRepairRequest), request_layout_->fingerprint(), source.value});
  for (const std::string& name : names_of(kAnnounce)) transport.Listen(name);
  transport.ListenToEnding(kStatus.name);
  receiver_ = std::thread([this] { ReceiveLoop(); });
}

Bus::Impl::~Impl() {
  // Readers may still request the last messages; after the end of this process they cannot.
  static constexpr std::chrono::milliseconds kFarewell{300};
  outboxes.Flush(kFarewell, false);
  stopping_ = true;
  MayReceive();
  transport.Wake();
  receiver_.join();
}

void Bus::Impl::Subscribe(const Channel& channel, const char* type, std::shared_ptr<Subscription> subscription) {
  const MessageLayout* layout = FindMessageLayout(type);
  if (channel.type != type || layout == nullptr) {
    throw std::logic_error(std::string(channel.name) + " carries " + std::string(channel.type) + ", not " + type);
  }
  std::vector<std::string> wire_names = {names.WireName(channel)};
  const std::string for_map = names.NameForMap(channel);
  if (channel.scope == Scope::kFromMap && !for_map.empty()) wire_names.push_back(for_map);
  for (const std::string& wire_name : wire_names) {
    inboxes.Add(wire_name, channel, layout, subscription);
    transport.Listen(wire_name);
  }
  transport.Wake();
}

void Bus::Impl::SubscribeRest(Inboxes::Rest rest) {
  inboxes.AddRest(std::move(rest));
  transport.ListenToAll();
}

void Bus::Impl::Publish(const Channel& channel, const char* type, header_t& header,
                        const std::function<int()>& encoded_size, const Encode& encode) {
  if (channel.type != type) {
    throw std::logic_error(std::string(channel.name) + " carries " + std::string(channel.type) + ", not " + type);
  }
  const std::optional<int64_t> announce_time = outboxes.Publish(channel, header, encoded_size, encode);
  if (announce_time && *announce_time < wake_time_) transport.Wake();
}

BusCounters Bus::Impl::counters() const {
  BusCounters counters;
  counters.sent = outboxes.sent();
  counters.received = counts.received;
  counters.lost = counts.lost;
  counters.lost_of = counts.lost_of();
  counters.repaired = counts.repaired;
  counters.resent = outboxes.resent();
  counters.rejected = counts.rejected + transport.junk();
  counters.unproven = counts.unproven;
  counters.duplicates = counts.duplicates;
  counters.skipped = counts.skipped;
  return counters;
}

std::string Bus::Impl::Problems() const {
  const std::string loss = outboxes.LossText();
  return Joined(rejections_.Line(SteadyNow_ns()), loss);
}

bool Bus::Impl::hears_other_key() const { return rejections_.Has(Rejection::kOtherKey, SteadyNow_ns()); }

Bus::Bus(const BusOptions& options, const std::string& process) : impl_(std::make_unique<Impl>(options, process)) {}
Bus::~Bus() = default;

SourceId Bus::source() const { return impl_->source; }
const BusOptions& Bus::options() const { return impl_->options; }

std::string Bus::WireName(const Channel& channel) const { return impl_->names.WireName(channel); }

int64_t Bus::page_bytes() const {
  const int64_t bytes = impl_->outboxes.sends_packets()
                            ? std::min(impl_->options.max_message_bytes, MessageSize::kPacket_bytes)
                            : impl_->options.max_message_bytes;
  return bytes - static_cast<int64_t>(impl_->authenticator.overhead());
}

int64_t Bus::largest_message_bytes() const {
  return static_cast<int64_t>(kMaxMessageBytes - impl_->authenticator.overhead());
}

void Bus::Post(std::function<void()> f) { impl_->loop.Post(std::move(f)); }
void Bus::Every(std::chrono::milliseconds period, std::function<void()> f) {
  impl_->loop.Every(period, std::move(f));
}
void Bus::After(std::chrono::milliseconds delay, std::function<void()> f) { impl_->loop.After(delay, std::move(f)); }
void Bus::Run() {
  impl_->MayReceive();
  impl_->loop.Run();
}
void Bus::Stop() {
  impl_->outboxes.Stop();
  impl_->loop.Stop();
}
void Bus::StopWhenHandled() {
  // Closed by the receiving thread, so that everything it has delivered precedes the stop in the queue.
  impl_->inboxes.Close([this] { impl_->loop.Post([this] { Stop(); }); });
  impl_->transport.Wake();
}

void Bus::PublishEncoded(const Channel& channel, const char* type, header_t& header,
                         const std::function<int()>& encoded_size, const Encode& encode) {
  impl_->Publish(channel, type, header, encoded_size, encode);
}

void Bus::SubscribeDecoded(const Channel& channel, const char* type, bool best_effort, Deliver deliver) {
  using Kind = Subscription::Kind;
  const Kind kind = best_effort                             ? Kind::kAsItComes
                    : channel.delivery == Delivery::kLatest ? Kind::kNewest
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
  impl_->SubscribeRest(std::move(take));
}

void Bus::CountRejected() { ++impl_->counts.rejected; }
void Bus::CountSkipped(int64_t n) { impl_->counts.skipped += n; }

int Bus::ReaderCount(const Channel& channel) const { return impl_->outboxes.ReaderCount(channel); }
bool Bus::Flush(std::chrono::milliseconds limit) { return impl_->outboxes.Flush(limit, false); }
bool Bus::FlushToSilent(std::chrono::milliseconds limit) { return impl_->outboxes.Flush(limit, true); }
int64_t Bus::acknowledged() const { return impl_->outboxes.acknowledged(); }
BusCounters Bus::counters() const { return impl_->counters(); }
std::string Bus::Problems() const { return impl_->Problems(); }
bool Bus::hears_other_key() const { return impl_->hears_other_key(); }

}  // namespace plslam::bus
