// SPDX-License-Identifier: BSD-3-Clause
#include "core/bus/messages/keyframe_channel.h"

#include <stdexcept>
#include <utility>

#include "core/bus/messages/convert.h"
#include "core/bus/messages/imu_channel.h"
#include "core/bus/messages/map_convert.h"
#include "core/bus/messages/pager.h"
#include "plslam/imu_interval_t.hpp"
#include "plslam/imu_sample_t.hpp"
#include "plslam/keyframe_t.hpp"
#include "plslam/rectified_camera_t.hpp"

namespace plslam::bus {
namespace {

constexpr int32_t kMaxKeyframePages = 4096;
constexpr size_t kMaxFeatures = 200'000;
constexpr size_t kMaxKeyframePublishers = 64;
constexpr size_t kMaxImuSamples = 100'000;

keyframe_t HeadPage(const Keyframe& keyframe) {
  keyframe_t page{};
  page.header.session = keyframe.name.session.value;
  page.header.t_ns = keyframe.t_ns;
  page.keyframe_id = keyframe.name.number;
  page.frame_id = keyframe.frame_id.value;
  page.previous_keyframe_id = keyframe.previous_keyframe_id;
  page.map_id = ToMessage(keyframe.map_id);
  page.T_prevkf_kf = ToMessage(keyframe.T_prevkf_kf);
  ToArray(keyframe.covariance, page.covariance);
  page.T_odom_kf = ToMessage(keyframe.T_odom_kf);
  ToArray(keyframe.up, page.up_kf, page.up_sigma_rad);
  page.imu = ToMessage(keyframe.inertial);
  page.state = static_cast<int8_t>(keyframe.state);
  page.lockstep = keyframe.lockstep ? 1 : 0;
  page.camera = ToMessage(keyframe.camera);
  return page;
}

withdrawn_t ToMessage(const Withdrawn& landmark) {
  withdrawn_t message;
  message.landmark_id = landmark.landmark_id.value;
  message.map_id = landmark.map_id.value;
  return message;
}

bool AsMany(const std::vector<TrackId>& ids, const std::vector<LandmarkId>& map_ids, size_t n) {
  return ids.size() == n && (map_ids.empty() || map_ids.size() == n);
}

LandmarkId LandmarkOfMap(const std::vector<LandmarkId>& ids, size_t i) { return ids.empty() ? -1 : ids[i]; }

std::optional<Keyframe> Head(const keyframe_t& page) {
  const auto T_prevkf_kf = FromMessage(page.T_prevkf_kf);
  const auto covariance = FromArray(page.covariance);
  const auto T_odom_kf = FromMessage(page.T_odom_kf);
  const bool ids_ok = page.keyframe_id >= 0 && page.frame_id >= 0 && page.previous_keyframe_id >= -1 &&
                      page.previous_keyframe_id < page.keyframe_id && page.state >= 0 && page.state <= 4 &&
                      (page.lockstep == 0 || page.lockstep == 1);
  const auto map_id = FromMessage(page.map_id);
  const auto camera = FromMessage(page.camera);
  Keyframe keyframe;
  const bool up_ok = FromArray(page.up_kf, page.up_sigma_rad, keyframe.up);
  if (!T_prevkf_kf || !covariance || !T_odom_kf || !up_ok || !camera || !map_id || !ids_ok) return std::nullopt;
  const auto inertial = FromMessage(page.imu);
  if (!inertial) return std::nullopt;
  keyframe.inertial = *inertial;
  keyframe.source = SourceId(page.header.source);
  keyframe.name.session = SessionId(page.header.session);
  keyframe.t_ns = page.header.t_ns;
  keyframe.name.number = page.keyframe_id;
  keyframe.frame_id = FrameId(page.frame_id);
  keyframe.previous_keyframe_id = page.previous_keyframe_id;
  keyframe.map_id = *map_id;
  keyframe.T_prevkf_kf = *T_prevkf_kf;
  keyframe.covariance = *covariance;
  keyframe.T_odom_kf = *T_odom_kf;
  keyframe.state = static_cast<uint8_t>(page.state);
  keyframe.lockstep = page.lockstep != 0;
  keyframe.camera = *camera;
  return keyframe;
}

bool SameHead(const keyframe_t& page, const Keyframe& keyframe) {
  return page.keyframe_id == keyframe.name.number && page.header.session == keyframe.name.session.value;
}

bool Append(const std::vector<withdrawn_t>& messages, std::vector<Withdrawn>& withdrawn) {
  if (withdrawn.size() + messages.size() > kMaxFeatures) return false;
  for (const withdrawn_t& message : messages)
    withdrawn.push_back({TrackId(message.landmark_id), LandmarkId(message.map_id)});
  return true;
}

bool Append(const keyframe_t& page, Keyframe& keyframe) {
  StereoFeatures& features = keyframe.features;
  if (features.points.size() + page.points.size() > kMaxFeatures) return false;
  if (features.lines.size() + page.lines.size() > kMaxFeatures) return false;
  if (keyframe.inertial.samples.size() + page.imu_samples.size() > kMaxImuSamples) return false;
  for (const imu_sample_t& message : page.imu_samples) {
    if (!AppendTo(keyframe.inertial.samples, message)) return false;
  }
  for (const point_feature_t& message : page.points) {
    auto point = FromMessage(message);
    if (!point) return false;
    features.points.push_back(*point);
    keyframe.point_landmark_ids.push_back(TrackId(message.landmark_id));
    keyframe.point_map_ids.push_back(LandmarkId(message.map_id));
  }
  for (const line_feature_t& message : page.lines) {
    auto line = FromMessage(message);
    if (!line) return false;
    features.lines.push_back(*line);
    keyframe.line_landmark_ids.push_back(TrackId(message.landmark_id));
    keyframe.line_map_ids.push_back(LandmarkId(message.map_id));
  }
  return Append(page.withdrawn_points, keyframe.withdrawn_points) &&
         Append(page.withdrawn_lines, keyframe.withdrawn_lines);
}

}  // namespace

std::vector<keyframe_t> CutIntoPages(const Keyframe& keyframe, int64_t page_bytes) {
  const StereoFeatures& features = keyframe.features;
  if (!AsMany(keyframe.point_landmark_ids, keyframe.point_map_ids, features.points.size()) ||
      !AsMany(keyframe.line_landmark_ids, keyframe.line_map_ids, features.lines.size())) {
    throw std::invalid_argument("keyframe " + std::to_string(keyframe.name.number) +
                                ": the numbers of landmark ids and features differ");
  }
  const keyframe_t head = HeadPage(keyframe);
  Pager<keyframe_t> pager(head, head, page_bytes, "keyframes");
  for (size_t i = 0; i < features.points.size(); ++i) {
    const point_feature_t point =
        ToMessage(features.points[i], keyframe.point_landmark_ids[i], LandmarkOfMap(keyframe.point_map_ids, i));
    keyframe_t& page = pager.PageFor(point._getEncodedSizeNoHash());
    page.points.push_back(point);
    ++page.n_points;
  }
  for (size_t i = 0; i < features.lines.size(); ++i) {
    const line_feature_t line =
        ToMessage(features.lines[i], keyframe.line_landmark_ids[i], LandmarkOfMap(keyframe.line_map_ids, i));
    keyframe_t& page = pager.PageFor(line._getEncodedSizeNoHash());
    page.lines.push_back(line);
    ++page.n_lines;
  }
  for (const ImuSample& sample : keyframe.inertial.samples) {
    const imu_sample_t message = ToMessage(sample);
    keyframe_t& page = pager.PageFor(message._getEncodedSizeNoHash());
    page.imu_samples.push_back(message);
    ++page.n_imu_samples;
  }
  for (const Withdrawn& landmark : keyframe.withdrawn_points) {
    const withdrawn_t withdrawn = ToMessage(landmark);
    keyframe_t& page = pager.PageFor(withdrawn._getEncodedSizeNoHash());
    page.withdrawn_points.push_back(withdrawn);
    ++page.n_withdrawn_points;
  }
  for (const Withdrawn& landmark : keyframe.withdrawn_lines) {
    const withdrawn_t withdrawn = ToMessage(landmark);
    keyframe_t& page = pager.PageFor(withdrawn._getEncodedSizeNoHash());
    page.withdrawn_lines.push_back(withdrawn);
    ++page.n_withdrawn_lines;
  }
  return pager.Finish();
}

KeyframeAssembler::KeyframeAssembler()
    : PageAssembler({.head = Head,
                     .same_head = SameHead,
                     .append = Append,
                     .max_pages = kMaxKeyframePages,
                     .max_publishers = kMaxKeyframePublishers}) {}

void KeyframePublisher::Publish(const Keyframe& keyframe) {
  for (keyframe_t& page : CutIntoPages(keyframe, bus_.page_bytes())) bus_.Publish(channel_, std::move(page));
}

KeyframeSubscriber::KeyframeSubscriber(Bus& bus, std::function<void(const Keyframe&)> handler, const Channel& channel)
    : subscription_(SubscribePaged<keyframe_t, KeyframeAssembler, Keyframe>(bus, channel, std::move(handler))) {}

}  // namespace plslam::bus
