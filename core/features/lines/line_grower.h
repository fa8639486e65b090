// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "core/features/image/gradients.h"
#include "core/features/lines/line_detector.h"

namespace plslam {

/// Marks in an edge map.
enum EdgeMark : uint8_t {
  kNoEdge = 0,
  kSteepEdge = 1,  ///< |dx| >= |dy|: peak of |dx| along its row.
  kFlatEdge = 2,   ///< |dy| > |dx|: peak of |dy| along its column.
  kUsedEdge = 4,   ///< Part of a segment.
  kTriedEdge = 8,  ///< Part of a failed segment; no seed any more.
};

/// Computes thin edges: pixels whose larger gradient component is at least `threshold` and a peak along its own axis.
/// The outermost two pixels on each side are never marked. `out` is CV_8UC1 of the size of the gradients.
void ComputeEdgeMap(const Gradients& gradients, int threshold, cv::Mat& out);

/// Grows straight segments along the thin edges of an edge map.
///
/// From a seed it steps along the axis that the edge follows more closely ("major"; rows for steep edges), first from
/// neighbour to neighbour, then along the line fitted so far, collecting edge pixels on it whose gradient is across it,
/// over gaps of a few steps. Each pixel's position across the edge is the peak of a parabola through three gradients;
/// the segment is the weighted least-squares line through them, without outliers.
class LineGrower {
 public:
  /// All three must outlive the grower; pixels of segments are marked as used in `edges`.
  LineGrower(const Gradients& gradients, cv::Mat& edges, double min_contrast);

  /// Returns the segment through the edge pixel (x, y), or nullopt if none is straight and dense enough.
  std::optional<DetectedSegment> Grow(int x, int y);

 private:
  /// A pixel of the edge: integer step along the major axis, position along the minor one.
  struct Sample {
    int major;
    int minor;
    double place;
    double strength;
  };

  /// Running weighted sums of a line place = a + b * (major - origin).
  struct Fit {
    double n = 0, m = 0, p = 0, mm = 0, mp = 0;
    double a = 0, b = 0;
    void Add(double major, double place, double weight);
    bool Solve();
  };

  int Offset(int major, int minor) const { return major * major_stride_ + minor * minor_stride_; }
  int EdgeOffset(int major, int minor) const { return major * edge_major_stride_ + minor * edge_minor_stride_; }
  Sample Locate(int major, int minor) const;
  bool Agrees(int offset) const;
  void SetAxes(bool steep);

  bool WalkFromSeed(int major, int minor);
  bool WalkOneWay(int major, int step, int* minors) const;
  bool StraightSoFar();
  void Extend(int step);
  bool TakeNear(int major, double place, double tolerance, std::vector<Sample>& out);
  std::optional<DetectedSegment> Finish();
  bool FitWithoutOutliers();
  void TrimEnds();

  const int16_t* dx_;
  const int16_t* dy_;
  uint8_t* edges_;
  int stride_;
  int edge_stride_;
  int width_;
  int height_;
  double min_contrast_;

  // State of the growing segment:
  bool steep_ = true;
  const int16_t* across_ = nullptr;
  const int16_t* along_ = nullptr;
  int major_stride_ = 0, minor_stride_ = 0, edge_major_stride_ = 0, edge_minor_stride_ = 0;
  int major_size_ = 0, minor_size_ = 0;
  int origin_ = 0;
  double sign_ = 1.0;
  double slope_ = 0.0;
  std::vector<Sample> samples_;
  std::vector<Sample> scratch_;
  std::vector<Sample> tried_;
  Fit fit_;
};

}  // namespace plslam
