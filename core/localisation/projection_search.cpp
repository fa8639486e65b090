// SPDX-License-Identifier: BSD-3-Clause
#include "core/localisation/projection_search.h"

#include "core/features/matching/descriptor_matcher.h"
#include "core/features/matching/line_matcher.h"
#include "core/features/matching/segment_projection.h"

namespace plslam {
namespace {

// Eligible lines, and their indices in the whole list.
struct LineSubset {
  std::vector<StereoLine> features;
  std::vector<int> places;
};

LineSubset Eligible(std::span<const StereoLine> features, const std::vector<char>& eligible) {
  LineSubset subset;
  for (size_t i = 0; i < features.size(); ++i) {
    if (eligible[i] == 0) continue;
    subset.features.push_back(features[i]);
    subset.places.push_back(static_cast<int>(i));
  }
  return subset;
}

// `place_of` returns the index among all features of a match.
template <class PlaceOf>
std::vector<LandmarkFeature> PairUp(const std::vector<LandmarkId>& owners, const std::vector<int>& found,
                                    const PlaceOf& place_of) {
  std::vector<LandmarkFeature> pairs;
  for (size_t i = 0; i < found.size(); ++i) {
    if (found[i] >= 0) pairs.push_back({owners[i], place_of(found[i])});
  }
  return pairs;
}

}  // namespace

std::vector<LandmarkFeature> SearchPoints(const Map& map, const std::vector<LandmarkId>& ids, const SE3& T_w_kf,
                                          std::span<const StereoPoint> features, const std::vector<char>& eligible,
                                          double radius_px, const StereoCamera& camera,
                                          const LocalisationOptions& options) {
  const SE3 T_kf_w = T_w_kf.Inverse();
  const double octave_scale = camera.OctaveScale();
  std::vector<PointQuery> queries;
  std::vector<LandmarkId> owners;
  for (const LandmarkId id : ids) {
    const MapPoint& point = *map.FindPoint(id);
    const Eigen::Vector3d p_c = T_kf_w * point.p_w;
    if (p_c.z() < camera.MinDepth()) continue;
    const Eigen::Vector2d px = camera.Project(p_c);
    if (!camera.InImage(px, 0.0)) continue;
    const int octave = ExpectedOctave(point.octave, point.depth_m, octave_scale * p_c.z(), options.orb_scale_factor,
                                      options.orb_levels);
    queries.push_back({px, radius_px, octave, point.angle_rad, point.descriptor});
    owners.push_back(id);
  }
  if (queries.empty()) return {};
  const std::vector<int> found =
      MatchPointsByProjection(queries, PointGrid(features, eligible), options.point_matching);
  return PairUp(owners, found, [](int feature) { return feature; });
}

std::vector<LandmarkFeature> SearchLines(const Map& map, const std::vector<LandmarkId>& ids, const SE3& T_w_kf,
                                         std::span<const StereoLine> features, const std::vector<char>& eligible,
                                         double radius_px, const StereoCamera& camera,
                                         const LocalisationOptions& options) {
  const SE3 T_kf_w = T_w_kf.Inverse();
  std::vector<PredictedLine> predicted;
  std::vector<LandmarkId> owners;
  for (const LandmarkId id : ids) {
    const MapLine& line = *map.FindLine(id);
    const auto segment = ProjectSegment({T_kf_w * line.segment_w.p, T_kf_w * line.segment_w.q}, camera, 0.0);
    if (!segment) continue;
    predicted.push_back({*segment, line.descriptor});
    owners.push_back(id);
  }
  if (predicted.empty()) return {};
  const LineSubset subset = Eligible(features, eligible);
  LineMatchOptions window = options.line_matching;
  window.max_across_px = radius_px;
  return PairUp(owners, MatchLinesByProjection(predicted, subset.features, window),
                [&subset](int feature) { return subset.places[static_cast<size_t>(feature)]; });
}

}  // namespace plslam
