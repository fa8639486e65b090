// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "core/datasets/synthetic/sensor_faults.h"
#include "tests/support/changed_images.h"

namespace plslam::test {

/// A dataset whose inertial sensor has a fault, by its name in the synthetic worlds and its size.
class FaultySensor : public ChangedImages {
 public:
  FaultySensor(const Dataset& dataset, const std::string& name, double size)
      : ChangedImages(dataset), rig_(dataset.rig()), samples_(dataset.ImuSamples()) {
    const synthetic::SensorFault* fault = synthetic::FindSensorFault(name);
    if (fault == nullptr) throw DatasetError("unknown fault of an inertial sensor '" + name + "'");
    if (rig_.imu && !samples_.empty()) fault->apply(size, 1, samples_, *rig_.imu);
  }

  StereoImages Read(int index) const override { return dataset_.Read(index); }
  const RigCalibration& rig() const override { return rig_; }
  const std::vector<ImuSample>& ImuSamples() const override { return samples_; }

 private:
  RigCalibration rig_;
  std::vector<ImuSample> samples_;
};

}  // namespace plslam::test
