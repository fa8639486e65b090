// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "vo_process/stereo/halved_pair.h"
#include "vo_process/stereo/row_field.h"

namespace plslam::vo {

/// The best match of the patch of a left pixel in a row of the right image, at pixel accuracy of its level, and its
/// normalised correlation. At whole pixels the correlation is lower than at the true disparity, so equal matches of a
/// repeated texture may differ by 0.5 here.
struct RowMatch {
  double disparity_px = 0.0;
  double correlation = 0.0;
  /// The best other match outside the peak; 0 and 0 if there is none.
  double second_disparity_px = 0.0;
  double second_correlation = 0.0;
};

/// Stereo for points whose right corner was not detected: normalised correlation of 11x11 patches over a range of
/// disparities, in integers up to the final comparison.
class RowSearch {
 public:
  /// `pair` must outlive the search. The row follows from `rows` at small disparity, rounded to a pixel of the level.
  explicit RowSearch(const HalvedPair& pair, const RowField& rows = {}) : pair_(&pair), rows_(rows) {}

  /// Returns nullopt if the patch leaves the left image, has no contrast, or correlates nowhere.
  std::optional<RowMatch> Find(const Eigen::Vector2d& left_px, double scale, double min_disparity_px,
                               double max_disparity_px);

 private:
  const HalvedPair* pair_;
  RowField rows_;
  // Scratch: the rows of the right image as 16 bits, and for each position its product with the left patch, sum, and
  // sum of squares.
  std::vector<int16_t> strip_;
  std::vector<int> cross_;
  std::vector<int> sum_;
  std::vector<int> square_;
  std::vector<float> score_;
};

}  // namespace plslam::vo
