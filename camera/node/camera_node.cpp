// SPDX-License-Identifier: BSD-3-Clause
#include "camera/node/camera_node.h"

#include <fmt/format.h>

#include <stdexcept>
#include <utility>

#include "camera/rig_file.h"
#include "core/errors/log.h"
#include "core/run/run_counters.h"
#include "core/run/run_warnings.h"

namespace plslam::camera {
namespace {

/// Number of pairs from which on the values are checked.
constexpr int64_t kEnoughPairs = 50;

stream::SenderOptions SenderOptionsOf(const CameraOptions& options) {
  return {stream::ParsePace(options.pace), false, options.exit, options.resume_after, options.paused};
}

std::unique_ptr<stream::FrameSource> Open(bus::Process& process, const CameraOptions& options, HealthReport* report) {
  if (options.rig.empty()) throw std::runtime_error("no rig file is given: camera RIG.yaml (see --help)");
  const stream::Pace pace = stream::ParsePace(options.pace);
  CameraSource::Listener listener;
  listener.on_frame = [report](const auto& health, const auto& pairing) { report->OnFrame(health, pairing); };
  listener.on_outage = [report](const std::string& why) { report->OnOutage(why); };
  LiveRig rig = ReadRigFile(options.rig);
  for (const std::string& warning : rig.notes.warnings) LogWarning("{}", warning);
  for (const std::string& remark : rig.notes.remarks) LogInfo("{}", remark);
  auto source = std::make_unique<CameraSource>(std::move(rig), !options.resume_after.empty(), listener);
  if (source->is_live() && (pace.lockstep || pace.speed != 1.0)) {
    throw std::runtime_error(
        fmt::format("{}: camera.pace = {}: live cameras cannot wait; use realtime", options.rig, options.pace));
  }
  CameraOptions shown = options;
  process.SetConfiguration(ToYaml("camera", shown));
  return source;
}

}  // namespace

void HealthReport::Count(const CaptureHealth& health, const Pairing& pairing) {
  process_.SetCounter("frames.rate_hz", health.rate_hz());
  process_.SetCounter(kFramesCaptured, static_cast<double>(health.pairs()));
  process_.SetCounter(kSkew, health.skew_ms());
  process_.SetCounter(kFramesMissing, static_cast<double>(health.missing()));
  process_.SetCounter(kDroppedLeft, static_cast<double>(pairing.dropped(Side::kLeft)));
  process_.SetCounter(kDroppedRight, static_cast<double>(pairing.dropped(Side::kRight)));
  process_.SetCounter(kOverexposed, static_cast<double>(health.overexposed()));
  process_.SetCounter(kUnderexposed, static_cast<double>(health.underexposed()));
}

void HealthReport::Warn(const std::string& what, const std::string& sentence) {
  if (!warned_.insert(what).second) return;
  LogWarning("{}", sentence);
  process_.SetReason(sentence);
}

void HealthReport::OnFrame(const CaptureHealth& health, const Pairing& pairing) {
  Count(health, pairing);
  if (health.pairs() % kEnoughPairs != 0) return;
  RunFindings findings;
  findings.frames_captured = static_cast<double>(health.pairs());
  findings.skew_ms = health.skew_ms();
  findings.frames_missing = static_cast<double>(health.missing());
  findings.frames_dropped = static_cast<double>(pairing.dropped(Side::kLeft) + pairing.dropped(Side::kRight));
  findings.frames_overexposed = static_cast<double>(health.overexposed());
  findings.frames_underexposed = static_cast<double>(health.underexposed());
  for (const RunWarning& warning : CameraWarningsOf(findings)) Warn(warning.code, warning.sentence);
}

void HealthReport::OnOutage(const std::string& why) {
  if (why.empty()) {
    LogInfo("receiving frames again");
    process_.SetReason("");
  } else if (!is_out_) {
    process_.SetCounter(kOutages, static_cast<double>(++outages_));
    LogWarning("no frames: {}; trying again", why);
    process_.SetReason(fmt::format("no frames: {}", why));
  }
  is_out_ = !why.empty();
}

CameraNode::CameraNode(bus::Process& process, const CameraOptions& options)
    : report_(process), sender_(process, Open(process, options, &report_), SenderOptionsOf(options)) {}

}  // namespace plslam::camera
