// SPDX-License-Identifier: BSD-3-Clause
#include "core/datasets/recordings/message_times.h"

#include <algorithm>
#include <cstdlib>
#include <iterator>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include <fmt/format.h>

#include "core/datasets/image_list.h"
#include "core/files/dataset_error.h"
#include "core/io/trajectories/trajectory.h"

namespace plslam {
namespace {

using Messages = std::vector<RecordedMessage>;

constexpr uint64_t kMostAtOnce = 512 << 20;
constexpr uint64_t kCostOfRead = 64 << 10;
constexpr size_t kStretches = 16;
constexpr size_t kMostStretchesShare = 8;
/// Later ones are of no clock, and differences of times must not overflow.
constexpr int64_t kLatest_ns = 4'000'000'000'000'000'000;
/// A camera has more stamps than this share of its images, if its driver sets them.
constexpr size_t kLeastStampShare = 4;
/// Recorders delay messages by up to a second; a clock that goes back further was reset.
constexpr int64_t kLongestDelay_ns = 2'000'000'000;

int64_t LogTime_ns(const RecordedMessage& message) { return std::clamp<int64_t>(message.t_ns, 0, kLatest_ns); }

std::vector<int64_t> SortedLogTimes(const Messages& messages) {
  std::vector<int64_t> times_ns;
  for (const RecordedMessage& message : messages) times_ns.push_back(LogTime_ns(message));
  std::sort(times_ns.begin(), times_ns.end());
  return times_ns;
}

std::vector<int64_t> StampOffsets(const Messages& messages) {
  std::vector<int64_t> offsets_ns;
  for (const RecordedMessage& message : messages) {
    if (message.stamp_ns > 0) offsets_ns.push_back(message.stamp_ns - LogTime_ns(message));
  }
  return offsets_ns;
}

bool HasStamp(const RecordedMessage& message) { return message.stamp_ns != RecordedMessage::kNotRead; }

std::vector<RecordedMessage*> InOrderOfFile(std::vector<RecordedMessage*> messages) {
  std::sort(messages.begin(), messages.end(),
            [](const RecordedMessage* a, const RecordedMessage* b) { return PlaceOf(*a) < PlaceOf(*b); });
  return messages;
}

void ReadStampsOf(const Recording& recording, const std::vector<RecordedMessage*>& messages) {
  for (const RecordedMessage* message : messages) recording.WillReadBegin(*message, kStampBytes);
  for (RecordedMessage* message : messages) {
    if (HasStamp(*message)) continue;
    try {
      message->stamp_ns = StampOf(recording.ReadBegin(*message, kStampBytes));
    } catch (const DatasetError&) {
      continue;  // the message is damaged, which is an error when it is played
    }
  }
}

/// Messages of one topic from `first` to `last`, whose stamps have been read at both ends.
struct Stretch {
  Messages* topic = nullptr;
  size_t first = 0, last = 0;
};

/// Interpolates the stamps in between, or returns false if the ends do not determine them.
bool Estimate(const Stretch& stretch, int64_t tolerance_ns) {
  Messages& messages = *stretch.topic;
  const RecordedMessage &a = messages[stretch.first], &b = messages[stretch.last];
  const auto n = static_cast<double>(stretch.last - stretch.first);
  if (a.stamp_ns <= 0 || b.stamp_ns <= 0) return false;
  const int64_t offset_ns = a.stamp_ns - LogTime_ns(a), other_ns = b.stamp_ns - LogTime_ns(b);
  const auto step_ns = static_cast<double>(LogTime_ns(b) - LogTime_ns(a)) / n;
  if (std::abs(offset_ns - other_ns) > tolerance_ns || step_ns <= 0.0) return false;
  const auto logged_ns = [&](size_t i) {
    return LogTime_ns(a) + static_cast<int64_t>(step_ns * static_cast<double>(i - stretch.first));
  };
  for (size_t i = stretch.first + 1; i < stretch.last; ++i) {
    if (std::abs(LogTime_ns(messages[i]) - logged_ns(i)) > tolerance_ns) return false;
  }
  for (size_t i = stretch.first + 1; i < stretch.last; ++i) {
    if (HasStamp(messages[i])) continue;
    messages[i].stamp_ns = std::max<int64_t>(1, LogTime_ns(messages[i]) + offset_ns);
    messages[i].is_estimated = true;
  }
  return true;
}

std::vector<Stretch> Stretches(const std::vector<Messages*>& topics) {
  std::vector<Stretch> stretches;
  for (Messages* topic : topics) {
    const size_t n = topic->size();
    for (size_t i = 0; i < kStretches && n > 1; ++i) {
      const Stretch stretch{topic, (n - 1) * i / kStretches, (n - 1) * (i + 1) / kStretches};
      if (stretch.first < stretch.last) stretches.push_back(stretch);
    }
  }
  return stretches;
}

/// The stretches that do not follow from their ends, halved.
std::vector<Stretch> Halves(const std::vector<Stretch>& stretches, int64_t tolerance_ns) {
  std::vector<Stretch> halves;
  for (const Stretch& stretch : stretches) {
    if (stretch.last - stretch.first < 2 || Estimate(stretch, tolerance_ns)) continue;
    const size_t middle = stretch.first + (stretch.last - stretch.first) / 2;
    halves.push_back({stretch.topic, stretch.first, middle});
    halves.push_back({stretch.topic, middle, stretch.last});
  }
  return halves;
}

/// Returns the cost of reading all these stamps, in bytes of lz4 that could be decompressed in the same time.
uint64_t Cost(const Recording& recording, const std::vector<RecordedMessage*>& messages) {
  uint64_t cost = 0;
  std::set<uint32_t> chunks;
  for (const RecordedMessage* message : messages) {
    const bool is_in_chunk = message->chunk != RecordedMessage::kNoChunk;
    const uint64_t of_chunk = is_in_chunk ? recording.DecompressionCost(message->chunk) : 0;
    if (of_chunk == 0) {
      cost += kCostOfRead;
    } else if (chunks.insert(message->chunk).second) {
      cost += of_chunk;
    }
  }
  return cost;
}

/// Returns the messages without a stamp, in the order of the file.
std::vector<RecordedMessage*> NotRead(const std::vector<Messages*>& topics) {
  std::vector<RecordedMessage*> messages;
  for (Messages* topic : topics) {
    for (RecordedMessage& message : *topic) {
      if (!HasStamp(message)) messages.push_back(&message);
    }
  }
  return InOrderOfFile(std::move(messages));
}

}  // namespace

int64_t MedianStampOffset_ns(const Messages& messages) {
  std::vector<int64_t> offsets_ns = StampOffsets(messages);
  if (offsets_ns.empty()) return 0;
  const auto middle = offsets_ns.begin() + std::ssize(offsets_ns) / 2;
  std::nth_element(offsets_ns.begin(), middle, offsets_ns.end());
  return *middle;
}

int64_t MedianLogStep_ns(const Messages& messages) { return MedianStep_ns(SortedLogTimes(messages)); }

void ReadStamps(const Recording& recording, const std::vector<Messages*>& topics, int64_t tolerance_ns) {
  const std::vector<RecordedMessage*> all = NotRead(topics);
  std::vector<Stretch> stretches;
  if (Cost(recording, all) > kMostAtOnce) stretches = Stretches(topics);
  const size_t n_begin = stretches.size();
  // If most messages would be read one by one, it is faster to read all in the order of the file.
  while (!stretches.empty() && stretches.size() <= n_begin + all.size() / kMostStretchesShare) {
    std::vector<RecordedMessage*> ends;
    for (const Stretch& stretch : stretches) {
      ends.push_back(&(*stretch.topic)[stretch.first]);
      ends.push_back(&(*stretch.topic)[stretch.last]);
    }
    ReadStampsOf(recording, InOrderOfFile(std::move(ends)));
    stretches = Halves(stretches, tolerance_ns);
  }
  ReadStampsOf(recording, NotRead(topics));
}

std::optional<int64_t> ReadStamp(const Recording& recording, const RecordedMessage& message) {
  try {
    const int64_t stamp_ns = StampOf(recording.ReadBegin(message, kStampBytes));
    return stamp_ns > 0 ? std::optional(stamp_ns) : std::nullopt;
  } catch (const DatasetError&) {
    return std::nullopt;  // the message is damaged, which is an error when it is played
  }
}

void StampByLogTime(int64_t offset_ns, Messages* messages) {
  for (RecordedMessage& message : *messages) {
    if (HasStamp(message)) continue;
    message.stamp_ns = std::max<int64_t>(1, LogTime_ns(message) + offset_ns);
    message.is_estimated = false;
  }
}

std::string StampComplaint(const Messages& messages) {
  std::vector<int64_t> stamps_ns;
  for (const RecordedMessage& message : messages) {
    if (HasStamp(message)) stamps_ns.push_back(message.stamp_ns);
  }
  if (messages.empty()) return "";
  if (stamps_ns.empty()) return "cannot be read";
  const size_t n_read = stamps_ns.size();
  std::sort(stamps_ns.begin(), stamps_ns.end());
  stamps_ns.erase(std::unique(stamps_ns.begin(), stamps_ns.end()), stamps_ns.end());
  if (stamps_ns.back() == 0) return "are all zero";
  if (stamps_ns.size() == 1 && n_read > 1) return "are all equal";
  if (kLeastStampShare * stamps_ns.size() >= n_read) return "";
  return fmt::format("have {} values in {} messages", stamps_ns.size(), n_read);
}

namespace {

/// Times in the order of the file.
using Times = std::vector<int64_t>;

/// Times at which a clock was set back, as indices of the messages after them, and the times around the first one.
struct SetBack {
  std::vector<size_t> places;
  int64_t before_ns = 0, after_ns = 0;
  bool all_repeat = true;  ///< each makes a stretch of time occur twice
};

SetBack FindSetBack(const Times& times_ns) {
  Times sorted_ns = times_ns;
  std::sort(sorted_ns.begin(), sorted_ns.end());
  sorted_ns.erase(std::unique(sorted_ns.begin(), sorted_ns.end()), sorted_ns.end());
  const int64_t step_ns = std::max<int64_t>(1, MedianStep_ns(sorted_ns));
  SetBack found;
  for (size_t i = 1; i < times_ns.size(); ++i) {
    const int64_t back_ns = times_ns[i - 1] - times_ns[i];
    if (back_ns / 2 < step_ns) continue;
    // Messages that were logged late leave a gap at their stamps. A clock that was set back leaves none.
    const auto first = std::lower_bound(sorted_ns.begin(), sorted_ns.end(), times_ns[i]);
    const auto end = std::upper_bound(sorted_ns.begin(), sorted_ns.end(), times_ns[i - 1]);
    const auto n = static_cast<double>(end - first);
    const double n_expected = static_cast<double>(back_ns) / static_cast<double>(step_ns) + 1.0;
    const bool repeats = n >= 4.0 && n >= 1.5 * n_expected;
    if (!repeats && back_ns <= kLongestDelay_ns) continue;
    found.all_repeat &= repeats;
    found.places.push_back(i);
    if (found.places.size() > 1) continue;
    found.before_ns = times_ns[i - 1];
    found.after_ns = times_ns[i];
  }
  return found;
}

std::string NameOf(MessageClock clock) {
  return clock == MessageClock::kStamp ? "header stamps" : "times of logging";
}

std::string SetBackText(const SetBack& found, MessageClock clock, const std::string& topic) {
  const size_t n = found.places.size();
  return fmt::format("{} of {} go back by {} s at {} s, since a clock was set{}", NameOf(clock), topic,
                     SecondsText(found.before_ns - found.after_ns), SecondsText(found.before_ns),
                     n == 1 ? "" : fmt::format(" ({} times)", n));
}

/// Removes up to three messages in a row whose times are seconds off those before and after them; how many.
int64_t RemoveStrays(Messages& messages) {
  constexpr size_t kMostStrays = 3;
  std::vector<size_t> kept;
  const auto time = [&](size_t i) { return messages[i].t_ns; };
  const auto is_behind = [&](size_t i, size_t other) { return time(other) - time(i) > kLongestDelay_ns; };
  // The number of last messages that are strays, since `i` continues those before them.
  const auto n_ahead = [&](size_t i) -> size_t {
    if (kept.size() <= kMostStrays) return messages.size() > 3 * kMostStrays ? kept.size() : 0;
    for (size_t n = 1; n <= kMostStrays; ++n) {
      const size_t before = kept[kept.size() - 1 - n];
      if (time(before) <= time(i) && is_behind(before, kept[kept.size() - n])) return n;
    }
    return 0;
  };
  const auto returns = [&](size_t i) {
    const size_t end = std::min(messages.size(), i + kMostStrays + 1);
    if (i + kMostStrays >= messages.size()) return true;
    for (size_t next = i + 1; next < end; ++next) {
      if (time(next) >= time(kept.back())) return true;
    }
    return false;
  };
  for (size_t i = 0; i < messages.size(); ++i) {
    if (!kept.empty() && is_behind(i, kept.back())) {
      const size_t n = n_ahead(i);
      kept.resize(kept.size() - n);
      if (n == 0 && messages.size() > 3 * kMostStrays && returns(i)) continue;
    }
    kept.push_back(i);
  }
  const auto n_removed = static_cast<int64_t>(messages.size() - kept.size());
  Messages rest;
  for (const size_t i : kept) rest.push_back(messages[i]);
  messages = std::move(rest);
  return n_removed;
}

/// Messages in the order of the file, whose `t_ns` is the time of a clock.
struct TimedMessages {
  Messages messages;
  int64_t n_zero = 0, n_stray = 0;  ///< removed
};

TimedMessages WithTimes(Messages messages, MessageClock clock) {
  TimedMessages timed;
  const bool by_stamp = clock == MessageClock::kStamp;
  if (by_stamp) {
    timed.n_zero = static_cast<int64_t>(
        std::erase_if(messages, [](const RecordedMessage& message) { return message.stamp_ns == 0; }));
    StampByLogTime(MedianStampOffset_ns(messages), &messages);
  }
  for (RecordedMessage& message : messages) {
    message.t_ns = by_stamp ? message.stamp_ns : LogTime_ns(message);
    message.is_estimated &= by_stamp;
  }
  timed.n_stray = RemoveStrays(messages);
  timed.messages = std::move(messages);
  return timed;
}

Times TimesOf(const Messages& messages) {
  Times times_ns;
  for (const RecordedMessage& message : messages) times_ns.push_back(message.t_ns);
  return times_ns;
}

/// Removes messages that are not later than all before them; how many.
int64_t KeepLatest(Messages& messages) {
  Messages kept;
  for (const RecordedMessage& message : messages) {
    if (kept.empty() || message.t_ns > kept.back().t_ns) kept.push_back(message);
  }
  const int64_t n = std::ssize(messages) - std::ssize(kept);
  messages = std::move(kept);
  return n;
}

/// Reports the first step that is far longer than the others: a warning if a clock was set forward, since the messages
/// were logged one soon after the other, and a remark if there was a pause. `logged` are the same messages, and others,
/// with their times of logging.
void NoteJumps(const Messages& messages, const Messages& logged, MessageClock clock, const std::string& topic,
               Notes* notes) {
  constexpr int64_t kManySteps = 20;
  std::map<FilePlace, int64_t> logged_ns;
  Times times_ns = TimesOf(messages);
  std::sort(times_ns.begin(), times_ns.end());
  const int64_t median_ns = MedianStep_ns(times_ns);
  for (size_t i = 1; i < messages.size(); ++i) {
    const int64_t step_ns = messages[i].t_ns - messages[i - 1].t_ns;
    if (step_ns <= kLongestDelay_ns || step_ns / kManySteps <= median_ns) continue;
    if (logged_ns.empty()) {
      for (const RecordedMessage& message : logged) logged_ns.emplace(PlaceOf(message), LogTime_ns(message));
    }
    const int64_t log_step_ns = logged_ns.at(PlaceOf(messages[i])) - logged_ns.at(PlaceOf(messages[i - 1]));
    const bool is_set = clock == MessageClock::kStamp && log_step_ns > 0 && log_step_ns < step_ns / 2;
    const std::string at = SecondsText(messages[i - 1].t_ns), by = SecondsText(step_ns);
    notes->Add(is_set,
               is_set
                   ? fmt::format("header stamps of {} jump forward by {} s at {} s, but the messages were logged {} "
                                 "s apart: a clock was set",
                                 topic, by, at, SecondsText(log_step_ns))
                   : fmt::format("{} has no messages for {} s after {} s", topic, by, at));
    return;
  }
}

/// Removes messages with the time of the one before; how many.
int64_t RemoveEqual(Messages& messages) {
  const auto end = std::unique(messages.begin(), messages.end(),
                               [](const RecordedMessage& a, const RecordedMessage& b) { return a.t_ns == b.t_ns; });
  const int64_t n = messages.end() - end;
  messages.erase(end, messages.end());
  return n;
}

}  // namespace

ClockParts PartsByClock(const Messages& messages, MessageClock clock, const std::string& topic) {
  const Messages timed = WithTimes(messages, clock).messages;
  const SetBack found = FindSetBack(TimesOf(timed));
  ClockParts result;
  result.all_repeat = found.all_repeat;
  if (found.places.empty()) return result;
  result.reason = SetBackText(found, clock, topic);
  std::vector<size_t> bounds = found.places;
  bounds.insert(bounds.begin(), 0);
  for (size_t part = 0; part < bounds.size(); ++part) {
    const bool is_last = part + 1 == bounds.size();
    const size_t first = bounds[part], end = is_last ? timed.size() : bounds[part + 1];
    FileRange range;
    if (part > 0) range.begin = PlaceOf(timed[first]);
    if (!is_last) range.end = PlaceOf(timed[end]);
    result.parts.push_back({range, end - first, timed[first].t_ns, timed[end - 1].t_ns});
  }
  return result;
}

Messages InOrderOfTime(Messages messages, MessageClock clock, const std::string& topic, Notes* notes) {
  const auto note = [&](int64_t n, const std::string& reason) {
    if (n > 0) notes->Warn(fmt::format("{} message{} of {} skipped: {}", n, n == 1 ? "" : "s", topic, reason));
  };
  TimedMessages timed = WithTimes(messages, clock);
  note(timed.n_zero, "the header stamp is zero");
  note(timed.n_stray, "more than 2 s before or after their neighbours in the file");
  NoteJumps(timed.messages, messages, clock, topic, notes);
  messages = std::move(timed.messages);
  const SetBack set_back = FindSetBack(TimesOf(messages));
  if (!set_back.places.empty()) {
    notes->Warn(fmt::format("{}: play the parts before and after alone (FILE?part=1, FILE?part=2)",
                            SetBackText(set_back, clock, topic)));
    if (set_back.all_repeat) note(KeepLatest(messages), "not later than the ones before");
  }
  std::stable_sort(messages.begin(), messages.end(),
                   [](const RecordedMessage& a, const RecordedMessage& b) { return a.t_ns < b.t_ns; });
  note(RemoveEqual(messages), "another one has the same time");
  return messages;
}

}  // namespace plslam
