// SPDX-License-Identifier: BSD-3-Clause
#include "loop_process/place_search.h"

#include <algorithm>
#include <array>
#include <vector>

#include "core/features/matching/descriptor_matcher.h"
#include "core/features/matching/hamming.h"
#include "core/features/matching/line_matcher.h"
#include "core/motion/robust.h"
#include "loop_process/guided_matching.h"

namespace plslam::loop {
namespace {

// Number of pairs of points up to which all are compared.
constexpr size_t kFewPairs = 100'000;

// Features of a keyframe that observe a landmark: landmark ids, indices of the features, and their descriptors.
template <class Feature>
struct Shown {
  std::vector<LandmarkId> ids;
  std::vector<size_t> places;
  std::vector<Descriptor> descriptors;

  std::vector<LandmarkId> Named(const std::vector<int>& matches) const {
    std::vector<LandmarkId> named;
    named.reserve(matches.size());
    for (const int match : matches) named.push_back(match < 0 ? -1 : ids[static_cast<size_t>(match)]);
    return named;
  }
};

template <class Type>
Shown<typename Type::Feature> ThatShow(const Map& map, KeyframeId keyframe_id, const FeaturesView& features) {
  Shown<typename Type::Feature> shown;
  const std::vector<LandmarkId>& ids = Type::Of(map, keyframe_id);
  const auto& of_type = Type::Features(features);
  for (size_t i = 0; i < ids.size() && i < of_type.size(); ++i) {
    if (ids[i] < 0) continue;
    shown.ids.push_back(ids[i]);
    shown.places.push_back(i);
    shown.descriptors.push_back(of_type[i].left.descriptor);
  }
  return shown;
}

Eigen::Vector2d Middle(const StereoPoint& point) { return point.left.px; }
Eigen::Vector2d Middle(const StereoLine& line) { return 0.5 * (line.left.segment.p + line.left.segment.q); }

template <class Type>
void Spread(const Map& map, const SE3& T_c_w, const StereoCamera& camera,
            std::span<const typename Type::Feature> features, const std::vector<LandmarkId>& association,
            std::array<bool, kViewCells>& cells, std::vector<double>& depths) {
  for (size_t i = 0; i < association.size(); ++i) {
    if (association[i] < 0) continue;
    cells[ViewCell(Middle(features[i]), camera)] = true;
    depths.push_back((T_c_w * Middle(*Type::Find(map, association[i]))).z());
  }
}

void Weigh(const Map& map, KeyframeId keyframe_id, const FeaturesView& features, const StereoCamera& camera,
           FoundPlace& place) {
  const SE3 T_c_w = place.pose.T_w_kf.Inverse();
  place.inliers = place.association.Weight();
  place.landmarks = CountExpected(map, keyframe_id, place.pose.T_w_kf, camera, place.association);
  std::array<bool, kViewCells> cells{};
  std::vector<double> depths;
  Spread<PointType>(map, T_c_w, camera, features.points, place.association.points, cells, depths);
  Spread<LineType>(map, T_c_w, camera, features.lines, place.association.lines, cells, depths);
  place.cells = static_cast<int>(std::count(cells.begin(), cells.end(), true));
  place.median_depth_m = Median(depths);
}

}  // namespace

Place PlaceAround(const Map& map, KeyframeId keyframe_id, int max_keyframes) {
  const std::vector<KeyframeId> keyframes = KeyframesAround(keyframe_id, map, Map::kCovisible, max_keyframes);
  return {keyframe_id, {SeenBy<PointType>(keyframes, map), SeenBy<LineType>(keyframes, map)}};
}

std::optional<KeyframePose> GuessPose(const Map& map, KeyframeId keyframe_id, const DescribedImage& keyframe,
                                      const DescribedImage& image, const StereoCamera& camera,
                                      const LocalisationOptions& options, int min_matches) {
  const Shown<StereoPoint> points = ThatShow<PointType>(map, keyframe_id, keyframe.features);
  const Shown<StereoLine> lines = ThatShow<LineType>(map, keyframe_id, keyframe.features);
  const auto seen_points = DescriptorsOf(image.features.points);
  const bool few = seen_points.size() * points.ids.size() <= kFewPairs;
  FeatureNodes nodes;
  for (const size_t place : points.places) nodes.node.push_back(keyframe.point_nodes.node.at(place));
  Association association;
  association.points = points.Named(
      few ? MatchBruteForce(seen_points, points.descriptors, options.point_matching)
          : MatchByNodes(seen_points, image.point_nodes, points.descriptors, nodes, options.point_matching));
  association.lines = lines.Named(
      MatchLinesBruteForce(DescriptorsOf(image.features.lines), lines.descriptors, options.line_matching));
  if (association.Weight() < min_matches) return std::nullopt;
  return FindPose(map, image.features, camera, options.motion, min_matches, association);
}

std::optional<FoundPlace> FindPlace(const Map& map, const Place& place, const SE3& T_w_c,
                                    const FeaturesView& features, const StereoCamera& camera,
                                    const LocalisationOptions& options) {
  FoundPlace found;
  found.pose.T_w_kf = T_w_c;
  for (int round = 0; round < 2; ++round) {
    // Starts without associations in each round: matches from a worse pose are no evidence.
    found.association = {std::vector<LandmarkId>(features.points.size(), -1),
                         std::vector<LandmarkId>(features.lines.size(), -1)};
    SearchByProjection(map, place.landmarks, found.pose.T_w_kf, features, camera, options, found.association);
    found.matches = found.association.Weight();
    const auto pose = RefinePose(map, features, camera, found.pose.T_w_kf, options.motion, found.association);
    if (!pose) return std::nullopt;
    found.pose = *pose;
  }
  Weigh(map, place.keyframe_id, features, CameraOf(features, camera), found);
  return found;
}

}  // namespace plslam::loop
