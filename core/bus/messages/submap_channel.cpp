// SPDX-License-Identifier: BSD-3-Clause
#include "core/bus/messages/submap_channel.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/bus/channels.h"
#include "core/bus/messages/convert.h"

namespace plslam::bus {
namespace {

constexpr int kMostSubmaps = 1'000'000;
constexpr size_t kMostPoints = 20'000'000;
// As many points as cells of the smallest obstacle of the grid.
constexpr size_t kLeastSurface_points = 10;

submap_t HeadPage(const SubmapMessage& message) {
  submap_t page{};
  page.surfaces = message.surfaces.second;
  page.submap = message.number;
  page.anchor_session = message.submap.anchor_session.value;
  page.anchor_frame_id = message.submap.anchor_frame_id.value;
  page.T_w_anchor = ToMessage(message.submap.T_w_anchor);
  page.voxel_m = message.voxel_m;
  page.only_moved = message.only_moved ? 1 : 0;
  return page;
}

std::optional<SubmapMessage> Head(const submap_t& page) {
  const std::optional<SE3> T_w_anchor = FromMessage(page.T_w_anchor);
  const bool valid = T_w_anchor && page.submap >= 0 && page.submap < kMostSubmaps && page.anchor_frame_id >= 0 &&
                     page.voxel_m > 0.0 && std::isfinite(page.voxel_m) &&
                     (page.only_moved == 0 || page.only_moved == 1);
  if (!valid) return std::nullopt;
  return SubmapMessage{{page.header.source, page.surfaces},
                       page.submap,
                       page.voxel_m,
                       page.only_moved != 0,
                       {SessionId(page.anchor_session), FrameId(page.anchor_frame_id), *T_w_anchor, {}}};
}

bool SameHead(const submap_t& page, const SubmapMessage& message) {
  return page.surfaces == message.surfaces.second && page.submap == message.number &&
         (page.only_moved != 0) == message.only_moved;
}

bool Append(const submap_t& page, SubmapMessage& message) {
  std::vector<SurfacePoint>& points = message.submap.points;
  if (points.size() + page.points.size() > kMostPoints) return false;
  for (const surface_point_t& from : page.points) {
    SurfacePoint point{{from.x_m, from.y_m, from.z_m}, {}, from.grey};
    std::ranges::copy(from.normal, point.normal.begin());
    if (!point.p.allFinite()) return false;
    points.push_back(point);
  }
  return true;
}

surface_point_t ToMessage(const SurfacePoint& point) {
  surface_point_t message{};
  message.x_m = point.p.x();
  message.y_m = point.p.y();
  message.z_m = point.p.z();
  std::ranges::copy(point.normal, message.normal);
  message.grey = point.grey;
  return message;
}

bool IsSamePose(const SE3& a, const SE3& b) {
  return a.rotation().coeffs() == b.rotation().coeffs() && a.translation() == b.translation();
}

bool HasSameAnchor(const SubmapCloud& a, const SubmapCloud& b) {
  return a.anchor_session == b.anchor_session && a.anchor_frame_id == b.anchor_frame_id;
}

}  // namespace

std::vector<submap_t> CutIntoPages(const SubmapMessage& message, int64_t page_bytes) {
  const submap_t head = HeadPage(message);
  Pager<submap_t> pager(head, head, page_bytes, "submaps");
  for (const SurfacePoint& point : message.submap.points) {
    const surface_point_t to = ToMessage(point);
    submap_t& page = pager.PageFor(to._getEncodedSizeNoHash());
    page.points.push_back(to);
    ++page.n_points;
  }
  return pager.Finish();
}

SubmapAssembler::SubmapAssembler() : PageAssembler({.head = Head, .same_head = SameHead, .append = Append}) {}

void SubmapPublisher::Publish(const SurfaceCloud& cloud, Changes changes) {
  for (const auto& [number, submap] : cloud.submaps) {
    const auto before = published_.submaps.find(number);
    const bool is_new = before == published_.submaps.end() || !HasSameAnchor(before->second, submap);
    const bool has_new_points =
        is_new || (changes == Changes::kAll
                       ? before->second.points != submap.points
                       : HasOtherSurfaces(before->second.points, submap.points, cloud.voxel_m, kLeastSurface_points));
    if (!has_new_points && IsSamePose(before->second.T_w_anchor, submap.T_w_anchor)) continue;
    SubmapMessage message{{0, number_}, number, cloud.voxel_m, !has_new_points, submap};
    SubmapCloud& published = published_.submaps[number];
    if (has_new_points) {
      published = submap;
    } else {
      published.T_w_anchor = submap.T_w_anchor;
      message.submap.points.clear();
    }
    Send(message);
  }
  // Submaps without a place in the map any more.
  for (auto& [number, submap] : published_.submaps) {
    if (cloud.submaps.contains(number) || submap.points.empty()) continue;
    submap.points.clear();
    Send({{0, number_}, number, cloud.voxel_m, false, submap});
  }
}

void SubmapPublisher::Send(const SubmapMessage& message) {
  for (submap_t& page : CutIntoPages(message, bus_.page_bytes())) bus_.Publish(kSubmap, std::move(page));
  ++n_submaps_;
}

void SubmapPublisher::Replace() {
  if (published_.submaps.empty()) return;
  ++number_;
  published_ = {};
}

SubmapSubscriber::SubmapSubscriber(Bus& bus, std::function<void()> handler) {
  subscription_ = SubscribePaged<submap_t, SubmapAssembler, SubmapMessage>(
      bus, kSubmap, [this, &bus, handler = std::move(handler)](const SubmapMessage& message) {
        if (!received_.Add(message.surfaces.first)) return;
        if (!Take(message)) return bus.CountRejected();
        handler();
      });
}

bool SubmapSubscriber::Take(SubmapMessage message) {
  const bool continues = message.surfaces == surfaces_;
  if (message.only_moved) {
    const auto found = cloud_.submaps.find(message.number);
    if (!continues || found == cloud_.submaps.end()) return false;
    found->second.T_w_anchor = message.submap.T_w_anchor;
    return true;
  }
  if (!continues) cloud_ = {};
  surfaces_ = message.surfaces;
  cloud_.voxel_m = message.voxel_m;
  cloud_.submaps[message.number] = std::move(message.submap);
  return true;
}

}  // namespace plslam::bus
