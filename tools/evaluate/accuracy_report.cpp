// SPDX-License-Identifier: BSD-3-Clause
#include "tools/evaluate/accuracy.h"

#include <fmt/format.h>

#include <cmath>

#include "core/accuracy/roll.h"

namespace plslam::evaluate {
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
  Json json{{"kind", NameOf(a.alignment_kind)},
            {"scale", a.alignment.scale},
            {"translation_m", {t.x(), t.y(), t.z()}},
            {"q_wxyz", {q.w(), q.x(), q.y(), q.z()}}};
  if (a.roll_sigma_deg) json["roll_sigma_deg"] = *a.roll_sigma_deg;
  return json;
}

/// A JSON file would have null for them anyway; the object in memory must be equal to it.
void ReplaceNonFiniteByNull(Json& json) {
  if (json.is_number_float() && !std::isfinite(json.get<double>())) json = nullptr;
  if (json.is_structured()) {
    for (Json& member : json) ReplaceNonFiniteByNull(member);
  }
}

std::string Value(int n, double value) { return n > 0 && std::isfinite(value) ? fmt::format("{:.4f}", value) : "-"; }

std::string StatisticsRow(const std::string& name, const Statistics& s) {
  return fmt::format("{:<26}{:>8}{:>12}{:>12}{:>12}{:>12}\n", name, s.n, Value(s.n, s.rmse), Value(s.n, s.mean),
                     Value(s.n, s.median), Value(s.n, s.max));
}

std::string Head(const Accuracy& a) {
  std::string text = fmt::format("poses       {} estimated, {} true, {} associated; coverage {:.1f} %\n",
                                 a.estimated_poses, a.true_poses, a.pairs.size(), a.coverage_percent);
  text += fmt::format("true path   {} m in {:.3f} s\n",
                      std::isfinite(a.true_path_m) ? fmt::format("{:.3f}", a.true_path_m) : "-", a.duration_s);
  text += fmt::format("alignment   {}", NameOf(a.alignment_kind));
  if (a.alignment_kind == Alignment::kSim3) text += fmt::format(", scale {:.6f}", a.alignment.scale);
  text += '\n';
  if (a.roll_sigma_deg && !a.pairs.empty()) {
    text += fmt::format("roll        {}; orientations are aligned by their own mean\n", RollText(*a.roll_sigma_deg));
  }
  if (!a.note.empty()) text += fmt::format("note        {}\n", a.note);
  return text;
}

std::string StatisticsTable(const Accuracy& a) {
  std::string text = fmt::format("\n{:<26}{:>8}{:>12}{:>12}{:>12}{:>12}\n", "", "n", "rmse", "mean", "median", "max");
  text += StatisticsRow("ATE position [m]", a.ate_m);
  text += StatisticsRow("ATE orientation [deg]", a.ate_deg);
  for (const RelativeErrorSummary& r : a.relative) {
    text += StatisticsRow(fmt::format("RPE {} translation [m]", DeltaText(r.delta)), r.translation_m);
    text += StatisticsRow(fmt::format("RPE {} rotation [deg]", DeltaText(r.delta)), r.rotation_deg);
  }
  return text;
}

std::string KittiRow(const std::string& name, int segments, double t_rel, double r_rel) {
  return fmt::format("{:<26}{:>8}{:>12}{:>18}\n", name, segments, Value(segments, t_rel), Value(segments, r_rel));
}

std::string KittiTable(const std::string& name, const KittiErrors& errors) {
  if (errors.segments == 0) return "";
  std::string text = fmt::format("\n{:<26}{:>8}{:>12}{:>18}\n", name, "n", "t_rel [%]", "r_rel [deg/100m]");
  for (const KittiLengthError& row : errors.lengths) {
    text += KittiRow(fmt::format("{:g} m", row.length_m), row.segments, row.t_rel_percent, row.r_rel_deg_per_100m);
  }
  return text + KittiRow("mean of all", errors.segments, errors.t_rel_percent, errors.r_rel_deg_per_100m);
}

std::string KeyframeTable(const KeyframeErrors& e) {
  return fmt::format(
      "\nbetween keyframes         n {}, translation rmse {} m, rotation rmse {} deg\n"
      "  relative to distance    n {}, rmse {}, t_rel {} %, R_rel {} deg/100m\n",
      e.motions, Value(e.motions, e.rmse_m), Value(e.motions, e.rmse_deg), e.moving, Value(e.moving, e.relative_rmse),
      Value(e.moving, e.t_rel_percent), Value(e.moving, e.R_rel_deg_per_100m));
}

std::string ConsistencyRow(const std::string& name, const Consistency& c) {
  if (c.n == 0 && c.singular == 0) {
    return fmt::format("\n{:<26}n 0: no covariance has the time of a compared pose (is it of this run?)\n", name);
  }
  if (c.n == 0) return fmt::format("\n{:<26}n 0, {} singular covariances\n", name, c.singular);
  return fmt::format("\n{:<26}n {}, mean {:.3f} (6 expected, 95 % between {:.3f} and {:.3f}), {:.1f} % above 12.59\n",
                     name, c.n, c.mean_nees, c.lower_bound, c.upper_bound, c.above_95_percent);
}

std::string ClockRow(const ClockOffset& clock) {
  return fmt::format(
      "\nclock                     the estimate fits best {:.1f} ms {}: ATE {:.4f} m instead of {:.4f}\n",
      1e3 * std::abs(clock.offset_s), clock.offset_s < 0.0 ? "earlier" : "later", clock.ate_m, clock.ate_now_m);
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
  ReplaceNonFiniteByNull(json);
  return json;
}

std::string AccuracyTable(const Accuracy& a) {
  std::string text = Head(a) + StatisticsTable(a);
  text += KittiTable("KITTI", a.kitti);
  text += KittiTable("KITTI's, short lengths", a.kitti_short);
  if (a.keyframes) text += KeyframeTable(*a.keyframes);
  if (a.pose_consistency) text += ConsistencyRow("NEES of poses", *a.pose_consistency);
  if (a.motion_consistency) text += ConsistencyRow("NEES of motions", *a.motion_consistency);
  if (a.span_consistency) {
    text += ConsistencyRow(fmt::format("NEES over {} frames", kConsistencySpan), *a.span_consistency);
  }
  if (a.clock) text += ClockRow(*a.clock);
  return text;
}

}  // namespace plslam::evaluate
