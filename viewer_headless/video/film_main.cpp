// SPDX-License-Identifier: BSD-3-Clause
#include <gst/gst.h>
#include <signal.h>

#include <CLI/CLI.hpp>
#include <cstdio>

#include "core/config/command_line_error.h"
#include "core/errors/standard_streams.h"
#include "plslam_version.h"
#include "viewer_headless/video/film_writer.h"

int main(int argc, char** argv) {
  CLI::App app(
      "Writes the film of a run: started by viewer_headless --video, reads the pictures from standard input.",
      "plslam_film");
  app.set_version_flag("--version", PLSLAM_VERSION);
  std::string file;
  app.add_option("FILE", file, "the film, ending in .mp4")->required()->check([](const std::string& name) {
    return name.ends_with(".mp4") ? std::string() : name + " does not end in .mp4";
  });
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    if (e.get_exit_code() == 0) return plslam::FlushOutput(app.get_name(), app.exit(e));
    plslam::PrintError(app.get_name() + ": error: " + plslam::CommandLineError(app, e, argc, argv));
    return 1;
  }
  // It ends when its input ends: a signal to all of a group lets the viewer finish the film. A file that may not grow
  // is an error like a full disk.
  for (const int number : {SIGINT, SIGTERM, SIGHUP, SIGPIPE, SIGXFSZ}) signal(number, SIG_IGN);
  gst_init(nullptr, nullptr);
  return plslam::FlushOutput("plslam_film", plslam::viewer::WriteFilm(file, stdin, stdout));
}
