// SPDX-License-Identifier: BSD-3-Clause
#include "viewer_headless/report/observers.h"

#include <algorithm>
#include <cmath>

namespace plslam {
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
  int64_t last_id = -1;
  int32_t last_first = 0;
  for (const Landmark* landmark : landmarks) {
    std::vector<int32_t> observers;
    for (const Observation& observation : landmark->observations) {
      if (const auto row = rows.find(observation.keyframe_id); row != rows.end()) observers.push_back(row->second);
    }
    AppendNumber(static_cast<uint64_t>(landmark->id - last_id), bytes);
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

}  // namespace plslam
