// SPDX-License-Identifier: BSD-3-Clause
#include "camera/command_line.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>

#include "camera/pipeline_text.h"
#include "camera/rig_file.h"
#include "core/errors/error_text.h"
#include "core/stream/pacing.h"

namespace plslam::camera {

void CameraCommandLine::AddTo(void* app) {
  auto& cli = *static_cast<CLI::App*>(app);
  cli.add_option("RIG", rig_, "rig file: the keys of camera.yaml, and `source` (docs/datasets.md)");
  cli.add_option("--pace", pace_, "realtime (default); lockstep for files, where each frame waits for the last pose");
  cli.add_flag("--resume", resume_, "continue after the frames that have a pose on the bus: after a crash");
  cli.add_flag("--exit", exit_, "exit when all frames of a finite source are sent and acknowledged");
  // Exits like --version: no bus is needed for it.
  cli.add_flag_callback(
      "--print-pipeline",
      [this] {
        if (!rig_) throw CLI::RequiredError("RIG");
        try {
          fmt::print("{}\n", PipelineText(ReadRigFileForPipeline(*rig_)));
        } catch (const std::exception& error) {
          throw CLI::ValidationError(SentenceOf(error));
        }
        throw CLI::Success();
      },
      "print the GStreamer pipeline of the rig file, as a start for a `source.pipeline`, and exit; the cameras need "
      "no calibration for it");
}

CameraOptions CameraCommandLine::Options(const Config& config) const {
  CameraOptions options;
  config.Read("camera", options);
  if (rig_) options.rig = *rig_;
  if (pace_) options.pace = *pace_;
  options.exit |= exit_;
  if (resume_) options.resume_after = stream::kResumeFromBus;
  return options;
}

}  // namespace plslam::camera
