// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>

namespace CLI {
class App;
}

namespace plslam::calibration {

/// Adds `plslam calibration`, which reads the calibration of another program and writes a camera.yaml.
void AddCalibrationCommand(CLI::App* app, std::function<int()>* command);

/// Adds `plslam calibrate`, which calibrates a rig from pictures of a board.
void AddCalibrateCommand(CLI::App* app, std::function<int()>* command);

}  // namespace plslam::calibration
