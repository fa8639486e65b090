#pragma once

#include <functional>

namespace CLI {
class App;
}

namespace plslam {

/// Adds `plslam calibration`, which reads the calibration of another program and writes a camera.yaml.
void AddCalibrationCommand(CLI::App* app, std::function<int()>* command);

}  // namespace plslam
