// SPDX-License-Identifier: BSD-3-Clause
#include "viewer_headless/report/map_tables.h"

#include <algorithm>
#include <cmath>
#include <map>

#include <fmt/format.h>

namespace plslam::viewer {
namespace {

constexpr double kLeastSigma_m = 1e-4;
constexpr double kStep = 1.05;

void AppendNumber(uint64_t number, std::string& bytes) {
  for (; number >= 128; number >>= 7) bytes += static_cast<char>(128 | (number & 127));
  bytes += static_cast<char>(number);
}

void AppendDifference(int64_t difference, std::string& bytes) {
  AppendNumber(static_cast<uint64_t>(difference >= 0 ? 2 * difference : -2 * difference - 1), bytes);
}

}  // namespace

template <class Landmark>
std::string PackObservers(const std::vector<const Landmark*>& landmarks, const RowOfKeyframe& rows) {
  std::string bytes;
  LandmarkId last_id;
  int32_t last_first = 0;
  for (const Landmark* landmark : landmarks) {
    std::vector<int32_t> observers;
    for (const Observation& observation : landmark->observations) {
      if (const auto row = rows.find(observation.keyframe_id()); row != rows.end()) observers.push_back(row->second);
    }
    AppendNumber(static_cast<uint64_t>(landmark->id.value - last_id.value), bytes);
    last_id = landmark->id;
    AppendNumber(observers.size(), bytes);
    if (observers.empty()) continue;
    AppendDifference(observers.front() - last_first, bytes);
    last_first = observers.front();
    for (size_t i = 1; i < observers.size(); ++i) {
      AppendNumber(static_cast<uint64_t>(observers[i] - observers[i - 1]), bytes);
    }
  }
  return bytes;
}

template std::string PackObservers(const std::vector<const MapPoint*>&, const RowOfKeyframe&);
template std::string PackObservers(const std::vector<const MapLine*>&, const RowOfKeyframe&);

uint8_t PackSigma(double sigma_m) {
  if (!std::isfinite(sigma_m) || sigma_m <= 0.0) return 0;
  const double steps = std::log(sigma_m / kLeastSigma_m) / std::log(kStep);
  return static_cast<uint8_t>(std::lround(std::clamp(1.0 + steps, 1.0, 255.0)));
}

namespace {

/// The frame of the first keyframe that sees it and is still there; -1: none.
int32_t FirstSeen(const Map& map, const std::vector<Observation>& observations) {
  for (const Observation& observation : observations) {
    if (const MapKeyframe* keyframe = map.FindKeyframe(observation.keyframe_id()))
      return Clamp32(keyframe->frame_id.value);
  }
  return -1;
}

/// From there to the frame of the last keyframe that observes the landmark.
uint16_t Life_frames(const Map& map, const std::vector<Observation>& observations, int32_t first) {
  for (auto observation = observations.rbegin(); observation != observations.rend(); ++observation) {
    const MapKeyframe* keyframe = map.FindKeyframe(observation->keyframe_id());
    if (keyframe != nullptr)
      return static_cast<uint16_t>(std::clamp<int64_t>(keyframe->frame_id.value - first, 0, 65535));
  }
  return 0;
}

/// Returns the displayed landmarks, by id; those with most observations if there are too many.
template <class Landmark>
std::vector<const Landmark*> Choose(const IdMap<LandmarkId, Landmark>& landmarks, size_t limit) {
  std::vector<const Landmark*> chosen;
  chosen.reserve(landmarks.size());
  for (const auto& [id, landmark] : landmarks) chosen.push_back(&landmark);
  if (chosen.size() <= limit) return chosen;
  std::stable_sort(chosen.begin(), chosen.end(),
                   [](const auto* a, const auto* b) { return a->observations.size() > b->observations.size(); });
  chosen.resize(limit);
  std::sort(chosen.begin(), chosen.end(), [](const auto* a, const auto* b) { return a->id < b->id; });
  return chosen;
}

void AppendPositions(const MapPoint& point, std::vector<float>& values) { Append(point.p_w, values); }
void AppendPositions(const MapLine& line, std::vector<float>& values) {
  Append(line.segment_w.p, values);
  Append(line.segment_w.q, values);
}

double Sigma_m(const MapPoint& point) { return std::sqrt(point.covariance.matrix().trace()); }
/// The position along the line is not measured.
double Sigma_m(const MapLine& line) {
  const Eigen::Vector3d d = (line.segment_w.q - line.segment_w.p).normalized();
  const Eigen::Matrix3d mean = 0.5 * (line.covariance_p.matrix() + line.covariance_q.matrix());
  return std::sqrt(mean.trace() - d.dot(mean * d));
}

template <class Landmark>
Table LandmarkTable(const Map& map, const std::vector<const Landmark*>& landmarks, const std::string& name,
                    int width) {
  std::vector<float> positions;
  std::vector<int32_t> seen;
  std::vector<uint16_t> life;
  std::vector<uint8_t> observations, sigma;
  for (const Landmark* landmark : landmarks) {
    AppendPositions(*landmark, positions);
    seen.push_back(FirstSeen(map, landmark->observations));
    life.push_back(Life_frames(map, landmark->observations, seen.back()));
    observations.push_back(static_cast<uint8_t>(std::min<size_t>(255, landmark->observations.size())));
    sigma.push_back(PackSigma(Sigma_m(*landmark)));
  }
  return {{name, width, std::move(positions)},
          {"seen", 1, std::move(seen)},
          {"life", 1, std::move(life)},
          {"observations", 1, std::move(observations)},
          {"sigma", 1, std::move(sigma)}};
}

Table KeyframeTable(const Map& map, const RowOfKeyframe& rows) {
  std::vector<int32_t> id, frame, parent;
  std::vector<float> p, q, sigma_m;
  for (const auto& [keyframe_id, keyframe] : map.keyframes()) {
    id.push_back(Clamp32(keyframe_id.value));
    frame.push_back(Clamp32(keyframe.frame_id.value));
    const auto row = rows.find(keyframe.parent_id);
    parent.push_back(row == rows.end() ? -1 : row->second);
    Append(keyframe.T_w_kf.translation(), p);
    Append(keyframe.T_w_kf.rotation().coeffs(), q);
    sigma_m.push_back(static_cast<float>(std::sqrt(keyframe.covariance.topLeftCorner<3, 3>().trace())));
  }
  return {{"id", 1, std::move(id)}, {"frame", 1, std::move(frame)}, {"parent", 1, std::move(parent)},
          {"p", 3, std::move(p)},   {"q", 4, std::move(q)},         {"sigma_m", 1, std::move(sigma_m)}};
}

struct Edge {
  int32_t a;
  int32_t b;
  int32_t shared;
};

std::vector<Edge> CovisibilityEdges(const Map& map, const RowOfKeyframe& rows) {
  std::vector<Edge> edges;
  for (const auto& [id, row] : rows) {
    for (const Map::Neighbour& neighbour : map.Neighbours(id, Map::kCovisible)) {
      if (neighbour.keyframe_id > id) edges.push_back({row, rows.at(neighbour.keyframe_id), neighbour.shared});
    }
  }
  std::stable_sort(edges.begin(), edges.end(), [](const Edge& a, const Edge& b) { return a.shared > b.shared; });
  return edges;
}

Table EdgeTable(const std::vector<Edge>& edges) {
  std::vector<int32_t> ab, shared;
  for (const Edge& edge : edges) {
    ab.insert(ab.end(), {edge.a, edge.b});
    shared.push_back(edge.shared);
  }
  return {{"ab", 2, std::move(ab)}, {"shared", 1, std::move(shared)}};
}

Table LoopTable(const Map& map, const RowOfKeyframe& rows) {
  std::vector<int32_t> ab;
  for (const LoopEdge& loop : map.loops()) {
    const auto a = rows.find(loop.old_keyframe_id), b = rows.find(loop.keyframe_id);
    if (a != rows.end() && b != rows.end()) ab.insert(ab.end(), {a->second, b->second});
  }
  return {{"ab", 2, std::move(ab)}};
}

void Note(size_t shown, size_t all, const char* what, std::vector<std::string>* notes) {
  if (shown < all) notes->push_back(fmt::format("{} of {} {} are shown.", shown, all, what));
}

}  // namespace

ReportMap MapTables(const Map& map, const MapLimits& limits, std::vector<std::string>* notes) {
  RowOfKeyframe rows;
  for (const auto& [id, keyframe] : map.keyframes()) rows.emplace(id, static_cast<int32_t>(rows.size()));
  const auto points = Choose(map.points(), limits.points);
  const auto segments = Choose(map.lines(), limits.segments);
  std::vector<Edge> edges = CovisibilityEdges(map, rows);
  Note(points.size(), map.points().size(), "points of the map, those with the most observations,", notes);
  Note(segments.size(), map.lines().size(), "segments of the map, those with the most observations,", notes);
  Note(std::min(limits.edges, edges.size()), edges.size(), "covisibility edges, the strongest,", notes);
  edges.resize(std::min(limits.edges, edges.size()));
  ReportMap tables{LandmarkTable(map, points, "p", 3),
                   LandmarkTable(map, segments, "pq", 6),
                   KeyframeTable(map, rows),
                   EdgeTable(edges),
                   LoopTable(map, rows),
                   VerticalOf(map),
                   {PackObservers(points, rows), PackObservers(segments, rows)}};
  const size_t bytes = tables.observers.points.size() + tables.observers.segments.size();
  if (bytes > limits.observer_bytes) {
    notes->push_back(fmt::format("Observations of landmarks are omitted: {:.1f} MB exceed {:.1f} MB.",
                                 1e-6 * static_cast<double>(bytes),
                                 1e-6 * static_cast<double>(limits.observer_bytes)));
    // The id identifies the landmark in the next map of a live page.
    tables.observers = {PackObservers(points, {}), PackObservers(segments, {}), true};
  }
  return tables;
}

}  // namespace plslam::viewer
