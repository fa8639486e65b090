#include "core/places/place_score.h"

#include <cmath>
#include <stdexcept>

namespace plslam {
namespace {

// In an image of the adaptive merge, besides what is found in it.
constexpr double kUnsharedPoints = 20.0;
// In the map of the adaptive merge, besides what is in it.
constexpr double kPlacesWithoutWords = 5.0;

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
  if (options.merge == "adaptive") {
    const double lines = options.line_worth * query.n_lines;
    const double all = query.n_points + lines + kUnsharedPoints;
    return {query.n_points / all, lines / all};
  }
  const double points = WeightOfPoints(query, options);
  return {points, 1.0 - points};
}

std::vector<float> WordWorths(const std::vector<int>& places_with, int places, const PlaceOptions& options) {
  std::vector<float> worths(places_with.size(), 1.0F);
  if (options.merge != "adaptive") return worths;
  for (size_t i = 0; i < worths.size(); ++i) {
    const double without = 1.0 - places_with[i] / (places + kPlacesWithoutWords);
    worths[i] = static_cast<float>(std::pow(without, options.rarity));
  }
  return worths;
}

}  // namespace plslam
