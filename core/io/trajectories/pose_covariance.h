// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/files/atomic_file.h"
#include "core/geometry/se3.h"

namespace plslam {

/// Covariance of the pose (or motion) of a trajectory at a time, of the right perturbation [translation_m;
/// rotation_rad] in the moving frame: `T_true = T * Exp(x)`.
struct PoseCovariance {
  int64_t t_ns = 0;
  Matrix6d covariance = Matrix6d::Zero();
};

/// Rows of `t` in seconds and the 36 numbers of the covariance, row by row, separated by blanks; lines that begin with
/// # are comments. Times increase. Throws std::runtime_error with file, line and value, also if a covariance is not
/// symmetric or has a negative variance.
std::vector<PoseCovariance> ReadPoseCovariances(const std::string& path);

/// Writes covariances one by one, as an AtomicFile. Reading gives the same bits. Throws std::runtime_error if the file
/// cannot be written.
class PoseCovarianceWriter {
 public:
  explicit PoseCovarianceWriter(const std::string& path);
  void Add(const PoseCovariance& row);
  void PutInPlace() { file_.PutInPlace(); }

 private:
  AtomicFile file_;
};

/// Writes all with a PoseCovarianceWriter.
void WritePoseCovariances(const std::string& path, const std::vector<PoseCovariance>& covariances);

}  // namespace plslam
