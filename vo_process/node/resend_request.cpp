// SPDX-License-Identifier: BSD-3-Clause
#include "vo_process/node/resend_request.h"

#include <fmt/format.h>

#include "core/bus/channels.h"
#include "core/bus/run_loop.h"
#include "plslam/command_t.hpp"

namespace plslam::vo {
namespace {

constexpr double kLongest_s = 15.0;

}  // namespace

void ResendRequest::SetPlayer(SourceId source, const std::string& name) {
  player_ = source;
  player_name_ = name;
}

void ResendRequest::Open() { opened_s_ = bus::NowS(); }

void ResendRequest::Send(const TrackerSession& session) {
  if (!is_open()) Open();
  command_t command{};
  command.target = player_name_;
  command.verb = command_verb::kGoBack;
  command.argument = fmt::format("{} {}@{}", player_, session.last_frame_id, session.last_t_ns);
  bus_.Publish(bus::kCommand, command);
}

bool ResendRequest::RepeatOrEnd(const TrackerSession& session) {
  if (!is_open()) return false;
  if (bus::NowS() - *opened_s_ < kLongest_s) {
    Send(session);
    return false;
  }
  End();
  return true;
}

}  // namespace plslam::vo
