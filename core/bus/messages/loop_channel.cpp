// SPDX-License-Identifier: BSD-3-Clause
#include "core/bus/messages/loop_channel.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "core/bus/messages/convert.h"
#include "core/bus/messages/map_convert.h"
#include "core/bus/messages/pager.h"

namespace plslam::bus {
namespace {

using bus::ToMessage;

constexpr size_t kMaxClosureEntries = 2'000'000;

loop_closure_t HeadPage(const LoopClosure& closure) {
  loop_closure_t page{};
  page.header.session = closure.keyframe.session.value;
  page.header.t_ns = closure.t_ns;
  page.kind = static_cast<int8_t>(closure.kind);
  page.more = closure.more ? 1 : 0;
  page.session_keyframe_id = closure.keyframe.number;
  page.map_version = ToMessage(closure.map_version);
  page.score = closure.score;
  page.detect_ms = closure.detect_ms;
  page.correct_ms = closure.correct_ms;
  return page;
}

std::optional<LoopClosure> Head(const loop_closure_t& page) {
  const bool numbers_ok =
      std::isfinite(page.score) && std::isfinite(page.detect_ms) && std::isfinite(page.correct_ms);
  const bool ids_ok =
      page.kind >= 0 && page.kind <= 2 && (page.more == 0 || page.more == 1) && page.session_keyframe_id >= 0;
  LoopClosure closure;
  const bool version_ok = FromMessage(page.map_version, closure.map_version);
  if (!numbers_ok || !ids_ok || !version_ok) return std::nullopt;
  closure.source = SourceId(page.header.source);
  closure.kind = static_cast<LoopClosure::Kind>(page.kind);
  closure.keyframe = {SessionId(page.header.session), page.session_keyframe_id};
  closure.t_ns = page.header.t_ns;
  closure.more = page.more != 0;
  closure.score = page.score;
  closure.detect_ms = page.detect_ms;
  closure.correct_ms = page.correct_ms;
  return closure;
}

bool SameHead(const loop_closure_t& page, const LoopClosure& closure) {
  std::optional<MapVersion> version;
  return KeyframeName{SessionId(page.header.session), page.session_keyframe_id} == closure.keyframe &&
         page.kind == static_cast<int8_t>(closure.kind) && FromMessage(page.map_version, version) &&
         version == closure.map_version;
}

same_landmarks_t ToMessage(const SameLandmarks& same) {
  same_landmarks_t message{};
  message.a = same.a.value;
  message.b = same.b.value;
  return message;
}

corrected_pose_t ToMessage(const CorrectedPose& pose) {
  corrected_pose_t message{};
  message.keyframe_id = pose.keyframe_id.value;
  message.T_w_kf = bus::ToMessage(pose.T_w_kf);
  return message;
}

keyframe_name_t ToMessage(const NamedKeyframe& keyframe) {
  keyframe_name_t message{};
  message.keyframe_id = keyframe.keyframe_id.value;
  message.session = keyframe.name.session.value;
  message.session_keyframe_id = keyframe.name.number;
  return message;
}

bool AppendEdges(const std::vector<loop_edge_t>& messages, std::vector<LoopEdge>& to) {
  if (to.size() + messages.size() > kMaxClosureEntries) return false;
  for (const loop_edge_t& message : messages) {
    const auto edge = FromMessage(message);
    if (!edge) return false;
    to.push_back(*edge);
  }
  return true;
}

bool AppendSame(const std::vector<same_landmarks_t>& messages, std::vector<SameLandmarks>& to) {
  if (to.size() + messages.size() > kMaxClosureEntries) return false;
  for (const same_landmarks_t& message : messages) {
    if (message.a < 0 || message.b < 0 || message.a == message.b) return false;
    to.push_back({LandmarkId(message.a), LandmarkId(message.b)});
  }
  return true;
}

bool AppendPoses(const std::vector<corrected_pose_t>& messages, std::vector<CorrectedPose>& to) {
  if (to.size() + messages.size() > kMaxClosureEntries) return false;
  for (const corrected_pose_t& message : messages) {
    const auto T_w_kf = FromMessage(message.T_w_kf);
    const KeyframeId keyframe_id(message.keyframe_id);
    if (!T_w_kf || keyframe_id <= (to.empty() ? -1 : to.back().keyframe_id)) return false;
    to.push_back({keyframe_id, *T_w_kf});
  }
  return true;
}

bool AppendNames(const std::vector<keyframe_name_t>& messages, std::vector<NamedKeyframe>& to) {
  if (to.size() + messages.size() > kMaxClosureEntries) return false;
  for (const keyframe_name_t& message : messages) {
    const KeyframeId keyframe_id(message.keyframe_id);
    const bool ascends = keyframe_id > (to.empty() ? -1 : to.back().keyframe_id);
    if (!ascends || message.session_keyframe_id < 0) return false;
    to.push_back({keyframe_id, {SessionId(message.session), message.session_keyframe_id}});
  }
  return true;
}

bool Append(const loop_closure_t& page, LoopClosure& closure) {
  return AppendEdges(page.edges, closure.edges) && AppendSame(page.points, closure.points) &&
         AppendSame(page.lines, closure.lines) && AppendPoses(page.poses, closure.poses) &&
         AppendNames(page.names, closure.names);
}

template <class Value, class Message>
void Cut(const std::vector<Value>& values, int32_t loop_closure_t::*count, std::vector<Message> loop_closure_t::*list,
         Pager<loop_closure_t>& pager) {
  for (const Value& value : values) {
    const Message message = ToMessage(value);
    loop_closure_t& page = pager.PageFor(message._getEncodedSizeNoHash());
    (page.*list).push_back(message);
    ++(page.*count);
  }
}

// By the very code that readers run.
void Check(const std::vector<loop_closure_t>& pages, const LoopClosure& closure) {
  LoopClosure read;
  for (const loop_closure_t& page : pages) {
    if (Head(page) && Append(page, read)) continue;
    throw std::invalid_argument(fmt::format(
        "loop closure of keyframe {}: invalid: numbers are not finite, or keyframes are not in ascending order",
        closure.keyframe.number));
  }
}

}  // namespace

std::vector<loop_closure_t> CutIntoPages(const LoopClosure& closure, int64_t page_bytes) {
  const loop_closure_t head = HeadPage(closure);
  Pager<loop_closure_t> pager(head, head, page_bytes, "loop closures");
  Cut(closure.edges, &loop_closure_t::n_edges, &loop_closure_t::edges, pager);
  Cut(closure.points, &loop_closure_t::n_points, &loop_closure_t::points, pager);
  Cut(closure.lines, &loop_closure_t::n_lines, &loop_closure_t::lines, pager);
  Cut(closure.poses, &loop_closure_t::n_poses, &loop_closure_t::poses, pager);
  Cut(closure.names, &loop_closure_t::n_names, &loop_closure_t::names, pager);
  std::vector<loop_closure_t> pages = pager.Finish();
  Check(pages, closure);
  return pages;
}

LoopClosureAssembler::LoopClosureAssembler()
    : PageAssembler({.head = Head, .same_head = SameHead, .append = Append}) {}

void LoopClosurePublisher::Publish(const LoopClosure& closure) {
  std::vector<loop_closure_t> pages = CutIntoPages(closure, bus_.page_bytes());
  const std::lock_guard lock(publishing_);
  for (loop_closure_t& page : pages) bus_.Publish(kLoopClosure, std::move(page));
}

LoopClosureSubscriber::LoopClosureSubscriber(Bus& bus, std::function<void(const LoopClosure&)> handler)
    : subscription_(
          SubscribePaged<loop_closure_t, LoopClosureAssembler, LoopClosure>(bus, kLoopClosure, std::move(handler))) {}

relocalisation_t ToMessage(const Relocalisation& relocalisation) {
  relocalisation_t message{};
  message.header.session = relocalisation.session.value;
  message.header.t_ns = relocalisation.t_ns;
  message.frame_id = relocalisation.frame_id.value;
  message.found = relocalisation.found ? 1 : 0;
  message.map_version = ToMessage(relocalisation.map_version);
  message.keyframe_id = relocalisation.keyframe_id.value;
  message.T_w_c = ToMessage(relocalisation.T_w_c);
  ToArray(relocalisation.covariance, message.covariance);
  message.n_points = relocalisation.n_points;
  message.n_lines = relocalisation.n_lines;
  return message;
}

std::optional<Relocalisation> FromMessage(const relocalisation_t& message) {
  const auto T_w_c = FromMessage(message.T_w_c);
  const auto covariance = FromArray(message.covariance);
  Relocalisation relocalisation;
  const bool ok = T_w_c && covariance && message.frame_id >= 0 && (message.found == 0 || message.found == 1) &&
                  message.keyframe_id >= -1 && message.n_points >= 0 && message.n_lines >= 0 &&
                  FromMessage(message.map_version, relocalisation.map_version);
  if (!ok) return std::nullopt;
  relocalisation.source = SourceId(message.header.source);
  relocalisation.session = SessionId(message.header.session);
  relocalisation.frame_id = FrameId(message.frame_id);
  relocalisation.t_ns = message.header.t_ns;
  relocalisation.found = message.found != 0;
  relocalisation.keyframe_id = KeyframeId(message.keyframe_id);
  relocalisation.T_w_c = *T_w_c;
  relocalisation.covariance = *covariance;
  relocalisation.n_points = message.n_points;
  relocalisation.n_lines = message.n_lines;
  return relocalisation;
}

}  // namespace plslam::bus
