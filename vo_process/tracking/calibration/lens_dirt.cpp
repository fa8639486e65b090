// SPDX-License-Identifier: BSD-3-Clause
#include "vo_process/tracking/calibration/lens_dirt.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

namespace plslam::vo {
namespace {

constexpr int kCell_px = DirtCells::kCell_px;
// Distance up to which a corner stays: detection repeats corners to about half a pixel.
constexpr double kSame_px = 0.75;
// Distance from a dirty corner that counts as dirt.
constexpr double kReach_px = 10.0;
constexpr int kReach = 2;  // in cells
// Number of frames after which a standing camera gets another reference; a moving one gets it with each image.
constexpr int kMostFrames = 20;
// Share of the matched corners that stay, below which the camera has moved (or half that of the others: a standing
// camera repeats matched corners better), and the least number of matched corners.
constexpr double kStandingShare = 0.35;
constexpr int kMinMatched = 20;
// Gain of a corner that stays if all unmatched ones do, and none of the matched ones; loss of one that is not seen.
constexpr double kEvidenceGain = 10.0;
constexpr float kEvidenceLoss = 0.3F;
// Gain, at least, while no more than this share of the matched corners stays: chance repeats no corner for long.
constexpr double kLeastGain = 0.2;
constexpr double kClearlyMovingShare = 0.05;
// Standard deviations by which the shares must differ.
constexpr double kSigmas = 2.0;
// Evidence above which a corner is dirt, and its bound, which lets a cleaned lens be forgotten.
constexpr float kDirty = 2.5F;
constexpr float kMostEvidence = 10.0F;
// Half the width of the window, in cells, in which the largest spot is searched.
constexpr int kSpotReach = 3;

PointGrid GridOf(const std::vector<LensCorner>& corners) {
  std::vector<PointFeature> points(corners.size());
  for (size_t i = 0; i < corners.size(); ++i) points[i].px = corners[i].px;
  return PointGrid(points);
}

/// Returns the first corner within `kSame_px`; nullptr if there is none.
const LensCorner* CornerAt(const Eigen::Vector2d& px, const PointGrid& grid, const std::vector<LensCorner>& corners) {
  int first = grid.size();
  grid.ForEachWithin(px, kSame_px, [&first](const PointGrid::Entry& entry) { first = std::min(first, entry.index); });
  return first < grid.size() ? &corners[static_cast<size_t>(first)] : nullptr;
}

}  // namespace

LensDirt::LensDirt(const StereoCamera& camera)
    : columns_((camera.width_px + kCell_px - 1) / kCell_px), rows_((camera.height_px + kCell_px - 1) / kCell_px) {}

int LensDirt::CellOf(const Eigen::Vector2d& px) const {
  const int column = std::clamp(static_cast<int>(px.x()) / kCell_px, 0, columns_ - 1);
  const int row = std::clamp(static_cast<int>(px.y()) / kCell_px, 0, rows_ - 1);
  return row * columns_ + column;
}

void LensDirt::Observe(const std::vector<LensCorner>& corners) {
  ++reference_frames_;
  const PointGrid grid = GridOf(corners);
  struct Count {
    int all = 0;
    int stay = 0;
    double Share() const { return static_cast<double>(stay) / std::max(all, 1); }
    double Variance() const { return Share() * (1.0 - Share()) / std::max(all, 1); }
  };
  Count matched;
  Count unmatched;
  for (const Corner& corner : reference_) {
    if (IsOnDirt({corner.u_px, corner.v_px})) continue;
    Count& count = corner.is_matched ? matched : unmatched;
    ++count.all;
    count.stay += CornerAt({corner.u_px, corner.v_px}, grid, corners) != nullptr;
  }
  const bool has_moved =
      matched.all >= kMinMatched && matched.Share() <= std::max(kStandingShare, 0.5 * unmatched.Share());
  if (has_moved) {
    const double excess =
        unmatched.Share() - matched.Share() - kSigmas * std::sqrt(matched.Variance() + unmatched.Variance());
    const double least = matched.Share() <= kClearlyMovingShare ? kLeastGain : 0.0;
    Learn(grid, corners, static_cast<float>(std::max(least, kEvidenceGain * excess)));
  }
  if (!has_moved && reference_frames_ < kMostFrames && matched.all >= kMinMatched) return;
  reference_frames_ = 0;
  reference_.clear();
  for (const LensCorner& corner : corners) {
    reference_.push_back({static_cast<float>(corner.px.x()), static_cast<float>(corner.px.y()), corner.is_matched});
  }
}

/// Updates the evidence of all spots from an image after the camera has moved.
void LensDirt::Learn(const PointGrid& grid, const std::vector<LensCorner>& corners, float gain) {
  for (const Corner& corner : reference_) {
    const Eigen::Vector2d px(corner.u_px, corner.v_px);
    const LensCorner* now = corner.is_matched || IsOnDirt(px) ? nullptr : CornerAt(px, grid, corners);
    if (now != nullptr && !now->is_matched) spots_.try_emplace(CellOf(px), Spot{corner.u_px, corner.v_px});
  }
  for (auto& [cell, spot] : spots_) {
    const LensCorner* now = CornerAt({spot.u_px, spot.v_px}, grid, corners);
    spot.evidence += now != nullptr && !now->is_matched ? gain : -kEvidenceLoss;
    spot.evidence = std::min(spot.evidence, kMostEvidence);
    spot.is_dirt |= spot.evidence >= kDirty;
  }
  std::erase_if(spots_, [](const auto& entry) { return entry.second.evidence <= 0.0F; });
}

template <class Visit>
void LensDirt::ForEachDirtAround(int cell, int reach, const Visit& visit) const {
  const int left = std::max(cell % columns_ - reach, 0);
  const int right = std::min(cell % columns_ + reach, columns_ - 1);
  for (int row = cell / columns_ - reach; row <= cell / columns_ + reach; ++row) {
    const auto end = spots_.upper_bound(row * columns_ + right);
    for (auto it = spots_.lower_bound(row * columns_ + left); it != end; ++it) {
      if (it->second.is_dirt) visit(it->second);
    }
  }
}

bool LensDirt::IsOnDirt(const Eigen::Vector2d& px) const {
  if (spots_.empty()) return false;
  bool is_near = false;
  ForEachDirtAround(CellOf(px), kReach, [&](const Spot& spot) {
    is_near |= (px - Eigen::Vector2d(spot.u_px, spot.v_px)).squaredNorm() < kReach_px * kReach_px;
  });
  return is_near;
}

DirtCells LensDirt::Cells() const {
  if (!HasDirt()) return {};
  std::vector<char> cells(static_cast<size_t>(columns_) * static_cast<size_t>(rows_), 0);
  for (const auto& [cell, spot] : spots_) {
    if (!spot.is_dirt) continue;
    for (int row = std::max(cell / columns_ - kReach, 0); row <= std::min(cell / columns_ + kReach, rows_ - 1);
         ++row) {
      for (int column = std::max(cell % columns_ - kReach, 0);
           column <= std::min(cell % columns_ + kReach, columns_ - 1); ++column) {
        const Eigen::Vector2d middle_px((column + 0.5) * kCell_px, (row + 0.5) * kCell_px);
        if ((middle_px - Eigen::Vector2d(spot.u_px, spot.v_px)).squaredNorm() >= kReach_px * kReach_px) continue;
        cells[static_cast<size_t>(row) * static_cast<size_t>(columns_) + static_cast<size_t>(column)] = 1;
      }
    }
  }
  return {std::move(cells), columns_};
}

double LensDirt::CoveredShare() const {
  const auto n = std::count_if(spots_.begin(), spots_.end(), [](const auto& entry) { return entry.second.is_dirt; });
  return static_cast<double>(n) / (columns_ * rows_);
}

Eigen::Vector2d LensDirt::Place_px() const {
  const Spot* best = nullptr;
  int most = 0;
  for (const auto& [cell, spot] : spots_) {
    int n = 0;
    if (spot.is_dirt) ForEachDirtAround(cell, kSpotReach, [&n](const Spot&) { ++n; });
    if (n > most) {
      most = n;
      best = &spot;
    }
  }
  return best == nullptr ? Eigen::Vector2d::Zero() : Eigen::Vector2d(best->u_px, best->v_px);
}

}  // namespace plslam::vo
