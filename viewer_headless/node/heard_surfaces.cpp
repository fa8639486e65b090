// SPDX-License-Identifier: BSD-3-Clause
#include "viewer_headless/node/heard_surfaces.h"

#include "core/process/process_status.h"
#include "core/run/process_names.h"
#include "plslam/counter_t.hpp"
#include "plslam/status_t.hpp"

namespace plslam::viewer {

void HeardSurfaces::OnStatus(const status_t& message) {
  if (message.process != process_name::kDense) return;
  const bool works = message.state == process_state::kStarting || message.state == process_state::kReady ||
                     message.state == process_state::kRunning;
  publisher_ = Publisher{message.header.source, !works, bus::CountOf(message, dense_counter::kTiles),
                         bus::CountOf(message, dense_counter::kSubmaps)};
}

bool HeardSurfaces::MayCome() const {
  if (!publisher_) return false;
  const auto lacks = [this](const bus::ReceivedMessages& received, int64_t n_published) {
    return n_published > received.From(publisher_->source);
  };
  return !publisher_->has_finished || lacks(grid_.received(), publisher_->n_tiles) ||
         lacks(submaps_.received(), publisher_->n_submaps);
}

}  // namespace plslam::viewer
