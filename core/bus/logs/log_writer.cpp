// SPDX-License-Identifier: BSD-3-Clause
#include "core/bus/logs/log_writer.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <stdexcept>
#include <system_error>
#include <vector>

#include <lcm/eventlog.h>

#include "core/bus/transport/wall_clock.h"

namespace plslam::bus {
namespace {

/// Limit of the bytes that wait to be written; beyond it publishers block.
constexpr int64_t kMaxWaitingBytes = 64'000'000;

/// Channels about the bus and its processes, which the recorder itself uses too.
constexpr std::array kAboutBus = {&kStatus, &kAnnounce, &kRepairRequest};

}  // namespace

struct LogWriter::Impl {
  std::unique_ptr<lcm_eventlog_t, void (*)(lcm_eventlog_t*)> log;
};

LogWriter::LogWriter(const std::string& path) : path_(path) {
  auto* log = lcm_eventlog_create(path.c_str(), "w");
  if (log == nullptr) throw std::runtime_error(path + ": cannot be written: " + std::strerror(errno));
  impl_ = std::make_unique<Impl>(Impl{{log, &lcm_eventlog_destroy}});
}

LogWriter::~LogWriter() {
  impl_.reset();
  std::error_code no_file;
  const bool empty =
      std::filesystem::is_regular_file(path_, no_file) && std::filesystem::file_size(path_, no_file) == 0;
  if (failed_ && empty) std::filesystem::remove(path_, no_file);
}

void LogWriter::Fail() {
  failed_ = true;
  throw std::runtime_error(path_ + ": cannot be written: " + std::strerror(errno));
}

void LogWriter::Write(std::string_view channel, ByteView data, int64_t timestamp_us) {
  std::string name(channel);
  lcm_eventlog_event_t event{};
  event.timestamp = timestamp_us;
  event.channellen = static_cast<int32_t>(name.size());
  event.channel = name.data();
  event.datalen = static_cast<int32_t>(data.size());
  event.data = const_cast<uint8_t*>(data.data());  // LCM's C interface is not const-correct
  if (lcm_eventlog_write_event(impl_->log.get(), &event) != 0) Fail();
  ++events_;
}

void LogWriter::Flush() {
  if (fflush(impl_->log->f) != 0) Fail();
}

LogRecorder::LogRecorder(const BusOptions& options, const std::string& path)
    : writer_(path), bus_(options, "record") {
  bus_.SubscribeRest([this](std::string_view channel, ByteView data) { Record(channel, data); });
  for (const Channel& channel : Channels()) {
    // Requests and announcements of other processes are among the rest.
    if (channel.name == kRepairRequest.name || channel.name == kAnnounce.name) continue;
    const bool ordered = channel.delivery == Delivery::kEvery;
    bus_.SubscribeBytes(
        channel, ordered ? Bus::Reading::kOrdered : Bus::Reading::kPaced,
        [this] { return waiting_bytes_ < kMaxWaitingBytes; },
        [this, name = bus_.WireName(channel)](ByteView data) { Record(name, data); });
  }
  bus_.Every(std::chrono::seconds(1), [this] { Try([this] { writer_.Flush(); }); });
}

void LogRecorder::Record(std::string_view channel, ByteView data) {
  const bool is_about_bus =
      std::ranges::any_of(kAboutBus, [&](const Channel* about) { return channel.ends_with(about->name); });
  if (!is_about_bus) has_content_ = true;
  if (waiting_bytes_ >= 2 * kMaxWaitingBytes) return;  // a flood on unordered channels
  waiting_bytes_ += static_cast<int64_t>(data.size());
  bus_.Post([this, name = std::string(channel), bytes = std::vector<uint8_t>(data.begin(), data.end()),
             time = WallClock_us()] {
    waiting_bytes_ -= static_cast<int64_t>(bytes.size());
    Try([&] {
      writer_.Write(name, bytes, time);
      ++events_;
    });
  });
}

void LogRecorder::Try(const std::function<void()>& write) {
  if (!failure_.empty()) return;
  try {
    write();
  } catch (const std::runtime_error& error) {
    failure_ = error.what();
    if (on_failure_) on_failure_(failure_);
  }
}

void LogRecorder::Run() {
  bus_.Run();
  Try([this] { writer_.Flush(); });
}

void LogRecorder::Stop() { bus_.StopWhenHandled(); }

}  // namespace plslam::bus
