// SPDX-License-Identifier: BSD-3-Clause
#include "tests/integration/recorded_run.h"

#include "core/bus/logs/log_reader.h"
#include "core/bus/transport/wire.h"
#include "plslam/keyframe_t.hpp"
#include "plslam/pose_t.hpp"

namespace plslam::test {
namespace {

template <class Message>
bool Decode(const std::vector<uint8_t>& bytes, Message* message) {
  return message->decode(bytes.data(), 0, static_cast<int>(bytes.size())) > 0;
}

template <class Message>
void Anonymise(Message* message) {
  message->header.source = 0;
  message->header.session = 0;
}

void SetMap(const PublishedMap& follower, RecordedRun* run) {
  run->map_totals = follower.map().Totals();
  MapUpdate whole = follower.Whole();
  for (MapKeyframe& keyframe : whole.keyframes) keyframe.name.session = 0;
  for (const map_update_t& page : bus::CutIntoPages(whole, 60'000)) {
    const auto bytes = bus::Encoded(page);
    run->map_bytes.insert(run->map_bytes.end(), bytes.begin(), bytes.end());
  }
}

/// Adds one message; returns false if it cannot be decoded.
bool Add(const std::string& channel, const std::vector<uint8_t>& bytes, RecordedRun* run, PublishedMap* map) {
  const auto number = [&](const header_t& header) {
    run->sequence_numbers[{channel, header.source}].push_back(header.seq);
  };
  if (channel == "POSE") {
    pose_t pose;
    if (!Decode(bytes, &pose)) return false;
    number(pose.header);
    Anonymise(&pose);
    pose.n_stages = 0;
    pose.age_ms = 0.0;
    pose.stages.clear();
    run->poses.push_back(bus::Encoded(pose));
  } else if (channel == "KEYFRAME") {
    keyframe_t keyframe;
    if (!Decode(bytes, &keyframe)) return false;
    number(keyframe.header);
    Anonymise(&keyframe);
    keyframe.map_id = {};
    run->keyframes.push_back(bus::Encoded(keyframe));
  } else if (channel == "MAP_UPDATE") {
    map_update_t page;
    if (!Decode(bytes, &page)) return false;
    number(page.header);
    map->Add(page);
  } else if (channel == "STREAM") {
    run->streams.emplace_back();
    if (!Decode(bytes, &run->streams.back())) return false;
    number(run->streams.back().header);
  } else if (channel == "STATUS") {
    run->statuses.emplace_back();
    if (!Decode(bytes, &run->statuses.back())) return false;
  }
  return true;
}

}  // namespace

MapUpdate PublishedMap::Whole() const {
  MapUpdate whole = WholeMap(follower_.map());
  whole.version = 1;
  return whole;
}

int RecordedRun::Count(const std::string& channel) const {
  const auto found = counts.find(channel);
  return found == counts.end() ? 0 : found->second;
}

int RecordedRun::Gaps(const std::string& channel) const {
  int gaps = 0;
  for (const auto& [key, numbers] : sequence_numbers) {
    if (key.first != channel) continue;
    for (size_t i = 0; i < numbers.size(); ++i) gaps += numbers[i] == static_cast<int64_t>(i) ? 0 : 1;
  }
  return gaps;
}

RecordedRun ReadRecordedRun(const std::string& log) {
  bus::LogReader reader(log);
  RecordedRun run;
  PublishedMap map;
  while (const auto event = reader.Next()) {
    const auto bytes = reader.Data(event->data_offset, event->data_bytes);
    ++run.counts[event->channel];
    if (!bytes || !Add(event->channel, *bytes, &run, &map)) ++run.undecodable;
  }
  SetMap(map, &run);
  return run;
}

}  // namespace plslam::test
