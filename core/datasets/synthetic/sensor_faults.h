// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/geometry/calibration.h"
#include "core/geometry/imu.h"

namespace plslam::synthetic {

/// A fault of an inertial sensor, or of its description.
struct SensorFault {
  std::string name;
  /// Size of the fault, which `Options::imu_fault_size` replaces, and its bounds; a fault without a size has 0 to 0.
  double size = 0.0;
  double low = 0.0;
  double high = 0.0;
  void (*apply)(double size, uint64_t seed, std::vector<ImuSample>& samples, ImuCalibration& stated) = nullptr;
};

/// All faults, in the order of the documentation.
const std::vector<SensorFault>& SensorFaults();

/// Returns the fault of this name; nullptr if there is none.
const SensorFault* FindSensorFault(const std::string& name);

}  // namespace plslam::synthetic
