// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "core/bus/messages/pager.h"
#include "core/map/map_update.h"
#include "plslam/map_update_t.hpp"

namespace plslam::bus {

/// Divides `update` into pages of at most `page_bytes`. Throws std::invalid_argument that names content that readers
/// reject: non-finite numbers, ids or observations that do not ascend, keyframes older than their parents.
std::vector<map_update_t> CutIntoPages(const MapUpdate& update, int64_t page_bytes);

/// Returns the head of a page without content (stages only from page 0); nullopt if it is invalid.
std::optional<MapUpdate> HeadOf(const map_update_t& page);

/// Reassembles updates.
class MapUpdateAssembler : public PageAssembler<map_update_t, MapUpdate> {
 public:
  MapUpdateAssembler();
};

}  // namespace plslam::bus
