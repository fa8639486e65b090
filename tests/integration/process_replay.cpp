// SPDX-License-Identifier: BSD-3-Clause
#include "tests/integration/process_replay.h"

#include <fmt/format.h>
#include <signal.h>

#include <algorithm>
#include <chrono>
#include <stdexcept>

#include "core/bus/logs/log_reader.h"
#include "core/process/process_status.h"
#include "plslam/bodies_t.hpp"
#include "plslam/command_t.hpp"
#include "plslam/keyframe_t.hpp"
#include "plslam/loop_closure_t.hpp"
#include "plslam/pose_t.hpp"
#include "plslam/relocalisation_t.hpp"
#include "plslam/tracks_t.hpp"
#include "tests/integration/message_walk.h"
#include "tests/support/data_folder.h"
#include "tests/support/sanitized.h"
#include "tests/support/text_file.h"

namespace plslam::test {
namespace {

using bus::ByteView;
using bus::Channel;

constexpr std::chrono::seconds kLimit(20);
const std::set<std::string> kPlayed = {"player", "vo", "mapping", "loop"};
/// The channels between the processes of a run. (Repairs and requests depend on the bus.)
const std::set<std::string_view> kOfTheRun = {"CAMERA",       "STREAM", "STEREO_FRAME",   "GROUND_TRUTH",
                                              "POSE",         "TRACKS", "KEYFRAME",       "MAP_UPDATE",
                                              "LOOP_CLOSURE", "STATUS", "RELOCALISATION", "RELOCALISATION_REQUEST"};
/// Fields that differ between two runs of the same data.
const std::set<std::string> kNotCompared = {
    "header_t.source",          "header_t.seq", "stage_t.ms", "pose_t.age_ms", "loop_closure_t.detect_ms",
    "loop_closure_t.correct_ms"};

const Channel* FindChannel(std::string_view name) {
  const auto channels = bus::Channels();
  const auto row = std::ranges::find_if(channels, [&](const Channel& channel) { return channel.name == name; });
  return row == channels.end() ? nullptr : &*row;
}

const MessageLayout& LayoutOf(const Channel& channel) { return *FindMessageLayout(channel.type); }

int64_t FrameOf(ByteView strip) { return bus::ReadInt64(strip.data() + bus::kWireHeaderBytes); }

}  // namespace

MessageLog::MessageLog(const std::string& file) {
  bus::LogReader reader(file);
  while (const auto event = reader.Next()) {
    const Channel* channel = FindChannel(event->channel);
    if (channel == nullptr || !kOfTheRun.contains(channel->name)) continue;
    auto bytes = reader.Data(event->data_offset, event->data_bytes);
    if (!bytes) throw std::runtime_error(file + " is damaged");
    std::string publisher(channel->publisher);
    if (channel->name == bus::kStatus.name) {
      const auto status = MessageOf<status_t>(*bytes);
      publisher = status.process;
      if (!kPlayed.contains(publisher)) continue;
      sources[publisher] = status.header.source;
    }
    messages.push_back({channel, publisher, "", std::move(*bytes)});
  }
}

const std::vector<ReplayedProcess>& ReplayedProcesses() {
  static const std::vector<ReplayedProcess> kRows = {
      {"vo",
       "vo_process",
       {"CAMERA", "STREAM", "STEREO_FRAME", "MAP_UPDATE", "RELOCALISATION", "STATUS"},
       {"POSE", "TRACKS", "KEYFRAME", "RELOCALISATION_REQUEST"}},
      {"mapping", "mapping_process", {"CAMERA", "KEYFRAME", "LOOP_CLOSURE", "STATUS"}, {"MAP_UPDATE"}},
      {"loop",
       "loop_process",
       {"CAMERA", "KEYFRAME", "RELOCALISATION_REQUEST", "MAP_UPDATE", "STATUS"},
       {"LOOP_CLOSURE", "RELOCALISATION"}},
      {"viewer", "viewer_headless", kOfTheRun, {}},
  };
  return kRows;
}

ProcessReplay::ProcessReplay(const MessageLog& log, const ReplayedProcess& process, ReplayFaults faults,
                             std::filesystem::path folder)
    : log_(log),
      process_(process),
      faults_(faults),
      folder_(std::move(folder)),
      listener_(BusOptionsFor(port_.Url()), "listener") {
  std::filesystem::create_directories(folder_);
  for (const std::string& name : kPlayed) {
    if (name == process_.name) continue;
    bus::BusOptions options = BusOptionsFor(port_.Url());
    if (faults_.few_updates && name == "mapping") options.history_bytes = 1;
    played_[name] = std::make_unique<PlayedProcess>(options, name);
  }
  if (faults_.doubled) {
    std::set<SourceId> sources;
    for (const auto& [name, played] : played_) sources.insert(played->source());
    doubler_ = std::make_unique<Doubler>(port_.Url(), std::move(sources));
  }
  Listen();
}

ProcessReplay::~ProcessReplay() {
  child_.reset();
  listener_.Stop();
  listening_.join();
  ExpectNoSanitizerReports(Log());
}

void ProcessReplay::Listen() {
  for (const std::string_view name : process_.outputs) {
    const Channel* channel = FindChannel(name);
    listener_.SubscribeBytes(
        *channel, bus::Bus::Reading::kOrdered, [] { return true; },
        [this, channel](ByteView bytes) {
          const std::scoped_lock lock(mutex_);
          said_.push_back({channel, {bytes.begin(), bytes.end()}});
          changed_.notify_all();
        });
  }
  listener_.Subscribe<status_t>(bus::kStatus, [this](const status_t& status) {
    if (status.process != process_.name) return;
    const std::scoped_lock lock(mutex_);
    status_ = status;
    changed_.notify_all();
  });
  listener_.Subscribe<command_t>(bus::kCommand, [this](const command_t& command) {
    if (command.verb != "go_back") return;
    const std::scoped_lock lock(mutex_);
    go_back_to_ = std::stoll(command.argument.substr(command.argument.find(' ')));
    changed_.notify_all();
  });
  listening_ = std::thread([this] { listener_.Run(); });
}

std::string ProcessReplay::Play() {
  Start();
  AwaitReady();
  if (difference_.empty()) {
    RenameLog();
    Go();
  }
  if (difference_.empty()) AwaitEnd();
  Stop();
  return difference_;
}

void ProcessReplay::Start() {
  std::vector<std::string> arguments = {"--url", port_.Url()};
  const auto set = [&arguments](const std::string& setting) {
    arguments.insert(arguments.end(), {"--set", setting});
  };
  if (process_.name == "viewer") set("viewer.out=" + (folder_ / "out").string());
  if (process_.name == "mapping") set("mapping.state_every=10");
  if (process_.name == "vo" || process_.name == "mapping") {
    set(fmt::format("{}.state_file={}", process_.name, (folder_ / "state").string()));
  }
  if (faults_.drop_fraction > 0.0) set(fmt::format("bus.drop_fraction={}", faults_.drop_fraction));
  child_ = std::make_unique<launcher::ChildProcess>(BinaryFolder() / process_.executable, arguments,
                                                    folder_ / (process_.executable + ".log"));
}

void ProcessReplay::AwaitReady() {
  Await("STATUS ready", [this] {
    const status_t status = this->status();
    return status.pid == child_->pid() && (status.state == "ready" || status.state == "running");
  });
}

/// Each process has another source than in the log; sessions and maps are named by the process that began them.
void ProcessReplay::RenameLog() {
  std::map<int64_t, int64_t> names;
  for (const auto& [name, source] : log_.sources)
    names[source] = name == process_.name ? status().header.source : played_.at(name)->source().value;
  messages_ = log_.messages;
  for (LoggedMessage& message : messages_) {
    const Channel& channel = *message.channel;
    // Frames have no session, and are many.
    if (channel.name != bus::kStereoFrame.name) Rename(LayoutOf(channel), names, &message.bytes);
    if (!process_.outputs.contains(channel.name)) continue;
    message.key = KeyOf(channel, message.bytes);
    if (message.key.empty()) continue;
    const std::string name(channel.name);
    // The first version is repeated for a reader that requests the map before the second one: only its first copy is in
    // order.
    const bool is_new = expected_.try_emplace({name, message.key}, &message).second;
    if (is_new || !IsFirstVersion(channel, message.bytes)) order_[name].push_back(message.key);
  }
}

/// Returns whether it is the first version of the map, which is repeated for readers that request it before there is a
/// second one.
bool ProcessReplay::IsFirstVersion(const Channel& channel, ByteView message) {
  return channel.name == bus::kMapUpdate.name && MessageOf<map_update_t>(message).version == 1;
}

/// Returns the identity of a message on its channel, in words; empty for one that is not compared.
std::string ProcessReplay::KeyOf(const Channel& channel, ByteView message) const {
  if (channel.name == bus::kPose.name) return fmt::format("of frame {}", MessageOf<pose_t>(message).frame_id);
  if (channel.name == bus::kBodies.name) return fmt::format("of frame {}", MessageOf<bodies_t>(message).frame_id);
  if (channel.name == bus::kTracks.name) return fmt::format("of frame {}", MessageOf<tracks_t>(message).frame_id);
  if (channel.name == bus::kRelocalisation.name) {
    return fmt::format("of frame {}", MessageOf<relocalisation_t>(message).frame_id);
  }
  if (channel.type == "keyframe_t") {
    const auto page = MessageOf<keyframe_t>(message);
    return fmt::format("of frame {}, page {}", page.frame_id, page.page);
  }
  if (channel.name == bus::kLoopClosure.name) {
    const auto page = MessageOf<loop_closure_t>(message);
    return fmt::format("of keyframe {}, kind {}, page {}", page.session_keyframe_id, page.kind, page.page);
  }
  if (channel.name == bus::kMapUpdate.name) {
    const auto page = MessageOf<map_update_t>(message);
    if (comparesMaps()) {
      return fmt::format("of keyframe {}, {}", page.session_keyframe_id,
                         page.committed ? "committed" : "not yet committed");
    }
    // The complete map, repeated for a reader.
    if (page.base_version == 0 && page.version > 1) return "";
    return fmt::format("of version {}, page {}", page.version, page.page);
  }
  return "";
}

void ProcessReplay::Go() {
  // A process that waits for another one begins when that is running.
  for (const auto& [name, played] : played_) {
    const auto first = std::ranges::find_if(messages_, [&name](const LoggedMessage& message) {
      return message.channel->name == bus::kStatus.name && message.publisher == name;
    });
    if (first != messages_.end()) played->Say(bus::kStatus, first->bytes);
  }
  for (size_t next = 0; next < messages_.size() && difference_.empty();) {
    Handle(messages_[next], next < again_until_);
    if (next++ == faults_.killed_behind && !restarted_) Restart(&next);
  }
}

void ProcessReplay::Handle(const LoggedMessage& message, bool again) {
  const std::string name(message.channel->name);
  if (!message.key.empty()) {
    return Await(fmt::format("{} {}", name, message.key), [&] { return said_keys_.contains({name, message.key}); });
  }
  const bool is_due = !again || name == bus::kStereoFrame.name;
  if (is_due && process_.inputs.contains(name) && message.publisher != process_.name) {
    played_.at(message.publisher)->Say(*message.channel, message.bytes);
  }
  LookAtSaid();
}

void ProcessReplay::Restart(size_t* next) {
  child_->Signal(SIGKILL);
  while (!child_->Poll()) std::this_thread::yield();
  restarted_ = true;
  Start();
  AwaitReady();
  if (process_.name != "vo") return;
  std::optional<int64_t> frame_id;
  Await("COMMAND go_back", [&] {
    const std::scoped_lock lock(mutex_);
    frame_id = go_back_to_;
    return frame_id.has_value();
  });
  if (frame_id) GoBack(*frame_id, next);
}

/// Goes back to the frame after this one, as the player does.
void ProcessReplay::GoBack(int64_t frame_id, size_t* next) {
  again_until_ = *next;
  for (*next = 0; *next < again_until_; ++*next) {
    const LoggedMessage& message = messages_[*next];
    if (message.channel->name == bus::kStereoFrame.name && FrameOf(message.bytes) > frame_id) break;
  }
  // The next frame follows when the process has repeated these messages.
  for (size_t i = *next; i < again_until_; ++i) {
    if (messages_[i].channel->name == bus::kPose.name) said_keys_.erase({"POSE", messages_[i].key});
  }
}

void ProcessReplay::AwaitEnd() {
  if (process_.name == "viewer") {
    Await("STATUS finished", [this] { return status().state == "finished"; });
  }
  if (comparesMaps()) CompareMaps();
}

void ProcessReplay::Stop() {
  if (!child_->Poll()) child_->Signal(SIGINT);
  const auto end = std::chrono::steady_clock::now() + Patience(kLimit);
  while (!child_->Poll() && std::chrono::steady_clock::now() < end) {
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  LookAtSaid();
  if (!difference_.empty()) return;
  const auto exit = child_->Poll();
  if (!exit) difference_ = process_.executable + " does not end when it is ordered to";
  if (exit && exit->code != 0)
    difference_ = fmt::format("{} ends with exit code {}", process_.executable, exit->code);
}

void ProcessReplay::Await(const std::string& what, const std::function<bool()>& done) {
  const auto end = std::chrono::steady_clock::now() + Patience(kLimit);
  for (;;) {
    LookAtSaid();
    if (!difference_.empty() || done()) return;
    if (child_->Poll()) {
      difference_ = fmt::format("{} ends before it says {}", process_.executable, what);
    } else if (std::chrono::steady_clock::now() > end) {
      difference_ = fmt::format("{} is not said within {} s", what, Patience(kLimit).count() / 1000);
    }
    std::unique_lock lock(mutex_);
    if (said_.empty()) changed_.wait_for(lock, std::chrono::milliseconds(5));
  }
}

/// Also answers requests for the map.
void ProcessReplay::LookAtSaid() {
  std::deque<Said> news;
  {
    const std::scoped_lock lock(mutex_);
    news = std::exchange(said_, {});
  }
  for (const Said& said : news) Compare(said);
  for (const auto& [name, played] : played_) played->AnswerMapRequests();
}

void ProcessReplay::Compare(const Said& said) {
  const std::string name(said.channel->name);
  const std::string key = KeyOf(*said.channel, said.bytes);
  if (key.empty() || !difference_.empty()) return;
  const bool is_new = said_keys_.emplace(name, key).second;
  if (comparesMaps()) return map_.Add(MessageOf<map_update_t>(said.bytes));
  const std::vector<std::string>& order = order_[name];
  const bool has_place = is_new || !IsFirstVersion(*said.channel, said.bytes);
  const size_t n = has_place ? n_said_[name]++ : 0;
  const auto expected = expected_.find({name, key});
  if (expected == expected_.end()) {
    difference_ = fmt::format("{} {} is not in the log", name, key);
  } else if (has_place && !restarted_ && (n >= order.size() || order[n] != key)) {
    difference_ = fmt::format("{} {} comes as number {}, in the log {}", name, key, n + 1,
                              n < order.size() ? "that is the one " + order[n] : "there are fewer");
  } else {
    const std::string difference =
        FirstDifference(LayoutOf(*said.channel), said.bytes, expected->second->bytes, kNotCompared);
    if (!difference.empty()) difference_ = fmt::format("{} {}: {}", name, key, difference);
  }
}

void ProcessReplay::CompareMaps() {
  PublishedMap logged;
  for (const LoggedMessage& message : messages_) {
    if (message.channel->name == bus::kMapUpdate.name) logged.Add(MessageOf<map_update_t>(message.bytes));
  }
  const auto pages = bus::CutIntoPages(map_.Whole(), 60'000),
             logged_pages = bus::CutIntoPages(logged.Whole(), 60'000);
  for (size_t i = 0; i < std::min(pages.size(), logged_pages.size()) && difference_.empty(); ++i) {
    const std::string difference =
        FirstDifference(LayoutOf(bus::kMapUpdate), bus::Encoded(pages[i]), bus::Encoded(logged_pages[i]));
    if (!difference.empty()) difference_ = fmt::format("page {} of the map in the end: {}", i, difference);
  }
}

status_t ProcessReplay::status() const {
  const std::scoped_lock lock(mutex_);
  return status_;
}

double ProcessReplay::Counter(const std::string& name) const { return bus::CounterOf(status(), name); }

std::string ProcessReplay::Read(const std::string& file_of_out) const {
  return ReadText(folder_ / "out" / file_of_out);
}

std::string ProcessReplay::Log() const { return ReadText(folder_ / (process_.executable + ".log")); }

}  // namespace plslam::test
