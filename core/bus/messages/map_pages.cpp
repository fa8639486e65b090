// SPDX-License-Identifier: BSD-3-Clause
#include "core/bus/messages/map_pages.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

#include "core/bus/messages/convert.h"
#include "core/bus/messages/map_convert.h"
#include "core/bus/messages/pager.h"
#include "plslam/rectified_camera_t.hpp"

namespace plslam::bus {
namespace {

constexpr int32_t kMaxMapPages = 1'000'000;
/// Limit of each list of an update. A reader's memory for an incomplete update is bounded by the bytes that were sent
/// to it, so this limit only keeps counts from overflowing: no map comes near it.
constexpr size_t kMaxMapEntries = 2'000'000'000;
constexpr size_t kMaxMapWriters = 8;
constexpr size_t kMaxStages = 64;

map_update_t HeadPage(const MapUpdate& update) {
  map_update_t page{};
  page.header.session = update.newest.session.value;
  page.header.t_ns = update.t_ns;
  page.version = update.version;
  page.base_version = update.base_version.value_or(0);
  page.session_keyframe_id = update.newest.number;
  page.committed = update.committed ? 1 : 0;
  page.answer.session = update.answer.keyframe.session.value;
  page.answer.session_keyframe_id = update.answer.keyframe.number;
  page.answer.map_version = ToMessage(update.answer.map_version);
  page.answer.accepted = update.answer.accepted ? 1 : 0;
  page.localise_only = update.localise_only ? 1 : 0;
  page.map_id = ToMessage(update.map_id);
  if (update.camera) page.camera = ToMessage(*update.camera);
  page.totals = ToMessage(update.totals);
  page.adjustment = ToMessage(update.adjustment);
  return page;
}

void AddStages(const MapUpdate& update, map_update_t& page) {
  for (const auto& [name, ms] : update.stage_ms) {
    stage_t& stage = page.stages.emplace_back();
    stage.name = name;
    stage.ms = ms;
  }
  page.n_stages = static_cast<int32_t>(page.stages.size());
}

template <class AnId>
bool AppendRemoved(const std::vector<int64_t>& ids, std::vector<AnId>& to) {
  if (to.size() + ids.size() > kMaxMapEntries) return false;
  for (const AnId id : IdsFrom<AnId>(ids)) {
    if (id <= (to.empty() ? -1 : to.back())) return false;
    to.push_back(id);
  }
  return true;
}

/// Moved or whole.
template <class Message, class Value>
bool AppendKeyframe(const Message& message, std::vector<Value>& to) {
  const auto keyframe = FromMessage(message);
  if (!keyframe || keyframe->id <= (to.empty() ? -1 : to.back().id)) return false;
  to.push_back(*keyframe);
  return true;
}

bool AppendOne(const moved_keyframe_t& message, std::vector<MovedKeyframe>& to) {
  return AppendKeyframe(message, to);
}
bool AppendOne(const map_keyframe_t& message, std::vector<MapKeyframe>& to) { return AppendKeyframe(message, to); }

/// Appends a landmark; one with the id of the previous landmark continues its observations.
template <class Message, class Landmark>
bool AppendOne(const Message& message, std::vector<Landmark>& to) {
  auto landmark = FromMessage(message);
  const LandmarkId last_id = to.empty() ? -1 : to.back().id;
  if (!landmark || landmark->id < last_id) return false;
  if (landmark->id > last_id) {
    to.push_back(std::move(*landmark));
    return true;
  }
  std::vector<Observation>& observations = to.back().observations;
  const bool continues = !landmark->observations.empty() && !observations.empty() &&
                         landmark->observations.front().keyframe_id() > observations.back().keyframe_id();
  if (!continues) return false;
  observations.insert(observations.end(), landmark->observations.begin(), landmark->observations.end());
  return true;
}

bool AppendOne(const loop_edge_t& message, std::vector<LoopEdge>& to) {
  const auto loop = FromMessage(message);
  if (!loop) return false;
  to.push_back(*loop);
  return true;
}

template <class Message, class Value>
bool AppendAll(const std::vector<Message>& messages, std::vector<Value>& to) {
  if (to.size() + messages.size() > kMaxMapEntries) return false;
  return std::all_of(messages.begin(), messages.end(),
                     [&to](const Message& message) { return AppendOne(message, to); });
}

bool Append(const map_update_t& page, MapUpdate& update) {
  return AppendAll(page.moved_keyframes, update.moved_keyframes) &&
         AppendRemoved(page.removed_keyframes, update.removed_keyframes) &&
         AppendRemoved(page.removed_points, update.removed_points) &&
         AppendRemoved(page.removed_lines, update.removed_lines) && AppendAll(page.keyframes, update.keyframes) &&
         AppendAll(page.points, update.points) && AppendAll(page.lines, update.lines) &&
         AppendAll(page.loops, update.loops);
}

using UpdatePager = Pager<map_update_t>;

template <class AnId>
void CutRemoved(const std::vector<AnId>& ids, int32_t map_update_t::*count, std::vector<int64_t> map_update_t::*list,
                UpdatePager& pager) {
  for (const AnId id : ids) {
    map_update_t& page = pager.PageFor(sizeof(id.value));
    (page.*list).push_back(id.value);
    ++(page.*count);
  }
}

template <class Value>
std::string NameOf(const Value& value) {
  return std::to_string(value.id.value);
}
std::string NameOf(const LoopEdge& loop) {
  return fmt::format("from keyframe {} to {}", loop.old_keyframe_id, loop.keyframe_id);
}

/// Encodes values as messages, one after the other; throws if readers would reject one, by the same check.
template <class Value>
class AcceptedMessages {
 public:
  explicit AcceptedMessages(const char* kind) : kind_(kind) {}

  auto Of(const Value& value) {
    auto message = ToMessage(value);
    if (!AppendOne(message, taken_)) {
      throw std::invalid_argument(
          fmt::format("map update: {} {} is invalid: numbers are not finite, or ids, keyframes or observations are "
                      "not in ascending order",
                      kind_, NameOf(value)));
    }
    if (taken_.size() > 1) taken_.erase(taken_.begin());
    return message;
  }

 private:
  const char* kind_;
  std::vector<Value> taken_;  // the last one
};

template <class Value, class Message>
void CutValues(const char* kind, const std::vector<Value>& values, int32_t map_update_t::*count,
               std::vector<Message> map_update_t::*list, UpdatePager& pager) {
  AcceptedMessages<Value> messages(kind);
  for (const Value& value : values) {
    const Message message = messages.Of(value);
    map_update_t& page = pager.PageFor(message._getEncodedSizeNoHash());
    (page.*list).push_back(message);
    ++(page.*count);
  }
}

template <class Landmark, class Message>
void CutLandmarks(const char* kind, const std::vector<Landmark>& landmarks, int32_t map_update_t::*count,
                  std::vector<Message> map_update_t::*list, UpdatePager& pager) {
  static constexpr int64_t kObservationBytes = 12;
  const auto add = [&](Message message) {
    map_update_t& page = pager.PageFor(message._getEncodedSizeNoHash());
    (page.*list).push_back(std::move(message));
    ++(page.*count);
  };
  AcceptedMessages<Landmark> messages(kind);
  for (const Landmark& landmark : landmarks) {
    Message rest = messages.Of(landmark);
    // If a page cannot hold all observations, they are divided among several entries.
    while (rest._getEncodedSizeNoHash() > pager.room()) {
      Message part = rest;
      const int64_t excess = rest._getEncodedSizeNoHash() - pager.room();
      const int64_t n = rest.n_observations - (excess + kObservationBytes - 1) / kObservationBytes;
      if (n <= 0) break;  // the pager throws the error
      part.n_observations = static_cast<int32_t>(n);
      part.observations.resize(static_cast<size_t>(n));
      rest.observations.erase(rest.observations.begin(), rest.observations.begin() + n);
      rest.n_observations -= part.n_observations;
      add(std::move(part));
    }
    add(std::move(rest));
  }
}

bool SameHead(const map_update_t& page, const MapUpdate& update) {
  return page.version == update.version && page.base_version == update.base_version.value_or(0) &&
         SessionId(page.header.session) == update.newest.session &&
         page.session_keyframe_id == update.newest.number && (page.committed != 0) == update.committed;
}

}  // namespace

std::optional<MapUpdate> HeadOf(const map_update_t& page) {
  const auto totals = FromMessage(page.totals);
  const auto adjustment = FromMessage(page.adjustment);
  const bool numbers_ok = page.version >= 1 && page.base_version >= 0 && page.base_version < page.version &&
                          page.session_keyframe_id >= -1 && page.stages.size() <= kMaxStages &&
                          (page.committed == 0 || page.committed == 1) && page.answer.session_keyframe_id >= -1 &&
                          (page.answer.accepted == 0 || page.answer.accepted == 1) &&
                          (page.localise_only == 0 || page.localise_only == 1);
  const auto map_id = FromMessage(page.map_id);
  MapUpdate update;
  const bool answer_ok = FromMessage(page.answer.map_version, update.answer.map_version);
  const auto camera = FromMessage(page.camera);
  const bool camera_ok = camera || page.camera.f_px == 0.0;
  if (!totals || !adjustment || !numbers_ok || !camera_ok || !map_id || !answer_ok) return std::nullopt;
  update.source = SourceId(page.header.source);
  update.version = page.version;
  if (page.base_version > 0) update.base_version = page.base_version;
  update.newest = {SessionId(page.header.session), page.session_keyframe_id};
  update.t_ns = page.header.t_ns;
  update.committed = page.committed != 0;
  update.answer.keyframe = {SessionId(page.answer.session), page.answer.session_keyframe_id};
  update.answer.accepted = page.answer.accepted != 0;
  update.localise_only = page.localise_only != 0;
  update.map_id = *map_id;
  update.camera = camera;
  update.totals = *totals;
  update.adjustment = *adjustment;
  for (const stage_t& stage : page.stages) {
    if (!std::isfinite(stage.ms)) return std::nullopt;
    update.stage_ms.emplace_back(stage.name, stage.ms);
  }
  return update;
}

std::vector<map_update_t> CutIntoPages(const MapUpdate& update, int64_t page_bytes) {
  const map_update_t head = HeadPage(update);
  map_update_t first = head;
  AddStages(update, first);
  if (!HeadOf(first)) {
    throw std::invalid_argument(fmt::format("map update: version {} on {}: its header has invalid numbers",
                                            update.version, update.base_version.value_or(0)));
  }
  UpdatePager pager(std::move(first), head, page_bytes, "the map");
  CutValues("moved keyframe", update.moved_keyframes, &map_update_t::n_moved_keyframes,
            &map_update_t::moved_keyframes, pager);
  CutRemoved(update.removed_keyframes, &map_update_t::n_removed_keyframes, &map_update_t::removed_keyframes, pager);
  CutRemoved(update.removed_points, &map_update_t::n_removed_points, &map_update_t::removed_points, pager);
  CutRemoved(update.removed_lines, &map_update_t::n_removed_lines, &map_update_t::removed_lines, pager);
  CutValues("keyframe", update.keyframes, &map_update_t::n_keyframes, &map_update_t::keyframes, pager);
  CutLandmarks("point", update.points, &map_update_t::n_points, &map_update_t::points, pager);
  CutLandmarks("line", update.lines, &map_update_t::n_lines, &map_update_t::lines, pager);
  CutValues("loop", update.loops, &map_update_t::n_loops, &map_update_t::loops, pager);
  return pager.Finish();
}

MapUpdateAssembler::MapUpdateAssembler()
    : PageAssembler({.head = HeadOf,
                     .same_head = SameHead,
                     .append = Append,
                     .max_pages = kMaxMapPages,
                     .max_publishers = kMaxMapWriters}) {}

}  // namespace plslam::bus
