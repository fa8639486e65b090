// SPDX-License-Identifier: BSD-3-Clause
#include "core/places/place_recogniser.h"

#include <algorithm>
#include <stdexcept>
#include <tuple>
#include <utility>

#include "core/features/matching/hamming.h"

namespace plslam {
namespace {

void CheckType(const Vocabulary& vocabulary, FeatureType type) {
  if (vocabulary.type() == type) return;
  throw std::invalid_argument(std::string("a vocabulary of ") + NameOf(vocabulary.type()) +
                              " was given where one of " + NameOf(type) + " is needed");
}

bool Worse(const PlaceMatch& a, const PlaceMatch& b) {
  return std::tuple(-a.score, a.keyframe_id) > std::tuple(-b.score, b.keyframe_id);
}

/// Returns the best `max_results` that are not excluded, best first. A heap sorts only those that are examined.
std::vector<PlaceMatch> Best(std::vector<PlaceMatch> matches, const std::function<bool(KeyframeId)>& excluded,
                             int max_results) {
  std::vector<PlaceMatch> best;
  std::make_heap(matches.begin(), matches.end(), Worse);
  while (!matches.empty() && static_cast<int>(best.size()) < max_results) {
    std::pop_heap(matches.begin(), matches.end(), Worse);
    if (!excluded || !excluded(matches.back().keyframe_id)) best.push_back(matches.back());
    matches.pop_back();
  }
  return best;
}

template <class Features>
PlaceDescription DescribeWith(const Features& features, const Vocabulary& points, const Vocabulary& lines) {
  PlaceDescription description = DescribeLayout(features);
  description.points = points.Transform(DescriptorsOf(features.points));
  description.lines = lines.Transform(DescriptorsOf(features.lines));
  return description;
}

PlaceMatch MatchOf(KeyframeId keyframe_id, const PlaceWeights& weights, double points, double lines) {
  return {keyframe_id, weights.points * points + weights.lines * lines, points, lines};
}

}  // namespace

PlaceRecogniser::PlaceRecogniser(Vocabulary points, Vocabulary lines, const PlaceOptions& options)
    : points_(std::move(points)),
      lines_(std::move(lines)),
      options_(options),
      point_index_(points_.words()),
      line_index_(lines_.words()) {
  CheckType(points_, FeatureType::kPoints);
  CheckType(lines_, FeatureType::kLines);
}

PlaceDescription PlaceRecogniser::Describe(const FeaturesView& features) const {
  return DescribeWith(features, points_, lines_);
}

PlaceDescription PlaceRecogniser::Describe(const ImageFeatures& features) const {
  return DescribeWith(features, points_, lines_);
}

int PlaceRecogniser::FreePlace() {
  if (free_.empty()) {
    keyframe_ids_.push_back(-1);
    descriptions_.emplace_back();
    return static_cast<int>(keyframe_ids_.size()) - 1;
  }
  const int place = free_.back();
  free_.pop_back();
  return place;
}

void PlaceRecogniser::Add(KeyframeId keyframe_id, PlaceDescription description) {
  Remove(keyframe_id);
  const int place = FreePlace();
  point_index_.Add(place, description.points);
  line_index_.Add(place, description.lines);
  keyframe_ids_[place] = keyframe_id;
  descriptions_[place] = std::move(description);
  place_of_[keyframe_id] = place;
}

bool PlaceRecogniser::Remove(KeyframeId keyframe_id) {
  const auto found = place_of_.find(keyframe_id);
  if (found == place_of_.end()) return false;
  const int place = found->second;
  point_index_.Remove(place, descriptions_[place].points);
  line_index_.Remove(place, descriptions_[place].lines);
  keyframe_ids_[place] = -1;
  descriptions_[place] = {};
  free_.push_back(place);
  place_of_.erase(found);
  return true;
}

const PlaceDescription& PlaceRecogniser::Of(KeyframeId keyframe_id) const {
  return descriptions_[place_of_.at(keyframe_id)];
}

std::vector<float> PlaceRecogniser::Weights(const PlaceIndex& index, const BagOfWords& query) const {
  return WordWeights(index.PlacesWith(query), size(), options_);
}

std::vector<PlaceMatch> PlaceRecogniser::Query(const PlaceDescription& query,
                                               const std::function<bool(KeyframeId)>& excluded,
                                               int max_results) const {
  std::vector<float> points(keyframe_ids_.size(), 0.0F);
  std::vector<float> lines(keyframe_ids_.size(), 0.0F);
  point_index_.Score(query.points, Weights(point_index_, query.points), points);
  line_index_.Score(query.lines, Weights(line_index_, query.lines), lines);
  const PlaceWeights weights = WeightsFor(query, options_);
  std::vector<PlaceMatch> matches;
  matches.reserve(keyframe_ids_.size());
  for (size_t i = 0; i < keyframe_ids_.size(); ++i) {
    const PlaceMatch match = MatchOf(keyframe_ids_[i], weights, points[i], lines[i]);
    if (match.score > 0.0) matches.push_back(match);
  }
  return Best(std::move(matches), excluded, max_results);
}

PlaceMatch PlaceRecogniser::Compare(const PlaceDescription& query, const PlaceDescription& other) const {
  return MatchOf(-1, WeightsFor(query, options_),
                 BagSimilarity(query.points, Weights(point_index_, query.points), other.points),
                 BagSimilarity(query.lines, Weights(line_index_, query.lines), other.lines));
}

double PlaceRecogniser::Score(const PlaceDescription& query, const PlaceDescription& other) const {
  return Compare(query, other).score;
}

}  // namespace plslam
