// SPDX-License-Identifier: BSD-3-Clause
#include <nlohmann/json.hpp>

#include "tools/export/mcap/export_mcap.h"
#include "tools/export/mcap/ros_messages.h"

namespace plslam {
namespace {

using nlohmann::json;

json ScenePanel() {
  json topics = json::object();
  for (const char* topic : {"/map/points", "/map/lines", "/loops", "/path", "/path_truth", "/odom"}) {
    topics[topic] = {{"visible", true}};
  }
  topics["/map/points"].update({{"pointSize", 2}, {"colorMode", "rgb"}, {"colorField", "rgb"}});
  topics["/path"].update({{"type", "line"}, {"lineWidth", 0.02}, {"gradient", {"#6bdcec", "#6bdcec"}}});
  topics["/path_truth"].update({{"type", "line"}, {"lineWidth", 0.01}, {"gradient", {"#7fbf3f", "#7fbf3f"}}});
  for (const char* topic : {"/path_live", "/keyframes"}) topics[topic] = {{"visible", false}};
  topics["/camera/left/camera_info"] = {{"visible", true}, {"distance", 0.5}};
  return {{"followMode", "follow-none"},
          {"followTf", kRosWorld},
          {"scene", {{"transforms", {{"axisScale", 0.3}, {"labelSize", 0}}}}},
          {"topics", topics},
          {"layers", {{"grid", {{"layerId", "foxglove.Grid"}, {"instanceId", "grid"}, {"visible", true}}}}}};
}

json PlotPanel() {
  json paths = json::array();
  for (const char* path : {"/odom.twist.twist.linear.z", "/odom.twist.twist.angular.y"}) {
    paths.push_back({{"value", path}, {"enabled", true}, {"timestampMethod", "headerStamp"}});
  }
  return {{"paths", paths}, {"showLegend", true}, {"xAxisVal", "timestamp"}, {"isSynced", true}};
}

}  // namespace

std::string FoxgloveLayout() {
  const json image = {
      {"imageMode", {{"imageTopic", "/camera/left/compressed"}, {"calibrationTopic", "/camera/left/camera_info"}}}};
  const json side = {
      {"direction", "column"},
      {"first", "Image!plslam"},
      {"second", {{"direction", "column"}, {"first", "Plot!plslam"}, {"second", "DiagnosticSummary!plslam"}}},
      {"splitPercentage", 40}};
  const json layout = {
      {"configById",
       {{"3D!plslam", ScenePanel()},
        {"Image!plslam", image},
        {"Plot!plslam", PlotPanel()},
        {"DiagnosticSummary!plslam", {{"topicToRender", "/diagnostics"}}}}},
      {"globalVariables", json::object()},
      {"userNodes", json::object()},
      {"playbackConfig", {{"speed", 1}}},
      {"layout", {{"direction", "row"}, {"first", "3D!plslam"}, {"second", side}, {"splitPercentage", 65}}}};
  return layout.dump(2) + "\n";
}

}  // namespace plslam
