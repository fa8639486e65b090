// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "core/bus/messages/map_pages.h"
#include "plslam/map_update_t.hpp"
#include "tests/unit/map/random_map.h"

namespace plslam::bus::test {

/// All pages of an update, byte for byte: equal for equal maps.
inline std::vector<uint8_t> EncodedMap(const MapUpdate& update) {
  std::vector<uint8_t> all;
  for (const map_update_t& page : CutIntoPages(update, 60'000)) {
    const size_t begin = all.size();
    all.resize(begin + static_cast<size_t>(page.getEncodedSize()));
    page.encode(all.data(), static_cast<int>(begin), page.getEncodedSize());
  }
  return all;
}

inline std::vector<uint8_t> EncodedMap(const Map& map) {
  MapUpdate update = WholeMap(map);
  update.version = 1;
  return EncodedMap(update);
}

/// Owner of a map to which everything happens: its versions, one after another.
class MapOwner {
 public:
  explicit MapOwner(uint64_t seed) : random_(seed) {}

  MapUpdate Next(int steps) {
    random_.Steps(steps);
    MapUpdate update = ChangedPart(random_.map(), random_.map().TakeChanges());
    update.Follow(version_++);
    return update;
  }

  MapUpdate Whole() const {
    MapUpdate update = WholeMap(random_.map());
    update.version = version_;
    return update;
  }

  const Map& map() const { return random_.map(); }
  int64_t version() const { return version_; }

 private:
  plslam::test::RandomMap random_;
  int64_t version_ = 0;
};

}  // namespace plslam::bus::test
