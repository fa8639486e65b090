// SPDX-License-Identifier: BSD-3-Clause
#include "core/map/map_update.h"

#include <utility>

namespace plslam {
namespace {

template <class AnId, class Value>
void Copy(const IdMap<AnId, Value>& from, const std::vector<AnId>& ids, std::vector<Value>& to) {
  to.reserve(ids.size());
  for (const AnId id : ids) to.push_back(from.at(id));
}

template <class AnId, class Value>
void CopyAll(const IdMap<AnId, Value>& from, std::vector<Value>& to) {
  to.reserve(from.size());
  for (const auto& [id, value] : from) to.push_back(value);
}

}  // namespace

MapUpdate ChangedPart(const Map& map, const MapChanges& changes) {
  MapUpdate update;
  update.camera = map.camera();
  update.moved_keyframes = changes.moved_keyframes;
  update.totals = map.Totals();
  Copy(map.keyframes(), changes.keyframes, update.keyframes);
  Copy(map.points(), changes.points, update.points);
  Copy(map.lines(), changes.lines, update.lines);
  update.removed_keyframes = changes.removed_keyframes;
  update.removed_points = changes.removed_points;
  update.removed_lines = changes.removed_lines;
  update.loops = changes.loops;
  return update;
}

MapUpdate WholeMap(const Map& map) {
  MapUpdate update;
  update.camera = map.camera();
  update.totals = map.Totals();
  CopyAll(map.keyframes(), update.keyframes);
  CopyAll(map.points(), update.points);
  CopyAll(map.lines(), update.lines);
  update.loops = map.loops();
  return update;
}

}  // namespace plslam
