// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>

#include "core/datasets/dataset.h"

namespace plslam::test {

/// A dataset of which everything but the images is that of another, which is kept by reference.
class ChangedImages : public Dataset {
 public:
  explicit ChangedImages(const Dataset& dataset) : dataset_(dataset) {}

  std::string name() const override { return dataset_.name(); }
  const RigCalibration& rig() const override { return dataset_.rig(); }
  int size() const override { return dataset_.size(); }
  int64_t t_ns(int index) const override { return dataset_.t_ns(index); }
  const std::vector<ImuSample>& ImuSamples() const override { return dataset_.ImuSamples(); }
  std::optional<SE3> GroundTruth(int index) const override { return dataset_.GroundTruth(index); }

 protected:
  const Dataset& dataset_;
};

}  // namespace plslam::test
