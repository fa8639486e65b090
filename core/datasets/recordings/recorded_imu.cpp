// SPDX-License-Identifier: BSD-3-Clause
#include "core/datasets/recordings/recorded_imu.h"

#include <algorithm>
#include <cstdint>
#include <functional>
#include <set>
#include <span>
#include <string_view>

#include <fmt/format.h>

#include "core/datasets/image_list.h"
#include "core/datasets/imu_join.h"
#include "core/datasets/recordings/ros_messages.h"
#include "core/errors/error_text.h"
#include "core/files/dataset_error.h"

namespace plslam {
namespace {

constexpr std::string_view kStaticTransforms = "/tf_static";

/// A type of messages, and the most bytes of one that are read: in chunks without compression, only these are.
struct MessageType {
  std::string_view name;
  uint64_t most_bytes = 0;
};
constexpr MessageType kImuType{kRosImu, 1024};
constexpr MessageType kTransformsType{kRosTransforms, 1 << 20};

bool IsOfType(const RecordedChannel& channel, std::string_view type) {
  return RosEncodingOf(channel.encoding) && channel.type == type;
}

/// Returns nullptr if there is none.
const RecordedChannel* FindChannel(const Recording& recording, std::string_view topic, std::string_view type) {
  for (const RecordedChannel& channel : recording.channels()) {
    if (channel.topic == topic && IsOfType(channel, type)) return &channel;
  }
  return nullptr;
}

/// Calls `use` for each message of a topic in a part of the file, in its order; returns the number of those that are
/// damaged.
size_t ForEachMessage(const Recording& recording, std::string_view topic, const MessageType& type,
                      const FileRange& range,
                      const std::function<void(std::span<const uint8_t> message, RosEncoding encoding)>& use) {
  size_t n_damaged = 0;
  const RecordedChannel* const channel = FindChannel(recording, topic, type.name);
  if (channel == nullptr) return 0;
  std::vector<RecordedMessage> messages = recording.Messages(channel->topic);
  SortByPlace(messages);
  for (const RecordedMessage& message : messages) recording.WillReadBegin(message, type.most_bytes);
  for (const RecordedMessage& message : messages) {
    if (!range.Contains(message)) continue;
    try {
      use(recording.ReadBegin(message, type.most_bytes), *RosEncodingOf(channel->encoding));
    } catch (const DatasetError&) {
      ++n_damaged;
    }
  }
  return n_damaged;
}

enum class Measured { kBoth, kRate, kForce };

/// Reads the messages of one topic, of which `measured` is needed.
std::vector<ImuSample> ReadMessages(const Recording& recording, const std::string& topic, Measured measured,
                                    const FileRange& range, Notes* notes) {
  std::vector<ImuSample> samples;
  size_t n_unstamped = 0, n_unmeasured = 0;
  const size_t n_damaged =
      ForEachMessage(recording, topic, kImuType, range, [&](std::span<const uint8_t> message, RosEncoding encoding) {
        const RosImu imu = ParseImu(message, encoding);
        const bool is_measured =
            (imu.has_rate || measured == Measured::kForce) && (imu.has_force || measured == Measured::kRate);
        if (imu.sample.t_ns == 0) {
          ++n_unstamped;
        } else if (!is_measured) {
          ++n_unmeasured;
        } else {
          samples.push_back(imu.sample);
        }
      });
  std::stable_sort(samples.begin(), samples.end(),
                   [](const ImuSample& x, const ImuSample& y) { return x.t_ns < y.t_ns; });
  const auto end = std::unique(samples.begin(), samples.end(),
                               [](const ImuSample& x, const ImuSample& y) { return x.t_ns == y.t_ns; });
  const auto n_repeated = static_cast<size_t>(samples.end() - end);
  samples.erase(end, samples.end());
  const auto note = [&](size_t n, const char* reason) {
    if (n > 0) {
      notes->Warn(fmt::format("{} message{} of {} {} skipped: {}", n, n == 1 ? "" : "s", topic, n == 1 ? "is" : "are",
                              reason));
    }
  };
  note(n_repeated, "another one has the same header stamp");
  note(n_unstamped, "the header stamp is zero");
  note(n_unmeasured, "their covariances begin with -1, and so nothing was measured");
  note(n_damaged, "they are damaged");
  if (samples.empty()) throw DatasetError(fmt::format("{} has no sample that can be used", topic));
  return samples;
}

}  // namespace

std::vector<ImuTopics> ImuTopicsOf(const Recording& recording) {
  std::set<std::string> topics;
  for (const RecordedChannel& channel : recording.channels()) {
    if (IsOfType(channel, kRosImu)) topics.insert(channel.topic);
  }
  return ImuTopicsAmong(topics);
}

std::string FrameOfImu(const Recording& recording, const ImuTopics& topics) {
  const RecordedChannel* const channel = FindChannel(recording, topics.rates, kRosImu);
  if (channel == nullptr) return "";
  const std::vector<RecordedMessage> messages = recording.Messages(channel->topic);
  try {
    return messages.empty() ? ""
                            : FrameOf(recording.ReadBegin(messages.front(), kImuType.most_bytes),
                                      *RosEncodingOf(channel->encoding));
  } catch (const DatasetError&) {
    return "";  // the message is damaged, which is reported when all are read
  }
}

std::vector<ImuSample> ReadRecordedImu(const Recording& recording, const ImuTopics& topics, const FileRange& range,
                                       Notes* notes) {
  if (!topics.are_apart()) return ReadMessages(recording, topics.rates, Measured::kBoth, range, notes);
  const std::vector<ImuSample> forces = ReadMessages(recording, topics.forces, Measured::kForce, range, notes);
  const std::vector<ImuSample> rates = ReadMessages(recording, topics.rates, Measured::kRate, range, notes);
  ImuJoin join;
  for (const ImuSample& sample : forces) join.AddForce(sample.t_ns, sample.force_m_s2);
  for (const ImuSample& sample : rates) join.AddRate(sample.t_ns, sample.rate_rad_s);
  std::vector<ImuSample> samples = join.Take();
  NoteUnpaired(rates.size() - samples.size(), rates.size(), "rates of " + topics.rates,
               "around them on " + topics.forces, notes);
  if (samples.empty()) {
    throw DatasetError(fmt::format("no force on {} is near a rate on {}", topics.forces, topics.rates));
  }
  return samples;
}

std::optional<SE3> RecordedTransform(const Recording& recording, const std::string& a, const std::string& b) {
  if (a.empty() || b.empty()) return std::nullopt;
  StaticFrames frames;
  ForEachMessage(
      recording, kStaticTransforms, kTransformsType, {},
      [&](std::span<const uint8_t> message, RosEncoding encoding) { ParseTransforms(message, encoding, &frames); });
  return frames.Between(a, b);
}

}  // namespace plslam
