// SPDX-License-Identifier: BSD-3-Clause
#include "viewer_headless/viewer_process.h"

#include <CLI/CLI.hpp>
#include <memory>
#include <optional>
#include <string>

#include "core/run/process_names.h"
#include "viewer_headless/node/viewer_node.h"

namespace plslam::viewer {

bus::ProcessSpec ViewerProcess() {
  struct Arguments {
    std::optional<std::string> out;
    std::optional<int64_t> overlay_every;
    std::optional<int64_t> serve;
    std::optional<std::string> video;
    bool force = false;
    bool no_report = false;
    bool quiet = false;
  };
  const auto arguments = std::make_shared<Arguments>();
  bus::ProcessSpec spec;
  spec.name = process_name::kViewer;
  spec.description =
      "Records a run: writes trajectories, tables, pictures and a report. No other process depends on it.";
  spec.examples =
      "  viewer_headless --out out/by_hand\n"
      "  viewer_headless --out out/by_hand --overlay-every 10 --serve 8080";
  spec.add_options = [arguments](CLI::App* app) {
    app->add_option("--out", arguments->out, "folder of the outputs")
        ->type_name("DIR")
        ->default_str(ViewerOptions{}.out);
    app->add_flag("--force", arguments->force, "replace the results of an earlier run in the folder");
    app->add_option("--overlay-every", arguments->overlay_every, "a picture of the features every N frames; 0: none")
        ->check(CLI::NonNegativeNumber)
        ->default_str("0");
    app->add_flag("--no-report", arguments->no_report, "no report.html");
    app->add_option("--serve", arguments->serve, "show the run live at http://127.0.0.1:PORT/ (this machine only)")
        ->check(CLI::Range(1, 65535))
        ->type_name("PORT");
    app->add_option("--video", arguments->video, "film of the run: an MP4 file, or a folder of pictures")
        ->type_name("FILE");
    app->add_flag("--quiet", arguments->quiet, "no progress line");
  };
  spec.make_node = [arguments](bus::Process& process, const Config& config) -> std::shared_ptr<void> {
    ViewerOptions options;
    config.Read("viewer", options);
    if (arguments->out) options.out = *arguments->out;
    if (arguments->overlay_every) options.overlay_every = *arguments->overlay_every;
    if (arguments->serve) options.serve = *arguments->serve;
    if (arguments->video) options.video = *arguments->video;
    options.report = options.report && !arguments->no_report;
    options.quiet = options.quiet || arguments->quiet;
    process.SetConfiguration(ToYaml("viewer", options));
    using Earlier = ViewerNode::Earlier;
    const Earlier by_hand = arguments->force ? Earlier::kReplace : Earlier::kRefuse;
    return std::make_shared<ViewerNode>(process, options, process.has_launcher() ? Earlier::kKeep : by_hand);
  };
  spec.waits_for = "poses of vo_process";
  spec.results = {{"frames", "frames"}, {"keyframes", "keyframes"}};
  return spec;
}

}  // namespace plslam::viewer
