// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "dense_process/products.h"
#include "tools/command_line/run_command_line.h"
#include "tools/surfaces/surfaces.h"

int main(int argc, char** argv) {
  CLI::App app("Writes the surfaces of a saved map as files; plslam export starts this program for them.",
               "plslam_surfaces");
  plslam::surfaces::SurfacesRequest request;
  std::vector<std::string> kinds;
  for (const auto& [name, kind] : plslam::dense::kProductKinds) kinds.emplace_back(name);
  request.kinds = kinds;
  app.add_option("map", request.map, "map file (.plmap) with its surfaces beside it (.plmap.surfaces)")->required();
  app.add_option("--out", request.out, "folder to write to")->type_name("DIR")->required();
  app.add_option("--format", request.kinds, "only these files, separated by blanks or commas [all]")
      ->delimiter(',')
      ->check(CLI::IsMember(kinds));
  app.add_option("--robot-height", request.robot_height_m,
                 "obstacles of the grid are between 0.1 m and this height above the floor, in m")
      ->check(CLI::Range(0.2, 10.0))
      ->default_str("that of the run");
  app.add_option("--up", request.up_c,
                 "X Y Z: up of the mounted camera in its own frame (x right, y down, z forward) [that of the run, or "
                 "the vertical of the map]")
      ->expected(3)
      ->type_name("NUMBER");
  return plslam::RunCommandLine(app, argc, argv, [&] {
    for (const std::string& file : plslam::surfaces::WriteSurfaces(request)) fmt::print("{}\n", file);
    return 0;
  });
}
