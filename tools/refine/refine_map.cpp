// SPDX-License-Identifier: BSD-3-Clause
#include "tools/refine/refine_map.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <iterator>
#include <map>
#include <optional>
#include <set>
#include <stdexcept>
#include <tuple>
#include <type_traits>
#include <utility>

#include <fmt/format.h>

#include "core/io/maps/map_camera.h"
#include "core/map/map_parts.h"
#include "core/motion/robust.h"
#include "core/optim/bundle/line_cost.h"
#include "core/optim/bundle/map_bundle.h"
#include "core/optim/bundle/options.h"
#include "core/optim/pose_graph/map_pose_graph.h"
#include "core/process/process_usage.h"
#include "mapping_process/insertion/duplicates.h"
#include "mapping_process/insertion/observations.h"
#include "mapping_process/options.h"
#include "tools/refine/remaining_time.h"

namespace plslam::refine {
namespace {

constexpr int kMaxPasses = 8;
// Share of changed observations below which another pass gains nothing.
constexpr double kFewChanges = 0.005;
// Squared whitened residual up to which an observation takes part in the first pass.
constexpr double kFirstGate = 100.0;

double Gate(int rows) { return ChiSquareQuantile(rows, BundleOptions{}.gate_sigmas); }

/// A batch problem of a whole map, with the ids of its elements.
struct MapProblem {
  MapBundle ids;
  BatchProblem batch;
};

/// Velocity of a keyframe from its neighbours in the session, in its own frame.
Vector6d TwistOf(const MapKeyframe& keyframe, const Map& map, const std::map<KeyframeId, KeyframeId>& next) {
  const MapKeyframe* before = map.FindKeyframe(keyframe.previous_id);
  const auto found = next.find(keyframe.id);
  const MapKeyframe* after = found == next.end() ? nullptr : map.FindKeyframe(found->second);
  Vector6d sum = Vector6d::Zero();
  int n = 0;
  for (const MapKeyframe* other : {before, after}) {
    if (other == nullptr || other->t_ns == keyframe.t_ns) continue;
    const double dt_s = 1e-9 * static_cast<double>(other->t_ns - keyframe.t_ns);
    sum += (keyframe.T_w_kf.Inverse() * other->T_w_kf).Log() / dt_s;
    ++n;
  }
  return n > 0 ? (sum / n).eval() : sum;
}

std::vector<Vector6d> TwistsOf(const std::vector<KeyframeId>& keyframes, const Map& map) {
  std::map<KeyframeId, KeyframeId> next;
  for (const auto& [id, keyframe] : map.keyframes()) next[keyframe.previous_id] = id;
  std::vector<Vector6d> twists;
  twists.reserve(keyframes.size());
  for (const KeyframeId id : keyframes) twists.push_back(TwistOf(*map.FindKeyframe(id), map, next));
  return twists;
}

/// Motions as the tracker measured them were computed with the camera before. Where the camera is estimated, they are
/// used only between keyframes that share too few landmarks, and so are loops in any case: the landmarks that both sides
/// share express a loop better.
void ChooseMotions(const Map& map, CameraChoice camera, MapBundle& bundle) {
  const std::vector<KeyframeId>& ids = bundle.keyframes;
  const auto shares = [&](KeyframeId a, KeyframeId b) { return map.Shared(a, b) >= Map::kCovisible; };
  std::vector<RelativePose>& motions = bundle.problem.relative_poses;
  if (camera != CameraChoice::kFixed) {
    std::erase_if(motions, [&](const RelativePose& motion) {
      return shares(ids[static_cast<size_t>(motion.a)], ids[static_cast<size_t>(motion.b)]);
    });
  }
  const auto index = [&ids](KeyframeId id) {
    const auto at = std::lower_bound(ids.begin(), ids.end(), id);
    return at != ids.end() && *at == id ? static_cast<int>(at - ids.begin()) : -1;
  };
  for (const LoopEdge& loop : map.loops()) {
    const int a = index(loop.old_keyframe_id);
    const int b = index(loop.keyframe_id);
    if (a < 0 || b < 0 || a == b || shares(loop.old_keyframe_id, loop.keyframe_id)) continue;
    motions.push_back({a, b, loop.T_old_kf, loop.covariance});
  }
}

MapProblem ProblemOf(const StoredMap& stored, const StereoCamera& camera, const PairParameters& pair,
                     CameraChoice choice) {
  const Map& map = stored.map;
  std::vector<KeyframeId> keyframes;
  std::vector<LandmarkId> points, lines;
  for (const auto& [id, keyframe] : map.keyframes()) keyframes.push_back(id);
  for (const auto& [id, point] : map.points()) points.push_back(id);
  for (const auto& [id, line] : map.lines()) lines.push_back(id);
  const std::vector<bool> fixed(keyframes.size(), false);
  MapProblem problem;
  problem.ids = MakeMapBundle(map, stored.features, camera, std::move(keyframes), fixed, std::move(points),
                              std::move(lines), 1.0);
  ChooseMotions(map, choice, problem.ids);
  BatchProblem& batch = problem.batch;
  batch.bundle = std::move(problem.ids.problem);
  batch.pair = pair;
  if (choice == CameraChoice::kAll) {
    batch.twists = TwistsOf(problem.ids.keyframes, map);
    ForEachObservation<PointType>(
        problem.ids, problem.ids.points, map, stored.features, [&](int pose, int, const Observation& observation) {
          const StereoPoint& seen = stored.features.at(problem.ids.keyframes[static_cast<size_t>(pose)])
                                        .points[static_cast<size_t>(observation.feature)];
          batch.row_offsets.push_back({seen.row_offset_px, seen.sigma_row_px});
        });
  }
  return problem;
}

/// Activates the observations that fit. In the first pass, those that are not far off.
void Activate(const BatchFit& fit, bool first, BatchProblem& batch) {
  const auto usable_point = [&](size_t i) {
    const PointObservation& seen = batch.bundle.point_observations[i];
    return seen.uvd.allFinite() && seen.sigma_px > 0.0 && (seen.uvd.z() < 0.0 || seen.sigma_disparity_px > 0.0);
  };
  batch.point_active.assign(fit.points.size(), 0);
  batch.line_active.assign(fit.lines.size(), 0);
  for (size_t i = 0; i < fit.points.size(); ++i) {
    const int rows = batch.bundle.point_observations[i].uvd.z() >= 0.0 ? 3 : 2;
    batch.point_active[i] = usable_point(i) && fit.points[i] <= (first ? kFirstGate : Gate(rows));
  }
  for (size_t i = 0; i < fit.lines.size(); ++i) {
    const LineObservation& seen = batch.bundle.line_observations[i];
    const bool usable =
        LineCost::IsUsable(seen) && AdjustedLine(batch.bundle.lines[static_cast<size_t>(seen.line)]).IsUsable();
    batch.line_active[i] = usable && fit.lines[i] <= (first ? kFirstGate : Gate(fit.line_rows[i]));
  }
}

void AddLoops(const Map& map, MapFit& fit) {
  double squares_m2 = 0.0;
  for (const LoopEdge& loop : map.loops()) {
    const MapKeyframe* old = map.FindKeyframe(loop.old_keyframe_id);
    const MapKeyframe* keyframe = map.FindKeyframe(loop.keyframe_id);
    if (old == nullptr || keyframe == nullptr) continue;
    const SE3 T_old_kf = old->T_w_kf.Inverse() * keyframe->T_w_kf;
    squares_m2 += (T_old_kf.translation() - loop.T_old_kf.translation()).squaredNorm();
    ++fit.loops;
  }
  fit.loop_m = std::sqrt(squares_m2 / std::max(1.0, static_cast<double>(fit.loops)));
}

MapFit MapFitOf(const MapProblem& problem, const BatchFit& fit, const Map& map) {
  const BatchProblem& batch = problem.batch;
  MapFit result;
  const MapTotals totals = map.Totals();
  result.keyframes = totals.keyframes;
  result.points = totals.points;
  result.lines = totals.lines;
  double squares = 0.0, rows = 0.0, point_px2 = 0.0, line_px2 = 0.0;
  for (size_t i = 0; i < fit.points.size(); ++i) {
    const int n = batch.bundle.point_observations[i].uvd.z() >= 0.0 ? 3 : 2;
    if (!(fit.points[i] <= Gate(n))) continue;
    ++result.point_observations;
    squares += fit.points[i];
    rows += n;
    point_px2 += fit.points_px2[i];
  }
  for (size_t i = 0; i < fit.lines.size(); ++i) {
    if (!(fit.lines[i] <= Gate(fit.line_rows[i]))) continue;
    ++result.line_observations;
    squares += fit.lines[i];
    rows += fit.line_rows[i];
    line_px2 += fit.lines_px2[i];
  }
  result.normalised = std::sqrt(squares / std::max(1.0, rows));
  result.point_px = std::sqrt(point_px2 / std::max(1.0, static_cast<double>(result.point_observations)));
  result.line_px = std::sqrt(line_px2 / std::max(1.0, static_cast<double>(result.line_observations)));
  for (const auto& [id, keyframe] : map.keyframes()) {
    const MapKeyframe* previous = map.FindKeyframe(keyframe.previous_id);
    if (previous == nullptr) continue;
    result.length_m += (keyframe.T_w_kf.translation() - previous->T_w_kf.translation()).norm();
  }
  AddLoops(map, result);
  return result;
}

/// Observations by feature type, landmark, keyframe and feature.
using ObservationSet = std::set<std::tuple<int, LandmarkId, KeyframeId, int32_t>>;

template <class Type>
void Collect(int type, const Map& map, ObservationSet& all) {
  for (const auto& [id, landmark] : Type::Landmarks(map)) {
    for (const Observation& seen : landmark.observations) all.emplace(type, id, seen.keyframe_id(), seen.feature);
  }
}

ObservationSet ObservationsOf(const Map& map) {
  ObservationSet all;
  Collect<PointType>(0, map, all);
  Collect<LineType>(1, map, all);
  return all;
}

int64_t Changes(const ObservationSet& a, const ObservationSet& b) {
  std::vector<ObservationSet::value_type> differing;
  std::set_symmetric_difference(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(differing));
  return static_cast<int64_t>(differing.size());
}

/// The position of a point by one of its stereo measurements that most of the observations agree with; nullopt if it is
/// only that one.
std::optional<Eigen::Vector3d> TriangulateAgain(const MapPoint& point, const StoredMap& stored,
                                                const StereoCamera& camera) {
  std::optional<Eigen::Vector3d> best;
  int best_count = 1;
  MapPoint candidate = point;
  const auto feature = [&](const Observation& seen) -> const StereoPoint& {
    return stored.features.at(seen.keyframe_id()).points[static_cast<size_t>(seen.feature)];
  };
  for (const Observation& from : point.observations) {
    if (!feature(from).HasDepth()) continue;
    const StereoPoint& seen = feature(from);
    candidate.p_w = stored.map.FindKeyframe(from.keyframe_id())->T_w_kf *
                    camera.Backproject({seen.left.px.x(), seen.left.px.y(), seen.disparity_px});
    int count = 0;
    for (const Observation& other : point.observations) {
      const SE3 T_kf_w = stored.map.FindKeyframe(other.keyframe_id())->T_w_kf.Inverse();
      count += mapping::ObservationError(candidate, feature(other), T_kf_w, camera) <= 3.0 * Gate(3) / 2.0 ? 1 : 0;
    }
    if (count <= best_count) continue;
    best_count = count;
    best = candidate.p_w;
  }
  return best;
}

/// Drops the observations `outliers` (indices of observations, in the order of the problem); landmarks that keep none,
/// or only one without depth, are removed. A point without any inlier is triangulated again first.
template <class Type>
void DropOutliers(const MapProblem& problem, const std::vector<LandmarkId>& ids, const std::vector<char>& active,
                  const StereoCamera& camera, StoredMap& stored) {
  std::map<LandmarkId, std::vector<KeyframeId>> outliers;
  std::map<LandmarkId, int> inliers;
  size_t i = 0;
  ForEachObservation<Type>(problem.ids, ids, stored.map, stored.features,
                           [&](int, int landmark, const Observation& observation) {
                             const LandmarkId id = ids[static_cast<size_t>(landmark)];
                             if (active[i++] != 0) {
                               ++inliers[id];
                             } else {
                               outliers[id].push_back(observation.keyframe_id());
                             }
                           });
  for (const auto& [id, keyframes] : outliers) {
    if constexpr (std::is_same_v<Type, PointType>) {
      if (inliers[id] == 0) {
        const MapPoint point = *stored.map.FindPoint(id);
        if (const auto p_w = TriangulateAgain(point, stored, camera)) {
          stored.map.SetPosition(id, *p_w, point.covariance);
          continue;  // the next pass decides about its observations
        }
      }
    }
    for (const KeyframeId keyframe : keyframes) {
      mapping::DropObservation<Type>(id, keyframe, stored.features, stored.map);
    }
    const auto* left = Type::Find(stored.map, id);
    if (left == nullptr || left->observations.size() > 1) continue;
    const Observation& last = left->observations.front();
    const auto& feature = Type::Features(stored.features.at(last.keyframe_id()))[static_cast<size_t>(last.feature)];
    if (!feature.HasDepth()) Type::Remove(id, stored.map);
  }
}

/// Writes poses and landmarks to the map, with covariances of landmarks given the poses.
void Apply(const MapProblem& problem, Map& map) {
  const LandmarkCovariances covariances = ConditionalCovariances(problem.batch);
  const BundleProblem& bundle = problem.batch.bundle;
  for (size_t i = 0; i < bundle.poses.size(); ++i) {
    const KeyframeId id = problem.ids.keyframes[i];
    map.SetPose(id, bundle.poses[i].T_w_c, map.FindKeyframe(id)->covariance);
  }
  for (size_t i = 0; i < bundle.points.size(); ++i) {
    const LandmarkId id = problem.ids.points[i];
    const bool known = !covariances.points[i].isZero(0.0) && covariances.points[i].allFinite();
    map.SetPosition(id, bundle.points[i].p_w, known ? covariances.points[i] : map.FindPoint(id)->covariance.matrix());
  }
  for (size_t i = 0; i < bundle.lines.size(); ++i) {
    const LandmarkId id = problem.ids.lines[i];
    const MapLine& line = *map.FindLine(id);
    const bool known =
        !covariances.line_p[i].isZero(0.0) && covariances.line_p[i].allFinite() && covariances.line_q[i].allFinite();
    const Eigen::Matrix3d covariance_p = known ? covariances.line_p[i] : line.covariance_p.matrix();
    const Eigen::Matrix3d covariance_q = known ? covariances.line_q[i] : line.covariance_q.matrix();
    map.SetSegment(id, bundle.lines[i].segment_w, covariance_p, covariance_q);
  }
}

/// Continues from the result of a solve.
void Advance(const BatchResult& result, BatchProblem& batch) {
  for (size_t i = 0; i < result.T_w_c.size(); ++i) batch.bundle.poses[i].T_w_c = result.T_w_c[i];
  for (size_t i = 0; i < result.points.size(); ++i) batch.bundle.points[i].p_w = result.points[i];
  for (size_t i = 0; i < result.lines.size(); ++i) batch.bundle.lines[i].segment_w = result.lines[i];
  batch.pair = result.pair;
}

void CheckHasFeatures(const StoredMap& stored) {
  for (const auto& [id, keyframe] : stored.map.keyframes()) {
    if (stored.features.contains(id)) continue;
    throw std::runtime_error(fmt::format(
        "keyframe {} has no features in the map, which a batch adjustment needs: save the map again", id));
  }
}

StereoCamera EstimatedCamera(StereoCamera camera, const PairParameters& pair) {
  camera.f_px += pair[reference::kFocal];
  camera.cx_px += pair[reference::kCentreX];
  camera.cy_px += pair[reference::kCentreY];
  return camera;
}

/// Pixel and disparity by which the ideal pair would see what the estimated pair sees at `px`; disparity -1 behind the
/// camera, and for a feature without depth (`disparity_px` <= 0).
Eigen::Vector3d IdealPixel(const Eigen::Vector2d& px, double disparity_px, const StereoCamera& before,
                           const StereoCamera& after, const PairParameters& pair, const Vector6d& twist) {
  const bool has_depth = disparity_px > 0.0;
  Eigen::Vector3d ideal(px.x(), px.y(), has_depth ? disparity_px : 1.0);
  for (int i = 0; i < 10; ++i) {
    const reference::PairPixels<double> pixels(before, pair.data(), twist, after.Backproject(ideal));
    ideal.head<2>() += px - pixels.left;
    if (has_depth) ideal.z() += disparity_px - (pixels.left.x() - pixels.right.x());
    if (!(ideal.z() > 1e-3)) break;
  }
  if (!has_depth || !(ideal.z() > 1e-3)) ideal.z() = -1.0;
  return ideal;
}

/// Re-expresses all features in the ideal pair of the estimate.
void CorrectFeatures(const PairParameters& pair, const std::vector<KeyframeId>& keyframes,
                     const std::vector<Vector6d>& twists, const StereoCamera& before, const StereoCamera& after,
                     KeyframeFeatures& features) {
  for (size_t i = 0; i < keyframes.size(); ++i) {
    const Vector6d twist = twists.empty() ? Vector6d::Zero().eval() : twists[i];
    StereoFeatures own = OwnFeatures(features.at(keyframes[i]));
    const auto correct = [&](Eigen::Vector2d& px, double& disparity_px) {
      const Eigen::Vector3d ideal = IdealPixel(px, disparity_px, before, after, pair, twist);
      px = ideal.head<2>();
      disparity_px = ideal.z();
    };
    for (StereoPoint& point : own.points) {
      correct(point.left.px, point.disparity_px);
      if (!point.HasDepth() || point.sigma_row_px <= 0.0) continue;
      const Eigen::Vector3d p_c = after.Backproject({point.left.px.x(), point.left.px.y(), point.disparity_px});
      const reference::PairPixels<double> pixels(before, pair.data(), twist, p_c);
      point.row_offset_px -= pixels.right.y() - pixels.left.y();
    }
    for (StereoLine& line : own.lines) {
      correct(line.left.segment.p, line.disparity_p_px);
      correct(line.left.segment.q, line.disparity_q_px);
      if (!line.HasDepth()) line.disparity_p_px = line.disparity_q_px = -1.0;
    }
    features.insert_or_assign(keyframes[i], KeptFeatures(std::move(own)));
  }
}

std::string DemandSentence(const MapProblem& problem, const BatchDemand& demand, const Map& map, bool camera) {
  const MapTotals totals = map.Totals();
  return fmt::format(
      "{} keyframes, {} points, {} lines, {} observations: each of two to eight passes is expected to take about "
      "{:.0f} s "
      "and {:.0f} MB in all ({}){}",
      totals.keyframes, totals.points, totals.lines,
      problem.batch.bundle.point_observations.size() + problem.batch.bundle.line_observations.size(),
      std::ceil(demand.seconds), std::ceil(bus::PeakMemory_mb() + demand.memory_mb),
      demand.iterative ? "conjugate gradients with a cluster preconditioner" : "sparse factorisation",
      camera ? ", and the choice of the camera's parameters as long as five" : "");
}

void MergeAll(const StereoCamera& camera, StoredMap& stored) {
  const mapping::MappingOptions options;
  std::vector<KeyframeId> keyframes;
  for (const auto& [id, keyframe] : stored.map.keyframes()) keyframes.push_back(id);
  for (const KeyframeId id : keyframes) {
    mapping::MergeWithNeighbours(id, stored.features, camera, options, stored.map);
  }
}

void SetCovariances(const MapProblem& problem, const BatchOptions& options, StoredMap& stored, RefineReport& report) {
  const std::vector<Matrix6d> poses = PoseCovariances(problem.batch, options);
  std::map<KeyframeId, Matrix6d> covariances;
  for (size_t i = 0; i < poses.size(); ++i) {
    if (poses[i].allFinite()) covariances[problem.ids.keyframes[i]] = poses[i];
  }
  if (poses.empty()) covariances = CovariancesAround(stored.map.keyframes().begin()->first, stored.map);
  report.has_covariances = !covariances.empty();
  stored.map.SetCovariances(covariances);
}

BatchResult SolveOrThrow(const BatchProblem& problem, const BatchOptions& options) {
  BatchResult result = SolveBatch(problem, options);
  if (!result.ok) throw std::runtime_error(fmt::format("the map cannot be adjusted: {}", result.reason));
  return result;
}

/// Solves of a usual refinement: three passes; with the camera also one more, and those of `ChoosePair`.
int ExpectedSolves(const BatchOptions& options) {
  constexpr int kPasses = 3;
  return options.camera == CameraChoice::kFixed ? kPasses : kPasses + 1 + SolvesOfChoice(options);
}

}  // namespace

RefineReport RefineMap(StoredMap& given, StereoCamera& camera, const RefineOptions& options) {
  if (given.map.keyframes().size() < 2) {
    throw std::runtime_error(
        fmt::format("the map has {} keyframes: there is nothing to adjust", given.map.keyframes().size()));
  }
  CheckHasFeatures(given);
  StoredMap stored = given;
  stored.map.SetCamera(camera);
  RefineReport report;
  report.parts = static_cast<int>(PartsOf(stored.map, [](const MapKeyframe&) { return true; }).size());
  BatchOptions batch_options;
  batch_options.camera = options.camera;
  batch_options.threads = options.threads;
  batch_options.memory_bytes = options.memory_bytes;
  batch_options.stop = options.stop;
  PairParameters pair{};
  ObservationSet before = ObservationsOf(stored.map);
  MapProblem problem;
  RemainingTime remaining(ExpectedSolves(batch_options));
  const auto began = std::chrono::steady_clock::now();
  for (int pass = 1;; ++pass) {
    problem = ProblemOf(stored, camera, pair, batch_options.camera);
    const BatchFit fit = FitOf(problem.batch);
    Activate(fit, pass == 1, problem.batch);
    if (pass == 1) {
      report.before = MapFitOf(problem, fit, stored.map);
      report.demand = ExpectedDemand(problem.batch, batch_options);
      if (options.announce)
        options.announce(DemandSentence(problem, report.demand, stored.map, options.camera != CameraChoice::kFixed));
    }
    if (options.progress) {
      batch_options.progress = [&](int iteration, double cost) {
        const std::chrono::duration<double> elapsed_s = std::chrono::steady_clock::now() - began;
        options.progress({pass, iteration, cost, remaining.After(iteration, cost, elapsed_s.count())});
      };
    }
    BatchResult result = SolveOrThrow(problem.batch, batch_options);
    // Once, when gross outliers are gone; the rest of the work estimates what was chosen.
    if (pass == 1 && options.camera != CameraChoice::kFixed) {
      std::optional<PairEstimate> chosen;
      if (!result.stopped) {
        Advance(result, problem.batch);
        Activate(result.after, false, problem.batch);
        chosen = ChoosePair(problem.batch, batch_options);
      }
      if (!chosen) {
        // Poses so far belong to a camera whose parameters are not chosen yet, so the result is the given map.
        report.after = report.before;
        report.stopped = true;
        return report;
      }
      report.pair = *chosen;
      for (size_t i = 0; i < reference::kPairSize; ++i) {
        batch_options.pair_free[i] = report.pair.state[i] == PairState::kEstimated;
      }
      if (std::ranges::none_of(batch_options.pair_free, std::identity())) {
        // The camera is as given: so are the tracker's motions.
        batch_options.camera = CameraChoice::kFixed;
        problem = ProblemOf(stored, camera, report.pair.value, batch_options.camera);
        Activate(FitOf(problem.batch), true, problem.batch);
      }
      problem.batch.pair = report.pair.value;
      result = SolveOrThrow(problem.batch, batch_options);
    }
    Advance(result, problem.batch);
    Activate(result.after, false, problem.batch);
    pair = result.pair;
    Apply(problem, stored.map);
    report.after = MapFitOf(problem, result.after, stored.map);
    const StereoCamera estimated = EstimatedCamera(camera, pair);
    DropOutliers<PointType>(problem, problem.ids.points, problem.batch.point_active, estimated, stored);
    DropOutliers<LineType>(problem, problem.ids.lines, problem.batch.line_active, estimated, stored);
    ObservationSet after = ObservationsOf(stored.map);
    const int64_t changes = Changes(before, after);
    report.passes.push_back({result.cost_before, result.cost_after, result.iterations, result.seconds, changes});
    report.stopped = result.stopped;
    const bool few = pass > 1 && static_cast<double>(changes) <= kFewChanges * static_cast<double>(after.size());
    if (few || result.stopped || pass == kMaxPasses) break;
    before = std::move(after);
    MergeAll(estimated, stored);
  }
  const MapTotals totals = stored.map.Totals();
  report.after.points = totals.points;
  report.after.lines = totals.lines;
  problem = ProblemOf(stored, camera, pair, batch_options.camera);
  const BatchFit fit = FitOf(problem.batch);
  Activate(fit, false, problem.batch);
  if (!report.stopped) SetCovariances(problem, batch_options, stored, report);
  report.pair.value = pair;
  if (batch_options.camera != CameraChoice::kFixed) {
    const StereoCamera was = camera;
    camera = EstimatedCamera(camera, pair);
    // Focal length and principal point alone are in the new camera: pixels stay as they are.
    const auto is_zero = [](double parameter) { return parameter == 0.0; };
    if (!std::all_of(pair.begin() + reference::kRadial, pair.end(), is_zero)) {
      CorrectFeatures(pair, problem.ids.keyframes, problem.batch.twists, was, camera, stored.features);
    }
    stored.map.SetCamera(camera);
    stored.rig = CameraBytes(camera);
  }
  ++stored.version;
  stored.map.ForgetChanges();
  given = std::move(stored);
  return report;
}

}  // namespace plslam::refine
