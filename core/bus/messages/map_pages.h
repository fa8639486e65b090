// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "core/bus/messages/pager.h"
#include "core/map/map_update.h"
#include "plslam/map_update_t.hpp"

namespace plslam::bus {

/// `update` as pages of at most `page_bytes`. Throws std::invalid_argument that names what no reader would take:
/// numbers that are not finite, ids or observations that do not ascend, keyframes older than their parents.
std::vector<map_update_t> CutIntoPages(const MapUpdate& update, int64_t page_bytes);

/// What the head of a page says, without content (stages only from page 0); nullopt where it cannot be.
std::optional<MapUpdate> HeadOf(const map_update_t& page);

/// Puts updates together again.
class MapUpdateAssembler : public PageAssembler<map_update_t, MapUpdate> {
 public:
  MapUpdateAssembler();
};

}  // namespace plslam::bus
