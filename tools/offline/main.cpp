// SPDX-License-Identifier: BSD-3-Clause
#include <CLI/CLI.hpp>

#include "core/process/process_arguments.h"
#include "tools/calibration/calibration_command.h"
#include "tools/command_line/run_command_line.h"
#include "tools/command_line/version.h"
#include "tools/doctor/doctor_command.h"
#include "tools/export/export_command.h"
#include "tools/rectify_check/rectify_check_command.h"
#include "tools/refine/refine_command.h"

int main(int argc, char** argv) {
  CLI::App app("Commands of plslam on maps, recordings and cameras; plslam starts this program for them.", "plslam");
  app.set_version_flag("--version", plslam::VersionText());
  app.require_subcommand(1);
  std::function<int()> command;
  for (const auto add : {plslam::exports::AddExportCommand, plslam::refine::AddRefineCommand,
                         plslam::doctor::AddDoctorCommand, plslam::rectify_check::AddRectifyCheckCommand,
                         plslam::calibration::AddCalibrationCommand, plslam::calibration::AddCalibrateCommand}) {
    add(&app, &command);
  }
  plslam::bus::SetUpLogging("plslam");  // log lines are kept apart from the output of a command
  return plslam::RunCommandLine(app, argc, argv, [&] { return command(); });
}
