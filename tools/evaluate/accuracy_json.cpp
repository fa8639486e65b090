// SPDX-License-Identifier: BSD-3-Clause
#include "tools/evaluate/accuracy.h"

#include <cmath>

namespace plslam {
namespace {

using Json = nlohmann::ordered_json;

Json StatisticsJson(const Statistics& s) {
  return {{"n", s.n}, {"rmse", s.rmse}, {"mean", s.mean}, {"median", s.median}, {"max", s.max}};
}

Json RelativeJson(const RelativeErrorSummary& r) {
  return {{"delta", DeltaText(r.delta)},
          {"translation_m", StatisticsJson(r.translation_m)},
          {"rotation_deg", StatisticsJson(r.rotation_deg)}};
}

Json KittiJson(const KittiErrors& errors) {
  Json rows = Json::array();
  for (const KittiLengthError& row : errors.lengths) {
    rows.push_back({{"length_m", row.length_m},
                    {"segments", row.segments},
                    {"t_rel_percent", row.t_rel_percent},
                    {"r_rel_deg_per_100m", row.r_rel_deg_per_100m}});
  }
  return {{"segments", errors.segments},
          {"t_rel_percent", errors.t_rel_percent},
          {"r_rel_deg_per_100m", errors.r_rel_deg_per_100m},
          {"lengths", rows}};
}

Json KeyframesJson(const KeyframeErrors& e) {
  return {{"motions", e.motions},
          {"rmse_m", e.rmse_m},
          {"rmse_deg", e.rmse_deg},
          {"moving", e.moving},
          {"relative_rmse", e.relative_rmse},
          {"t_rel_percent", e.t_rel_percent},
          {"R_rel_deg_per_100m", e.R_rel_deg_per_100m}};
}

Json ConsistencyJson(const Consistency& c) {
  return {{"n", c.n},
          {"singular", c.singular},
          {"mean", c.mean_nees},
          {"expected", 6},
          {"bounds_95", {c.lower_bound, c.upper_bound}},
          {"above_95_percent", c.above_95_percent}};
}

Json AlignmentJson(const Accuracy& a) {
  const Eigen::Vector3d& t = a.alignment.T_a_b.translation();
  const Eigen::Quaterniond& q = a.alignment.T_a_b.rotation();
  return {{"kind", AlignmentName(a.alignment_kind)},
          {"scale", a.alignment.scale},
          {"translation_m", {t.x(), t.y(), t.z()}},
          {"q_wxyz", {q.w(), q.x(), q.y(), q.z()}}};
}

/// A JSON file would have null for them anyway; who reads the object is to see the same.
void NullWhatIsNotFinite(Json& json) {
  if (json.is_number_float() && !std::isfinite(json.get<double>())) json = nullptr;
  if (json.is_structured()) {
    for (Json& member : json) NullWhatIsNotFinite(member);
  }
}

}  // namespace

nlohmann::ordered_json ToJson(const Accuracy& a) {
  Json json{{"ate_m", a.pairs.empty() ? Json(nullptr) : Json(a.ate_m.rmse)},
            {"coverage_percent", a.coverage_percent},
            {"poses", {{"estimated", a.estimated_poses}, {"true", a.true_poses}, {"associated", a.pairs.size()}}},
            {"true_path_m", a.true_path_m},
            {"true_spread_m", a.true_spread_m},
            {"duration_s", a.duration_s},
            {"alignment", AlignmentJson(a)},
            {"ate_translation_m", StatisticsJson(a.ate_m)},
            {"ate_rotation_deg", StatisticsJson(a.ate_deg)}};
  json["rpe"] = Json::array();
  for (const RelativeErrorSummary& relative : a.relative) json["rpe"].push_back(RelativeJson(relative));
  json["kitti"] = KittiJson(a.kitti);
  json["kitti_short"] = KittiJson(a.kitti_short);
  if (a.keyframes) json["keyframes"] = KeyframesJson(*a.keyframes);
  if (a.pose_consistency) json["nees_pose"] = ConsistencyJson(*a.pose_consistency);
  if (a.motion_consistency) json["nees_motion"] = ConsistencyJson(*a.motion_consistency);
  if (a.span_consistency) json["nees_motion_20"] = ConsistencyJson(*a.span_consistency);
  if (a.clock) {
    json["clock"] = {{"offset_s", a.clock->offset_s}, {"ate_m", a.clock->ate_m}, {"ate_now_m", a.clock->ate_now_m}};
  }
  if (!a.note.empty()) json["note"] = a.note;
  NullWhatIsNotFinite(json);
  return json;
}

}  // namespace plslam
