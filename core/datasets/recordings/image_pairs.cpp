// SPDX-License-Identifier: BSD-3-Clause
#include "core/datasets/recordings/image_pairs.h"

#include <algorithm>
#include <optional>

#include <fmt/format.h>

#include "core/datasets/image_list.h"
#include "core/io/files/dataset_error.h"
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

/// Returns false, without any change, if there are no pairs by these times.
bool PairBy(MessageClock clock, const Topic& left_topic, const Topic& right_topic, ImagePairs* images,
            std::vector<std::string>* notes) {
  std::vector<std::string> found;
  const std::vector<RecordedMessage> left = InOrderOfTime(left_topic.messages, clock, left_topic.name, &found),
                                     right = InOrderOfTime(right_topic.messages, clock, right_topic.name, &found);
  const std::vector<int64_t> times_ns = TimesOf(left);
  const int64_t step_ns = MedianStep_ns(times_ns);
  const auto pairs = AssociateTimes(times_ns, TimesOf(right), std::min(kMaxPairing_ns, step_ns / 2));
  if (pairs.empty()) return false;
  for (const auto& [l, r] : pairs) images->pairs.emplace_back(left[l], right[r]);
  images->clock = clock;
  images->step_ns = step_ns;
  notes->insert(notes->end(), found.begin(), found.end());
  if (pairs.size() < left.size()) {
    notes->push_back(fmt::format("{} images of {} have no partner in time and are skipped",
                                 left.size() - pairs.size(), left_topic.name));
  }
  return true;
}

}  // namespace

ImagePairs PairImages(const Recording& recording, const std::string& left_topic, const std::string& right_topic,
                      std::vector<std::string>* notes) {
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
    notes->push_back(
        fmt::format("header stamps of {} {}: images are played by their log times", topic->name, complaint));
  }
  if (PairBy(images.clock, left, right, &images, notes)) return images;
  if (images.clock == MessageClock::kStamp && PairBy(MessageClock::kLog, left, right, &images, notes)) {
    notes->push_back(
        fmt::format("no header stamp of {} is near one of {} (the first are {} s and {} s), as if from two clocks: "
                    "images are played by their log times",
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
