// SPDX-License-Identifier: BSD-3-Clause
#include "tools/evaluate/places/place_report.h"

#include <fmt/format.h>

namespace plslam {
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
    merges[m.merge] = {{"best_match", ToJson(m.best_match)}, {"all_pairs", ToJson(m.all_pairs)}};
  }
  return {{"sequence", evaluation.name},
          {"frames", evaluation.frames},
          {"revisiting_frames", evaluation.revisiting_frames},
          {"revisits", evaluation.revisits},
          {"other_places", evaluation.other_places},
          {"merges", merges}};
}

}  // namespace

std::string PlaceTable(const PlaceEvaluation& e) {
  std::string text =
      fmt::format("{}\n  {} frames, {} of them at places seen before; {} pairs are revisits, {} are not\n", e.name,
                  e.frames, e.revisiting_frames, e.revisits, e.other_places);
  text += fmt::format("  {:<12}{:>16}{:>24}{:>16}{:>24}\n", "", "best match: area", "recall at precision 1",
                      "all pairs: area", "recall at precision 1");
  for (const MergeEvaluation& m : e.merges) {
    text +=
        fmt::format("  {:<12}{:>16.4f}{:>24.4f}{:>16.4f}{:>24.4f}\n", m.merge, m.best_match.area,
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

}  // namespace plslam
