// SPDX-License-Identifier: BSD-3-Clause
#include "viewer_headless/node/report_node.h"

#include <chrono>
#include <filesystem>
#include <stdexcept>
#include <system_error>

#include "core/bus/run_loop.h"
#include "core/bus/transport/authenticator.h"
#include "core/errors/log.h"
#include "core/files/atomic_file.h"
#include "core/process/order.h"
#include "core/process/process_status.h"
#include "core/run/lag.h"
#include "core/run/process_names.h"
#include "core/run/result_files.h"
#include "plslam/warning_t.hpp"
#include "viewer_headless/node/message_values.h"
#include "viewer_headless/report/report_json.h"
#include "viewer_headless/report/report_page.h"

namespace plslam::viewer {
namespace {

constexpr std::chrono::milliseconds kLiveTick(50);

/// Returns the argument of an order of the live page, with its file, if any, from the folder of results on.
std::string WithAbsoluteFile(const std::string& argument, const std::string& out) {
  if (argument.empty()) return argument;
  const bus::SaveRequest request = bus::ToSaveRequest(argument);
  return (request.forced ? command_verb::kForce : "") +
         (std::filesystem::absolute(out) / request.file).lexically_normal().string();
}

}  // namespace

ReportNode::ReportNode(bus::Bus& bus, const ViewerOptions& options, Sources sources)
    : options_(options), sources_(std::move(sources)), wanted_(options.report || options.serve > 0) {
  if (wanted_) page_ = ReadReportTemplate();
  if (options_.serve > 0 && !page_) {
    throw std::runtime_error(
        "the live page cannot be served: plslam was built without node and npm (docs/viewer.md)");
  }
  if (wanted_ && !page_)
    LogWarning("no report.html is written: plslam was built without node and npm (docs/viewer.md)");
  wanted_ = wanted_ && page_;
  report_ = std::make_unique<ReportRecorder>(options_.report_pictures);
  if (!wanted_) return;
  bus.Subscribe<warning_t>(bus::kWarning, [this](const warning_t& m) { report_->AddWarning(m.code, m.sentence); });
  loops_ = std::make_unique<bus::LoopClosureSubscriber>(bus, [this](const LoopClosure& c) { report_->Add(c); });
  ListenToSurfaces(bus);
  if (options_.serve > 0) Serve(bus);
}

void ReportNode::ListenToSurfaces(bus::Bus& bus) {
  surfaces_ = std::make_unique<HeardSurfaces>(bus, [this] {
    report_->SurfacesChanged();
    sources_.on_surfaces();
  });
  ShowSurfaces();
}

void ReportNode::ShowSurfaces() {
  report_->SetSurfaces({&surfaces_->cloud(), [this] { return surfaces_->Grid(); }});
}

void ReportNode::Serve(bus::Bus& bus) {
  LiveView::Orders orders;
  if (!bus.options().key_file.empty()) orders.key = bus::ReadKey(bus.options().key_file);
  orders.file = (std::filesystem::absolute(options_.out) / result_file::kMap).lexically_normal().string();
  live_ = std::make_unique<LiveView>(static_cast<int>(options_.serve), FillTemplate(*page_, "null"), orders);
  orders_.emplace(bus);
  LogInfo("live page: http://127.0.0.1:{}/", live_->port());
  bus.Every(kLiveTick, [this] {
    live_->Answer([this](const ReportSince& since) { return Json(since); });
    CarryOutOrders();
  });
}

void ReportNode::CarryOutOrders() {
  if (!waits_for_order_) {
    const std::optional<LiveView::Order> order = live_->TakeOrder();
    if (!order) return;
    LogInfo("order of the live page: {} {}", order->verb, order->argument);
    orders_->Send(*bus::FindOrder(order->verb), WithAbsoluteFile(order->argument, options_.out));
    waits_for_order_ = true;
  }
  const std::optional<bus::OrderResult> result = orders_->Result();
  if (!result) return;
  waits_for_order_ = false;
  live_->AnswerOrder(result->done, result->sentence);
}

ReportNode::~ReportNode() {
  if (live_) live_->SendFinalData([this](const ReportSince& since) { return Json(since); });
}

void ReportNode::OnStream(const stream_t& message) {
  // A report of an earlier run must not be mistaken for one of this run.
  std::error_code ignored;
  std::filesystem::remove(options_.out + "/" + result_file::kReport, ignored);
  report_->Begin({message.dataset, message.pace, message.n_frames});
}

void ReportNode::OnStatus(const status_t& message) {
  if (!wanted_) return;
  surfaces_->OnStatus(message);
  ProcessSample sample = ToProcessSample(message, bus::NowS(), NewestFrame());
  sample.lag_frames = Lag_frames(message);
  sample.sent_frames = NewestFrame().value + 1 + behind_;
  report_->Add(sample);
  for (const counter_t& counter : message.counters)
    report_->Take(SourceId(message.header.source), counter.name, counter.value);
}

int64_t ReportNode::Lag_frames(const status_t& message) {
  // The player's count of sent frames is as old as its status, so the frames without a pose are counted on its arrival.
  if (process_name::SendsFrames(message.process)) behind_ = sources_.recorder->sent().Behind(NewestFrame());
  if (message.process == process_name::kVo) return behind_;
  if (message.process != process_name::kMapping && message.process != process_name::kLoop) return -1;
  const auto& frames = sources_.recorder->frames();
  auto frame = frames.end();
  return LagInFrames(bus::CountOf(message, "queue.keyframes"), static_cast<int64_t>(frames.size()),
                     [&frame](int64_t) { return (*--frame).second.keyframe_id >= 0; });
}

void ReportNode::OnMap(const MapUpdate& update) {
  if (wanted_) report_->Add(update, *sources_.map, NewestFrame());
}

void ReportNode::SetCamera(const StereoCamera& camera) {
  camera_ = camera;
  report_->SetCamera(camera);
}

void ReportNode::StartNewRun() {
  report_ = std::make_unique<ReportRecorder>(options_.report_pictures, ++run_);
  behind_ = 0;
  if (surfaces_) ShowSurfaces();
  if (camera_) report_->SetCamera(*camera_);
  if (live_) live_->SetFinished(false);
}

FrameId ReportNode::NewestFrame() const {
  return sources_.recorder->frames().empty() ? FrameId() : FrameId(sources_.recorder->frames().Last().first);
}

std::string ReportNode::Json(const ReportSince& since) const {
  return ReportJson(report_->Build(*sources_.recorder, *sources_.map, sources_.q_l_c(), since));
}

void ReportNode::Write() {
  if (!wanted_) return;
  report_->Finish();
  if (live_) live_->SetFinished(true);
  if (!options_.report) return;
  const PageAroundData page = AroundData(*page_);
  WriteFileAtomically(options_.out + "/" + result_file::kReport, {page.before, Json(ReportSince()), page.behind});
}

}  // namespace plslam::viewer
