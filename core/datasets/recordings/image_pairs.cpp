// SPDX-License-Identifier: BSD-3-Clause
#include "core/datasets/recordings/image_pairs.h"

#include <algorithm>
#include <optional>

#include <fmt/format.h>

#include "core/datasets/image_list.h"
#include "core/files/dataset_error.h"
#include "core/io/trajectories/trajectory.h"

namespace plslam {
namespace {

/// Images that are further apart are of two moments, however slow the camera.
constexpr int64_t kMaxPairing_ns = 500'000'000;

/// The images of a topic, in the order of the file.
struct Topic {
  std::string name;
  std::vector<RecordedMessage> messages;
};

std::vector<int64_t> TimesOf(const std::vector<RecordedMessage>& messages) {
  std::vector<int64_t> times_ns;
  times_ns.reserve(messages.size());
  for (const RecordedMessage& message : messages) times_ns.push_back(message.t_ns);
  return times_ns;
}

/// Returns the part of the file to play: all of it for 0.
FileRange RangeOf(const Topic& left, MessageClock clock, size_t part, Notes* notes) {
  const ClockParts by_clock = PartsByClock(left.messages, clock, left.name);
  const std::vector<ClockPart>& parts = by_clock.parts;
  if (part > std::max<size_t>(1, parts.size())) {
    throw DatasetError(fmt::format("part={}: {}", part,
                                   parts.empty() ? "no clock was set back, and so it has one part"
                                                 : fmt::format("it has {} parts", parts.size())));
  }
  if (parts.empty() || (part == 0 && by_clock.all_repeat)) return {};
  std::string all;
  for (size_t i = 0; i < parts.size(); ++i) {
    all += fmt::format("{}{} images from {} s to {} s (part={})", i == 0 ? "" : ", ", parts[i].n_messages,
                       SecondsText(parts[i].first_ns), SecondsText(parts[i].last_ns), i + 1);
  }
  if (part == 0) {
    throw DatasetError(fmt::format("{}, and its parts have no common clock: {}; play one of them, FILE?part=1",
                                   by_clock.reason, all));
  }
  notes->Remark(fmt::format("part {} of {} is played: {}", part, parts.size(), all));
  return parts[part - 1].range;
}

/// The messages in a part of the file.
std::vector<RecordedMessage> Within(const FileRange& range, std::vector<RecordedMessage> messages) {
  std::erase_if(messages, [&](const RecordedMessage& message) { return !range.Contains(message); });
  return messages;
}

/// Returns false, without any change, if there are no pairs by these times.
bool PairBy(MessageClock clock, const Topic& left_topic, const Topic& right_topic, size_t part, ImagePairs* images,
            Notes* notes) {
  Notes found;
  const FileRange range = RangeOf(left_topic, clock, part, &found);
  const auto in_order = [&](const Topic& topic) {
    return InOrderOfTime(Within(range, topic.messages), clock, topic.name, &found);
  };
  const std::vector<RecordedMessage> left = in_order(left_topic), right = in_order(right_topic);
  const std::vector<int64_t> times_ns = TimesOf(left);
  const int64_t step_ns = MedianStep_ns(times_ns);
  const auto pairs = AssociateTimes(times_ns, TimesOf(right), std::min(kMaxPairing_ns, step_ns / 2));
  if (pairs.empty()) return false;
  for (const auto& [l, r] : pairs) images->pairs.emplace_back(left[l], right[r]);
  images->clock = clock;
  images->range = range;
  images->step_ns = step_ns;
  notes->Add(found);
  for (const auto& [topic, messages] : {std::pair(&left_topic, &left), std::pair(&right_topic, &right)}) {
    NoteUnpaired(messages->size() - pairs.size(), messages->size(), "images of " + topic->name, "in time", notes);
  }
  return true;
}

}  // namespace

ImagePairs PairImages(const Recording& recording, const std::string& left_topic, const std::string& right_topic,
                      size_t part, Notes* notes) {
  Topic left{left_topic, recording.Messages(left_topic)}, right{right_topic, recording.Messages(right_topic)};
  if (left.messages.empty() && right.messages.empty()) {
    throw DatasetError(fmt::format("has no messages on {} and {}", left.name, right.name));
  }
  ReadStamps(recording, {&left.messages, &right.messages}, MedianLogStep_ns(left.messages) / kDelayToleranceShare);
  ImagePairs images;
  images.stamp_offset_ns = MedianStampOffset_ns(left.messages);
  for (const Topic* topic : {&left, &right}) {
    const std::string complaint = StampComplaint(topic->messages);
    if (complaint.empty() || images.clock == MessageClock::kLog) continue;
    images.clock = MessageClock::kLog;
    notes->Warn(fmt::format("header stamps of {} {}: images are played by the times at which they were logged",
                            topic->name, complaint));
  }
  if (PairBy(images.clock, left, right, part, &images, notes)) return images;
  if (images.clock == MessageClock::kStamp && PairBy(MessageClock::kLog, left, right, part, &images, notes)) {
    notes->Warn(
        fmt::format("no header stamp of {} is near one of {} (the first are {} s and {} s), as if of two "
                    "clocks: images are played by the times at which they were logged",
                    left.name, right.name, SecondsText(left.messages.front().stamp_ns),
                    SecondsText(right.messages.front().stamp_ns)));
    return images;
  }
  throw DatasetError(fmt::format("{} has {} images and {} has {}, but no two at the same time", left.name,
                                 left.messages.size(), right.name, right.messages.size()));
}

int64_t TimeOf(const Recording& recording, const ImagePairs& images, size_t index) {
  const auto estimate_ns = [&](size_t i) { return images.pairs.at(i).first.t_ns; };
  const int64_t t_ns = estimate_ns(index);
  if (!images.pairs.at(index).first.is_estimated) return t_ns;
  const std::optional<int64_t> stamp_ns = ReadStamp(recording, images.pairs[index].first);
  if (!stamp_ns) return t_ns;
  const bool is_after = index == 0 || *stamp_ns > estimate_ns(index - 1) + (t_ns - estimate_ns(index - 1)) / 2;
  const bool is_before = index + 1 == images.pairs.size() || *stamp_ns <= t_ns + (estimate_ns(index + 1) - t_ns) / 2;
  return is_after && is_before ? *stamp_ns : t_ns;
}

}  // namespace plslam
