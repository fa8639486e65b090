// SPDX-License-Identifier: BSD-3-Clause
#include "viewer_headless/node/heard_streams.h"

#include "core/run/process_names.h"

namespace plslam::viewer {

bool HeardStreams::Add(const stream_t& message) {
  const int64_t stream = message.header.session != 0 ? message.header.session : message.header.source;
  if (!heard_.insert(stream).second) return false;
  lockstep_ = message.pace == stream_pace::kLockstep;
  announced_frames_ = message.n_frames;
  return true;
}

}  // namespace plslam::viewer
