// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

namespace plslam {

/// A format of datasets.
struct DatasetKind {
  std::string name;  ///< "kitti"
  std::string sign;  ///< by which it is found: "calib.txt with image_0 or image_2"
  std::string what;  ///< "KITTI odometry"
  bool is_folder = true;
};

/// Returns all kinds, in the order in which they are tried.
const std::vector<DatasetKind>& DatasetKinds();
/// The playable datasets, and the names of the kinds, for help texts.
std::string DatasetHelp();
std::string DatasetKindHelp();

}  // namespace plslam
