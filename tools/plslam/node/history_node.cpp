// SPDX-License-Identifier: BSD-3-Clause
#include "tools/plslam/node/history_node.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <condition_variable>
#include <cstring>
#include <deque>
#include <mutex>
#include <optional>
#include <set>
#include <span>
#include <utility>
#include <vector>

#include "core/bus/delivery/history.h"
#include "core/bus/run_loop.h"
#include "core/bus/transport/wire.h"
#include "core/errors/log.h"
#include "core/process/process_usage.h"
#include "plslam/camera_t.hpp"
#include "plslam/ground_truth_t.hpp"
#include "plslam/keyframe_t.hpp"
#include "plslam/loop_closure_t.hpp"
#include "plslam/pose_t.hpp"
#include "plslam/status_t.hpp"
#include "plslam/stream_t.hpp"

namespace plslam::launcher {
namespace {

struct KeptChannel {
  const bus::Channel& channel;
  /// Returns false if the bytes are no such message.
  bool (*publish)(bus::Bus& bus, const bus::Channel& channel, const std::vector<uint8_t>& bytes);
};

template <class Message>
bool Publish(bus::Bus& bus, const bus::Channel& channel, const std::vector<uint8_t>& bytes) {
  std::optional<Message> message = bus::Decoded<Message>(bytes);
  if (message) bus.Publish(channel, std::move(*message));
  return message.has_value();
}

constexpr std::array<KeptChannel, 5> kKept{{{bus::kStream, Publish<stream_t>},
                                            {bus::kPose, Publish<pose_t>},
                                            {bus::kKeyframe, Publish<keyframe_t>},
                                            {bus::kLoopClosure, Publish<loop_closure_t>},
                                            {bus::kGroundTruth, Publish<ground_truth_t>}}};

// The same bound as in the bus: forged sources would exceed it.
constexpr size_t kMaxPublishers = 256;
constexpr size_t kMaxRecordedProcesses = 4096;
// The player's period.
constexpr std::chrono::seconds kCameraPeriod{1};

int UnnamedFile(const std::string& folder) {
  std::string path = folder + "/.history_XXXXXX";
  const int file = mkostemp(path.data(), O_CLOEXEC);
  if (file >= 0) unlink(path.c_str());
  return file;
}

bool WriteAll(int file, std::span<const uint8_t> bytes, int64_t offset) {
  while (!bytes.empty()) {
    const ssize_t written = pwrite(file, bytes.data(), bytes.size(), offset);
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return false;
    bytes = bytes.subspan(static_cast<size_t>(written));
    offset += written;
  }
  return true;
}

bool ReadAll(int file, std::span<uint8_t> bytes, int64_t offset) {
  while (!bytes.empty()) {
    const ssize_t read = pread(file, bytes.data(), bytes.size(), offset);
    if (read < 0 && errno == EINTR) continue;
    if (read <= 0) return false;
    bytes = bytes.subspan(static_cast<size_t>(read));
    offset += read;
  }
  return true;
}

}  // namespace

struct HistoryKeeper::Store {
  Store(const std::string& folder_in, SourceId own_in) : folder(folder_in), own(own_in), file(UnnamedFile(folder)) {
    if (file < 0) Fail(std::strerror(errno));
  }
  ~Store() {
    if (file >= 0) close(file);
  }
  Store(const Store&) = delete;
  Store& operator=(const Store&) = delete;

  void Keep(size_t channel, std::span<const uint8_t> message);
  void RemovePublisher(SourceId source);
  bool RepublishesFor(SourceId source) const;
  void Fail(const std::string& why);

  const std::string folder;
  const SourceId own;  // our own messages are not kept
  const int file;

  mutable std::mutex mutex;  // guards all of the following
  std::condition_variable changed;
  std::map<SourceId, std::vector<Entry>> entries;  // by publisher
  std::set<SourceId> gone;                         // publishers that have exited
  std::deque<SourceId> due;                        // of these, the ones whose messages are to be republished
  int64_t end = 0;                                 // of the file
  int64_t kept = 0;
  std::string problem;
  bool stopping = false;
};

/// On the receiving thread.
void HistoryKeeper::Store::Keep(size_t channel, std::span<const uint8_t> message) {
  const SourceId source = bus::ReadHeader(message).source;
  if (source == own) return;
  int64_t offset = 0;
  {
    const std::scoped_lock lock(mutex);
    if (!problem.empty() || (entries.size() >= kMaxPublishers && !entries.contains(source))) return;
    offset = end;
    end += static_cast<int64_t>(message.size());
  }
  if (!WriteAll(file, message, offset)) return Fail(std::strerror(errno));
  const std::scoped_lock lock(mutex);
  entries[source].push_back({channel, offset, message.size()});
  ++kept;
  if (!gone.contains(source)) return;
  // It was on its way when its publisher exited.
  due.push_back(source);
  changed.notify_all();
}

void HistoryKeeper::Store::RemovePublisher(SourceId source) {
  const std::scoped_lock lock(mutex);
  gone.insert(source);
  due.push_back(source);
  changed.notify_all();
}

/// Returns whether it has exited, and not all processes stop.
bool HistoryKeeper::Store::RepublishesFor(SourceId source) const {
  const std::scoped_lock lock(mutex);
  return !stopping && gone.contains(source);
}

void HistoryKeeper::Store::Fail(const std::string& why) {
  const std::scoped_lock lock(mutex);
  if (!problem.empty()) return;
  problem = fmt::format("{}: {}", folder, why);
  // The disk space is left to other processes.
  entries.clear();
  if (file >= 0 && ftruncate(file, 0) != 0) LogWarning("{}: {}", folder, std::strerror(errno));
  LogWarning("the history for restarted processes is no longer recorded: {}", problem);
}

HistoryKeeper::HistoryKeeper(bus::Bus& bus, const std::filesystem::path& folder)
    : bus_(bus), store_(std::make_shared<Store>(folder.string(), bus.source())) {
  bus_.Subscribe<status_t>(bus::kStatus, [this, host = bus::HostName()](const status_t& m) {
    if (m.host != host) return;  // process ids of other hosts are meaningless here
    if (sources_.size() < kMaxRecordedProcesses || sources_.contains(m.pid))
      sources_[m.pid] = SourceId(m.header.source);
  });
  bus_.Subscribe<camera_t>(bus::kCamera, [this](const camera_t& m) {
    if (SourceId(m.header.source) != store_->own) camera_ = std::make_unique<camera_t>(m);
  });
  bus_.Every(kCameraPeriod, [this] { RepublishRig(); });
  for (size_t i = 0; i < kKept.size(); ++i) {
    bus_.SubscribeBytes(
        kKept[i].channel, bus::Bus::Reading::kOrdered, [] { return true; },
        [store = store_, i](std::span<const uint8_t> message) { store->Keep(i, message); });
  }
  worker_ = std::thread([this] { bus::RunGuarded(bus_, [this] { Work(); }); });
}

HistoryKeeper::~HistoryKeeper() {
  Stop();
  worker_.join();
}

void HistoryKeeper::Stop() {
  {
    const std::scoped_lock lock(store_->mutex);
    store_->stopping = true;
  }
  store_->changed.notify_all();
}

void HistoryKeeper::OnExit(pid_t pid) {
  const auto found = sources_.find(pid);
  if (found == sources_.end()) return;
  store_->RemovePublisher(found->second);
  RepublishRig();
  // The history that its bus had spilled to disk, which the exited process cannot remove.
  std::error_code ignored;
  std::filesystem::remove_all(bus::TemporaryFolder(found->second), ignored);
  sources_.erase(found);
}

void HistoryKeeper::RepublishRig() {
  if (camera_ && store_->RepublishesFor(SourceId(camera_->header.source))) bus_.Publish(bus::kCamera, *camera_);
}

int64_t HistoryKeeper::kept() const {
  const std::scoped_lock lock(store_->mutex);
  return store_->kept;
}

std::string HistoryKeeper::problem() const {
  const std::scoped_lock lock(store_->mutex);
  return store_->problem;
}

void HistoryKeeper::Work() {
  Store& store = *store_;
  std::unique_lock lock(store.mutex);
  for (;;) {
    store.changed.wait(lock, [&store] { return store.stopping || !store.due.empty(); });
    if (store.stopping) return;
    const std::vector<Entry> entries = std::exchange(store.entries[store.due.front()], {});
    store.due.pop_front();
    for (const Entry& entry : entries) {
      lock.unlock();
      if (Republish(entry)) ++republished_;
      lock.lock();
      if (store.stopping) return;
    }
  }
}

bool HistoryKeeper::Republish(const Entry& entry) {
  std::vector<uint8_t> bytes(entry.bytes);
  const KeptChannel& kept = kKept[entry.channel];
  return ReadAll(store_->file, bytes, entry.offset) && kept.publish(bus_, kept.channel, bytes);
}

}  // namespace plslam::launcher
