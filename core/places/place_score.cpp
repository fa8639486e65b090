#include "core/places/place_score.h"

#include <stdexcept>

namespace plslam {
namespace {

double Share(double part, double other) { return part + other > 0.0 ? part / (part + other) : 0.5; }

double WeightOfPoints(const PlaceDescription& query, const PlaceOptions& options) {
  const double strength = Share(query.n_points, query.n_lines);
  const double dispersion = Share(query.dispersion_points_px, query.dispersion_lines_px);
  if (options.merge == "balanced") return Share(query.n_points, options.line_worth * query.n_lines);
  if (options.merge == "paper") return 0.5 * (strength + dispersion);
  if (options.merge == "strength") return strength;
  if (options.merge == "dispersion") return dispersion;
  if (options.merge == "points") return 1.0;
  if (options.merge == "lines") return 0.0;
  throw std::invalid_argument("no merge of places is called " + options.merge);
}

}  // namespace

PlaceWeights WeightsFor(const PlaceDescription& query, const PlaceOptions& options) {
  const double points = WeightOfPoints(query, options);
  return {points, 1.0 - points};
}

}  // namespace plslam
