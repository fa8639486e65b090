#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include "core/map/map_update.h"

namespace plslam {
class map_update_t;
}

namespace plslam::bus {

/// `update` as pages of at most `page_bytes`. Throws std::invalid_argument that names what no reader would take:
/// numbers that are not finite, ids or sights that do not ascend, keyframes older than their parents.
std::vector<map_update_t> CutIntoPages(const MapUpdate& update, int64_t page_bytes);

/// What the head of a page says, without content (stages only from page 0); nullopt where it cannot be.
std::optional<MapUpdate> HeadOf(const map_update_t& page);

/// Puts pages together again; they come in order for each publisher.
class MapUpdateAssembler {
 public:
  /// kPassedOver: goes on with an update whose beginning never came. kNonsense: a page that cannot be (values, order, or
  /// a head that differs from that of the first page); what had come of the update is dropped.
  enum class Outcome { kTaken, kComplete, kPassedOver, kNonsense };

  Outcome Add(const map_update_t& page);
  MapUpdate Take();

 private:
  struct Partial {
    MapUpdate update;
    int32_t next_page = 0;
    int32_t n_pages = 0;
  };

  std::map<int64_t, Partial> partials_;  // by publisher
  std::optional<MapUpdate> complete_;
};

}  // namespace plslam::bus
