// SPDX-License-Identifier: BSD-3-Clause
#include "viewer_headless/report/report_json.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/files/bytes.h"
#include "viewer_headless/report/report_page.h"

namespace plslam::viewer {

std::string ReportSince::Text() const {
  return fmt::format("{}.{}.{}.{}.{}.{}", run, stride, rows, map_version, picture, surfaces);
}

std::optional<ReportSince> ReportSince::Parse(std::string_view text) {
  if (text.empty()) return ReportSince();
  std::array<int64_t, 6> numbers{};
  const char* at = text.data();
  const char* const end = at + text.size();
  for (size_t i = 0; i < numbers.size(); ++i) {
    if (i > 0 && (at == end || *at++ != '.')) return std::nullopt;
    const auto [next, error] = std::from_chars(at, end, numbers[i]);
    if (error != std::errc() || numbers[i] < -1) return std::nullopt;
    at = next;
  }
  if (at != end) return std::nullopt;
  return ReportSince{numbers[0], numbers[1], numbers[2], numbers[3], numbers[4], numbers[5]};
}

namespace {

using Json = nlohmann::ordered_json;

Json ToJson(const Table& table) {
  Json json = Json::object();
  for (const Column& column : table) {
    json[column.name] = {
        {"type", TypeName(column)}, {"width", column.width}, {"data", Base64(LittleEndianBytes(column))}};
  }
  return json;
}

template <class T>
Json OrNull(const std::optional<T>& value) {
  return value ? Json(*value) : Json();
}

template <class Row>
Json ToJson(const std::vector<Row>& rows);

Json ToJson(const ImuFigures& imu) {
  return {{"used_frames", imu.used_frames},
          {"innovation", imu.innovation},
          {"delay_ms", imu.delay ? Json(imu.delay->ms) : Json()},
          {"delay_sigma_ms", imu.delay ? Json(imu.delay->sigma_ms) : Json()},
          {"rate_bias_rad_s", imu.rate_bias_rad_s},
          {"rate_bias_sigma_rad_s", imu.rate_bias_sigma_rad_s},
          {"force_bias_m_s2", imu.force_bias_m_s2},
          {"force_bias_sigma_m_s2", imu.force_bias_sigma_m_s2}};
}

Json ToJson(const RunFacts& f) {
  Json json = {{"dataset", f.dataset},
               {"pace", f.pace},
               {"version", f.version},
               {"finished", f.finished},
               {"announced_frames", f.announced_frames},
               {"frames", f.frames.answered()},
               {"all_frames", f.frames.all()},
               {"tracked_frames", f.frames.tracked},
               {"tracked_percent", OrNull(f.frames.tracked_percent())},
               {"initialising_frames", f.frames.initialising},
               {"lost_frames", f.frames.lost},
               {"skipped_frames", f.frames.skipped},
               {"bad_frames", f.frames.unreadable},
               {"unanswered_frames", f.frames.unanswered},
               {"moving",
                {{"bodies", f.moving.bodies},
                 {"percent", 100.0 * f.moving.largest_share},
                 {"first_frame", f.moving.first_frame.value},
                 {"last_frame", f.moving.last_frame.value}}},
               {"keyframes", f.keyframes},
               {"points", f.points},
               {"lines", f.lines},
               {"loops", f.loops},
               {"duration_s", f.duration_s},
               {"length_m", f.length_m},
               {"ate_m", OrNull(f.ate_m)},
               {"live_ate_m", OrNull(f.live_ate_m)},
               {"warnings", ToJson(f.warnings)},
               {"imu", f.imu ? ToJson(*f.imu) : Json()},
               {"camera", nullptr}};
  if (f.camera) {
    json["camera"] = {{"width_px", f.camera->width_px}, {"height_px", f.camera->height_px},
                      {"f_px", f.camera->f_px},         {"cx_px", f.camera->cx_px},
                      {"cy_px", f.camera->cy_px},       {"baseline_m", f.camera->baseline_m}};
  }
  return json;
}

Json ToJson(const ReportMap& map) {
  return {{"points", ToJson(map.points)},
          {"segments", ToJson(map.segments)},
          {"keyframes", ToJson(map.keyframes)},
          {"edges", ToJson(map.edges)},
          {"loop_edges", ToJson(map.loop_edges)},
          {"vertical",
           {{"up", {map.vertical.up_w.x(), map.vertical.up_w.y(), map.vertical.up_w.z()}},
            {"from", NameOf(map.vertical.source)},
            {"n", map.vertical.n},
            {"sigma_deg", map.vertical.sigma_rad / kRadPerDeg}}},
          {"observers",
           {{"points", Base64(map.observers.points)},
            {"segments", Base64(map.observers.segments)},
            {"only_ids", map.observers.only_ids}}}};
}

Json ToJson(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

Json ToJson(const ReportGrid& grid) {
  const Eigen::Quaterniond& q = grid.T_w_level.rotation();
  return {{"png", Base64(grid.png)},
          {"pixel_m", grid.pixel_m},
          {"width_px", grid.width_px},
          {"height_px", grid.height_px},
          {"corner_level", ToJson(grid.corner_level)},
          {"T_w_level", {{"q_xyzw", {q.x(), q.y(), q.z(), q.w()}}, {"t_m", ToJson(grid.T_w_level.translation())}}}};
}

Json ToJson(const ReportSurfaces& surfaces) {
  return {{"points", ToJson(surfaces.points)},
          {"low_w", ToJson(surfaces.low_w)},
          {"step_m", surfaces.step_m},
          {"spacing_m", surfaces.spacing_m},
          {"grid", surfaces.grid ? ToJson(*surfaces.grid) : Json()}};
}

uint8_t Age(int age) { return static_cast<uint8_t>(std::clamp(age, 0, 255)); }

/// Pixels in 32nds; outside coordinates are moved to the border, since the page clips there anyway.
uint16_t Fixed(float px) { return static_cast<uint16_t>(std::lround(std::clamp(px, 0.0F, 2047.0F) * 32.0F)); }

uint16_t FixedDisparity(float px) { return px < 0.0F ? uint16_t{65535} : Fixed(px); }

bool IsFinite(const cv::Point2f& p) { return std::isfinite(p.x) && std::isfinite(p.y); }

Json ToJson(const OverlayFeatures& features) {
  std::vector<uint16_t> points, segments, segment_disparities;
  std::vector<uint8_t> point_ages, segment_ages;
  for (const OverlayPoint& p : features.points) {
    if (!IsFinite(p.px) || !std::isfinite(p.disparity_px)) continue;
    points.insert(points.end(), {Fixed(p.px.x), Fixed(p.px.y), FixedDisparity(p.disparity_px)});
    point_ages.push_back(Age(p.age));
  }
  for (const OverlaySegment& s : features.segments) {
    if (!IsFinite(s.p_px) || !IsFinite(s.q_px)) continue;
    segments.insert(segments.end(), {Fixed(s.p_px.x), Fixed(s.p_px.y), Fixed(s.q_px.x), Fixed(s.q_px.y)});
    segment_ages.push_back(Age(s.age));
    const auto disparity = [&s](float px) { return FixedDisparity(s.HasDepth() && std::isfinite(px) ? px : -1.0F); };
    segment_disparities.insert(segment_disparities.end(), {disparity(s.disparity_p_px), disparity(s.disparity_q_px)});
  }
  return ToJson(Table{{"points", 3, std::move(points)},
                      {"point_ages", 1, std::move(point_ages)},
                      {"segments", 4, std::move(segments)},
                      {"segment_ages", 1, std::move(segment_ages)},
                      {"segment_disparities", 2, std::move(segment_disparities)}});
}

Json ToJson(const ReportPicture& p) {
  return {{"frame", p.frame_id.value},          {"width_px", p.width_px},
          {"height_px", p.height_px},           {"jpeg", Base64(p.jpeg)},
          {"right_jpeg", Base64(p.right_jpeg)}, {"features", ToJson(p.features)}};
}

Json ToJson(const ReportLoop& l) {
  return {{"old_keyframe", l.old_keyframe_id.value},
          {"keyframe", l.keyframe_id.value},
          {"old_frame", l.old_frame_id.value},
          {"frame", l.frame_id.value},
          {"points", l.n_points},
          {"lines", l.n_lines},
          {"distance_m", l.distance_m},
          {"angle_deg", l.angle_deg},
          {"score", l.score},
          {"detect_ms", l.detect_ms},
          {"correct_ms", l.correct_ms},
          {"moved_m", l.moved_m},
          {"old_jpeg", Base64(l.old_jpeg)},
          {"jpeg", Base64(l.jpeg)}};
}

Json ToJson(const ReportCorrection& c) {
  return {{"frame", c.frame_id.value}, {"moved_m", c.moved_m}, {"table", ToJson(c.table)}};
}

Json ToJson(const ReportProcess& p) {
  return {{"name", p.name},         {"state", p.state},
          {"pace", p.pace},         {"silent_s", p.silent_s},
          {"queue", p.queue},       {"lag_frames", p.lag_frames < 0 ? Json() : Json(p.lag_frames)},
          {"restarts", p.restarts}, {"table", ToJson(p.table)}};
}

template <class Row>
Json ToJson(const std::vector<Row>& rows) {
  Json json = Json::array();
  for (const Row& row : rows) json.push_back(ToJson(row));
  return json;
}

}  // namespace

std::string ReportJson(const ReportData& data) {
  Json json = {{"facts", ToJson(data.facts)},
               {"next", data.next},
               {"whole", data.whole},
               {"stage_names", data.stage_names},
               {"map_stage_names", data.map_stage_names},
               {"first_row", data.first_row},
               {"frames", ToJson(data.frames)},
               {"path", data.path ? ToJson(*data.path) : Json()},
               {"map", data.map ? ToJson(*data.map) : Json()},
               {"surfaces", data.surfaces ? ToJson(*data.surfaces) : Json()},
               {"map_times", ToJson(data.map_times)},
               {"loops", ToJson(data.loops)},
               {"corrections", ToJson(data.corrections)},
               {"processes", ToJson(data.processes)},
               {"pictures", ToJson(data.pictures)},
               {"notes", data.notes}};
  std::string text = json.dump(-1, ' ', false, Json::error_handler_t::replace);
  json = {};  // as much memory as the text
  return SafeInPage(std::move(text));
}

}  // namespace plslam::viewer
