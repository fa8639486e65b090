// SPDX-License-Identifier: BSD-3-Clause
#include "camera/pipeline_text.h"

#include <fmt/format.h>

#include <cmath>

namespace plslam::camera {
namespace {

constexpr const char* kToGrey = "videoconvert ! video/x-raw,format=GRAY8";

/// As a value of a property.
std::string Quoted(const std::string& text) {
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') quoted += '\\';
    quoted += c;
  }
  return quoted + "\"";
}

/// "width=752,height=480,framerate=20/1"; the driver chooses the rate where the rig names none, or one that is no
/// whole number.
std::string SizeAndRate(const RigCalibration& rig, const CameraCalibration& camera, int width_px) {
  std::string text = fmt::format("width={},height={}", width_px, camera.height_px);
  const bool whole = rig.rate_hz >= 1.0 && rig.rate_hz == std::floor(rig.rate_hz);
  return whole ? fmt::format("{},framerate={}/1", text, static_cast<int>(rig.rate_hz)) : text;
}

/// USB cameras give high rates as JPEG only.
std::string VideoDevice(const std::string& device, const std::string& size) {
  return fmt::format("v4l2src device={} ! capsfilter caps=\"video/x-raw,{};image/jpeg,{}\" ! decodebin ! {}",
                     Quoted(device), size, size, kToGrey);
}

std::string SideBySide(const LiveRig& live) {
  const int width = live.rig.left.width_px;
  return fmt::format(
      "{} ! tee name=both\n"
      "both. ! queue ! videocrop right={} ! appsink name={}\n"
      "both. ! queue ! videocrop left={} ! appsink name={}",
      VideoDevice(live.source.inputs[0], SizeAndRate(live.rig, live.rig.left, 2 * width)), width, kLeftSink, width,
      kRightSink);
}

std::string OneCamera(const LiveRig& live, const std::string& input, const CameraCalibration& camera) {
  const std::string size = SizeAndRate(live.rig, camera, camera.width_px);
  switch (live.source.type) {
    case SourceSpec::Type::kGige:
      // Without do-timestamp each camera counts from its own first image, and the two could not be compared.
      return fmt::format("aravissrc camera-name={} do-timestamp=true ! video/x-raw,{} ! {}", Quoted(input), size,
                         kToGrey);
    case SourceSpec::Type::kFiles:
      return fmt::format("filesrc location={} ! decodebin ! {}", Quoted(input), kToGrey);
    case SourceSpec::Type::kRtsp:
      return fmt::format("rtspsrc location={} latency=0 ! application/x-rtp,media=video ! decodebin ! {}",
                         Quoted(input), kToGrey);
    default:
      return VideoDevice(input, size);
  }
}

}  // namespace

std::string PipelineText(const LiveRig& live) {
  const std::vector<std::string>& inputs = live.source.inputs;
  if (live.source.type == SourceSpec::Type::kPipeline) return inputs[0];
  if (live.source.type == SourceSpec::Type::kSideBySide) return SideBySide(live);
  return fmt::format("{} ! appsink name={}\n{} ! appsink name={}", OneCamera(live, inputs[0], live.rig.left),
                     kLeftSink, OneCamera(live, inputs[1], live.rig.right), kRightSink);
}

}  // namespace plslam::camera
