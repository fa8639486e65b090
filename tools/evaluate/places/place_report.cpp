// SPDX-License-Identifier: BSD-3-Clause
#include "tools/evaluate/places/place_report.h"

#include <fmt/format.h>

#include <array>

#include "tools/evaluate/drawing/axes.h"

namespace plslam::evaluate {
namespace {

using Json = nlohmann::ordered_json;

Json ToJson(const PrecisionRecall& result) {
  Json curve = Json::array();
  for (const PrecisionRecallPoint& p : result.curve) curve.push_back({p.score, p.precision, p.recall});
  return {{"area", result.area},
          {"recall_at_full_precision", result.recall_at_full_precision},
          {"score_precision_recall", curve}};
}

Json ToJson(const PlaceEvaluation& evaluation) {
  Json merges;
  for (const MergeEvaluation& m : evaluation.merges) {
    merges[NameOf(m.merge)] = {{"best_match", ToJson(m.best_match)}, {"all_pairs", ToJson(m.all_pairs)}};
  }
  return {{"sequence", evaluation.name},
          {"frames", evaluation.frames},
          {"revisiting_frames", evaluation.revisiting_frames},
          {"revisits", evaluation.revisits},
          {"other_places", evaluation.other_places},
          {"merges", merges}};
}

/// Returns the stroke of the i-th merge rule.
Stroke StrokeOf(size_t i) {
  static constexpr std::array<Ink, 7> kInks{
      {{40, 40, 40}, {20, 110, 200}, {60, 160, 60}, {220, 150, 30}, {200, 60, 50}, {150, 60, 170}, {150, 150, 150}}};
  // The default comes first and is emphasised.
  return {kInks[i % kInks.size()], i == 0 ? 1.2 : 0.75, false};
}

std::vector<Eigen::Vector2d> CurveOf(const PrecisionRecall& result) {
  std::vector<Eigen::Vector2d> points;
  if (!result.curve.empty()) points.emplace_back(0.0, result.curve.front().precision);
  for (const PrecisionRecallPoint& p : result.curve) points.emplace_back(p.recall, p.precision);
  return points;
}

void DrawCurves(const PlaceEvaluation& evaluation, PrecisionRecall MergeEvaluation::*which, const Box& area,
                const std::string& name, Drawing& drawing) {
  Axes axes(drawing, area, {0.0, 1.0}, {0.0, 1.02});
  axes.DrawGrid("recall, " + name, "precision");
  // The default on top.
  for (size_t i = evaluation.merges.size(); i-- > 0;) {
    axes.DrawPath(CurveOf(evaluation.merges[i].*which), StrokeOf(i));
  }
  axes.DrawFrame();
}

}  // namespace

std::string PlaceTable(const PlaceEvaluation& e) {
  std::string text =
      fmt::format("{}\n  {} frames, {} of them at revisited places; {} pairs are revisits, {} are not\n", e.name,
                  e.frames, e.revisiting_frames, e.revisits, e.other_places);
  text += fmt::format("  {:<12}{:>16}{:>24}{:>16}{:>24}\n", "", "best match: area", "recall at precision 1",
                      "all pairs: area", "recall at precision 1");
  for (const MergeEvaluation& m : e.merges) {
    text +=
        fmt::format("  {:<12}{:>16.4f}{:>24.4f}{:>16.4f}{:>24.4f}\n", NameOf(m.merge), m.best_match.area,
                    m.best_match.recall_at_full_precision, m.all_pairs.area, m.all_pairs.recall_at_full_precision);
  }
  return text;
}

Json PlacesToJson(const std::vector<PlaceEvaluation>& evaluations, const RevisitOptions& options) {
  Json json{{"revisit",
             {{"distance_m", options.distance_m},
              {"angle_deg", options.angle_deg},
              {"far_distance_m", options.far_distance_m},
              {"far_angle_deg", options.far_angle_deg},
              {"min_gap_s", options.min_gap_s}}}};
  json["sequences"] = Json::array();
  for (const PlaceEvaluation& evaluation : evaluations) json["sequences"].push_back(ToJson(evaluation));
  return json;
}

Drawing PrecisionRecallFigure(const PlaceEvaluation& evaluation) {
  constexpr double kLeft_pt = 24.0, kGap_pt = 36.0, kSide_pt = 0.5 * (kColumn_pt - kLeft_pt - kGap_pt - 6.0);
  Drawing drawing;
  AddTitle(drawing, evaluation.name);
  std::vector<LegendEntry> legend;
  for (size_t i = 0; i < evaluation.merges.size(); ++i)
    legend.push_back({NameOf(evaluation.merges[i].merge), StrokeOf(i)});
  const double top = AddLegend(drawing, {2.0, 22.0}, kColumn_pt - 4.0, legend) + 6.0;
  const Box left{{kLeft_pt, top}, {kSide_pt, kSide_pt}}, right{{left.Right() + kGap_pt, top}, left.size};
  drawing.size = {kColumn_pt, left.Bottom() + 23.0};
  DrawCurves(evaluation, &MergeEvaluation::best_match, left, "best matches", drawing);
  DrawCurves(evaluation, &MergeEvaluation::all_pairs, right, "all pairs", drawing);
  return drawing;
}

}  // namespace plslam::evaluate
