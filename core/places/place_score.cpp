#include "core/places/place_score.h"

#include <stdexcept>

namespace plslam {
namespace {

double Share(double part, double other) { return part + other > 0.0 ? part / (part + other) : 0.5; }

PlaceWeights WithPoints(double weight) { return {weight, 1.0 - weight}; }

}  // namespace

PlaceMerge PlaceMergeFromName(const std::string& name) {
  if (name == "paper") return PlaceMerge::kPaper;
  if (name == "points") return PlaceMerge::kPoints;
  if (name == "lines") return PlaceMerge::kLines;
  if (name == "strength") return PlaceMerge::kStrength;
  if (name == "dispersion") return PlaceMerge::kDispersion;
  throw std::invalid_argument("no merge of place scores is called " + name);
}

PlaceWeights WeightsFor(const PlaceDescription& query, PlaceMerge merge) {
  const double strength = Share(query.n_points, query.n_lines);
  const double dispersion = Share(query.dispersion_points_px, query.dispersion_lines_px);
  switch (merge) {
    case PlaceMerge::kPoints:
      return WithPoints(1.0);
    case PlaceMerge::kLines:
      return WithPoints(0.0);
    case PlaceMerge::kStrength:
      return WithPoints(strength);
    case PlaceMerge::kDispersion:
      return WithPoints(dispersion);
    case PlaceMerge::kPaper:
      break;
  }
  return WithPoints(0.5 * (strength + dispersion));
}

}  // namespace plslam
