// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <vector>

#include <Eigen/Core>

#include "core/features/features.h"
#include "core/features/matching/buckets.h"
#include "core/features/matching/hamming.h"
#include "core/features/options.h"

namespace plslam {

/// Position of a point in its image, and the size of a pixel of its octave.
struct CornerPlace {
  Eigen::Vector2d px = Eigen::Vector2d::Zero();
  double scale = 1.0;
};

/// Returns the positions of points of one image, or of stereo points in the left one, in their order.
template <class Point>
std::vector<CornerPlace> CornerPlacesOf(const std::vector<Point>& points) {
  std::vector<CornerPlace> corners;
  corners.reserve(points.size());
  for (const Point& point : points) corners.push_back({InLeftImage(point).px, InLeftImage(point).scale});
  return corners;
}

/// The points of one image in a grid, for fast queries by position. Copies the features. Skips points that are not
/// finite.
class PointGrid {
 public:
  /// A point as used in matching; `index` is that in the vector from which the grid was made.
  struct Entry {
    CornerPlace corner;
    float angle_rad = 0.0F;
    int octave = 0;
    int index = 0;
    Descriptor descriptor{};
  };

  PointGrid() = default;
  explicit PointGrid(const std::vector<PointFeature>& points);
  explicit PointGrid(std::span<const StereoPoint> points);
  /// Uses only points with `eligible` not zero; indices refer to all points.
  PointGrid(std::span<const StereoPoint> points, const std::vector<char>& eligible);

  /// Number of points from which the grid was made.
  int size() const { return size_; }

  /// Returns the indices of the points within `radius_px` (Euclidean) of `center_px`, ascending; none for a centre that
  /// is not finite.
  std::vector<int> Within(const Eigen::Vector2d& center_px, double radius_px) const;

  /// Calls `visit(entry)` for each point within `radius_px`; the order depends on the points only.
  template <class Visit>
  void ForEachWithin(const Eigen::Vector2d& center_px, double radius_px, const Visit& visit) const {
    const Cells cells = CellsAround(center_px, radius_px);
    for (int y = cells.y_begin; y < cells.y_end; ++y) {
      // Cells of one row are contiguous in memory.
      const auto row = static_cast<size_t>(y) * static_cast<size_t>(columns_);
      for (const Entry& entry :
           cells_.Range(row + static_cast<size_t>(cells.x_begin), row + static_cast<size_t>(cells.x_end))) {
        if ((entry.corner.px - center_px).squaredNorm() <= radius_px * radius_px) visit(entry);
      }
    }
  }

 private:
  struct Cells {
    int x_begin = 0, x_end = 0, y_begin = 0, y_end = 0;
  };
  void Build(const std::vector<Entry>& entries, size_t size);
  Cells CellsAround(const Eigen::Vector2d& center_px, double radius_px) const;

  Eigen::Vector2d origin_px_ = Eigen::Vector2d::Zero();
  double cell_size_px_ = 1.0;
  int size_ = 0;
  int columns_ = 0;
  int rows_ = 0;
  Buckets<Entry> cells_;
};

/// Predicted position and appearance of a known point in the current image.
struct PointQuery {
  Eigen::Vector2d px = Eigen::Vector2d::Zero();
  double radius_px = 0.0;
  /// Predicted octave; points up to `MatchOptions::octave_window` away are compared. Negative: any octave.
  int octave = -1;
  float angle_rad = 0.0F;
  Descriptor descriptor{};
};

/// Returns for each query the index of its match in the vector from which the grid was made, or -1.
///
/// The match is the point with the nearest descriptor within the radius and the octave window, if its distance is at
/// most `max_distance`, below `ratio` times that of the second best that is not the same corner in another octave
/// (within 1.5 pixels of the coarser one), if no other query is nearer to that point (mutual best; equal distances: the
/// lower query), and, with `check_rotation`, if its rotation agrees with most of the others.
std::vector<int> MatchPointsByProjection(const std::vector<PointQuery>& queries, const PointGrid& grid,
                                         const MatchOptions& options);

/// Returns for each descriptor of `a` the index of its match in `b`, or -1: mutual best over all pairs, with
/// `max_distance` and `ratio`. For recovery without a prediction. Works for points and lines. For points,
/// `corners_of_b` identifies the same corner in several octaves, which is no rival.
std::vector<int> MatchBruteForce(const std::vector<Descriptor>& a, const std::vector<Descriptor>& b,
                                 const MatchOptions& options, std::span<const CornerPlace> corners_of_b = {});

/// The same for points, with the optional check of rotations.
std::vector<int> MatchPointsBruteForce(const std::vector<PointFeature>& a, const std::vector<PointFeature>& b,
                                       const MatchOptions& options);

}  // namespace plslam
