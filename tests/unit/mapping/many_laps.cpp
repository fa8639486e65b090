// SPDX-License-Identifier: BSD-3-Clause
#include "tests/unit/mapping/many_laps.h"

#include <algorithm>
#include <map>
#include <numbers>
#include <random>
#include <set>
#include <stdexcept>
#include <utility>

#include "core/map/map_follower.h"
#include "tests/support/lap_errors.h"
#include "tests/unit/mapping/mapping_world.h"

namespace plslam::test {
namespace {

template <class Landmarks>
std::map<Descriptor, LandmarkId> ByDescriptor(const Landmarks& landmarks) {
  std::map<Descriptor, LandmarkId> ids;
  for (const auto& [id, landmark] : landmarks) ids[landmark.descriptor] = id;
  return ids;
}

/// Returns the share of the map's points that are not in the world any more.
double ShareOfGone(const Map& map, const FeatureWorld& world) {
  std::set<Descriptor> there;
  for (const FeatureWorld::Point& point : world.points()) there.insert(point.descriptor);
  const auto is_gone = [&](const auto& entry) { return !there.contains(entry.second.descriptor); };
  const auto n = std::count_if(map.points().begin(), map.points().end(), is_gone);
  return static_cast<double>(n) / static_cast<double>(map.points().size());
}

/// The front end and the tracker.
class Tracker {
 public:
  explicit Tracker(const LapsOptions& options) : options_(options), random_(options.seed) {}

  Keyframe See(const SE3& T_w_kf, const SE3& step, const FeatureWorld& world, const Map& map) {
    Vector6d error;
    for (int k = 0; k < 6; ++k)
      error[k] = (k < 3 ? options_.motion_sigma_m : options_.motion_sigma_rad) * gauss_(random_);
    const SE3 T_odom_kf = n_ == 0 ? T_w_kf : previous_.T_odom_kf * step * SE3::Exp(error);
    StereoFeatures features = world.Observe(T_w_kf, options_.noise_px, random_());
    std::erase_if(features.points, [this](const StereoPoint&) { return !Happens(options_.detected); });
    std::erase_if(features.lines, [this](const StereoLine&) { return !Happens(options_.detected); });
    Keyframe keyframe = MakeKeyframe(n_ == 0 ? nullptr : &previous_, T_odom_kf, std::move(features));
    Vector6d variances;
    variances.head<3>().setConstant(options_.motion_sigma_m * options_.motion_sigma_m);
    variances.tail<3>().setConstant(options_.motion_sigma_rad * options_.motion_sigma_rad);
    if (n_ > 0) keyframe.covariance = variances.asDiagonal();
    keyframe.point_map_ids = Named(keyframe.features.points, ByDescriptor(map.points()));
    keyframe.line_map_ids = Named(keyframe.features.lines, ByDescriptor(map.lines()));
    ++n_;
    return previous_ = keyframe;
  }

 private:
  bool Happens(double probability) { return std::uniform_real_distribution<double>()(random_) < probability; }

  template <class Feature>
  std::vector<LandmarkId> Named(const std::vector<Feature>& features, const std::map<Descriptor, LandmarkId>& ids) {
    std::vector<LandmarkId> named;
    for (const Feature& feature : features) {
      const auto known = ids.find(feature.left.descriptor);
      named.push_back(known == ids.end() || Happens(options_.unnamed) ? -1 : known->second);
    }
    for (size_t i = 1; i < named.size(); ++i) {
      if (Happens(options_.confused)) std::swap(named[i], named[random_() % i]);
    }
    return named;
  }

  const LapsOptions& options_;
  std::mt19937_64 random_;
  std::normal_distribution<double> gauss_;
  int n_ = 0;
  Keyframe previous_;
};

/// Poses of all frames that were keyframes, in the final map.
std::vector<SE3> FinalPoses(const Map& map, std::vector<SE3> poses) {
  for (const auto& [id, keyframe] : map.keyframes())
    poses[static_cast<size_t>(keyframe.frame_id.value)] = keyframe.T_w_kf;
  for (const RemovedKeyframe& removed : map.RemovedKeyframes()) {
    poses[static_cast<size_t>(removed.frame_id.value)] = removed.T_w_kf;
  }
  return poses;
}

}  // namespace

SE3 ChangingWorld::PoseAt(int i) {
  const double angle = 2.0 * std::numbers::pi * i / kKeyframes;
  return {ExpSO3({0.0, angle, 0.0}), {1.2 * std::sin(angle), 0.0, 1.2 * (1.0 - std::cos(angle))}};
}

void ChangingWorld::Change(double share, uint64_t seed) {
  const FeatureWorld other(Counts(), seed);
  std::mt19937_64 random(seed);
  std::vector<FeatureWorld::Point> points = world_.points();
  std::vector<FeatureWorld::Line> lines = world_.lines();
  const auto is_replaced = [&] { return static_cast<double>(random() % 1000) < 1000.0 * share; };
  for (size_t i = 0; i < points.size(); ++i) {
    if (is_replaced()) points[i] = other.points()[i];
  }
  for (size_t i = 0; i < lines.size(); ++i) {
    if (is_replaced()) lines[i] = other.lines()[i];
  }
  world_ = FeatureWorld(std::move(points), std::move(lines), 20.0);
}

LapsResult RunLaps(const LapsOptions& options) {
  ChangingWorld changing;
  mapping::Mapper mapper(FeatureWorld::Camera(), options.mapping);
  MapFollower replica;
  replica.RememberRemoved();
  Tracker tracker(options);
  std::vector<SE3> live, truth;
  LapsResult result{{}, {}, {}, {}, {}, changing.world()};
  for (int i = 0; i < options.laps * ChangingWorld::kKeyframes; ++i) {
    const bool begins = i > 0 && i % ChangingWorld::kKeyframes == 0;
    if (begins && options.replaced > 0.0) changing.Change(options.replaced, 1000 + static_cast<uint64_t>(i));
    truth.push_back(ChangingWorld::PoseAt(i));
    const SE3 step = i == 0 ? SE3() : ChangingWorld::PoseAt(i - 1).Inverse() * truth.back();
    Keyframe keyframe = tracker.See(truth.back(), step, changing.world(), mapper.map());
    keyframe.frame_id = i;
    std::string reason;
    if (!MapOne(keyframe, mapper, &reason)) throw std::runtime_error(reason);
    replica.Apply(mapper.TakeUpdate());
    live.push_back(mapper.map().keyframes().rbegin()->second.T_w_kf);
    const MapTotals totals = mapper.map().Totals();
    result.most.keyframes = std::max(result.most.keyframes, totals.keyframes);
    result.most.points = std::max(result.most.points, totals.points);
    result.most.lines = std::max(result.most.lines, totals.lines);
    if ((i + 1) % ChangingWorld::kKeyframes != 0) continue;
    result.gone.push_back(ShareOfGone(mapper.map(), changing.world()));
  }
  result.live_m = ErrorsOfLaps(live, truth, ChangingWorld::kKeyframes);
  result.final_m = ErrorsOfLaps(FinalPoses(replica.map(), live), truth, ChangingWorld::kKeyframes);
  result.map = replica.map();
  result.world = changing.world();
  return result;
}

}  // namespace plslam::test
