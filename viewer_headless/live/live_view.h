#pragma once

#include <condition_variable>
#include <functional>
#include <mutex>
#include <optional>
#include <string>

#include "viewer_headless/live/http_server.h"
#include "viewer_headless/report/report_since.h"

namespace plslam {

/// The report's page while the run goes on: `/` is the page, `/data.json?since=...` what is new since (ReportSince). What
/// is asked waits until the owner of the data, on its own thread, calls `Answer`.
class LiveView {
 public:
  /// `page` is the template, filled without data. Throws std::runtime_error where the port cannot be had.
  LiveView(int port, std::string page);
  /// Turns away who waits.
  ~LiveView();
  LiveView(const LiveView&) = delete;
  LiveView& operator=(const LiveView&) = delete;

  int port() const { return server_->port(); }

  /// Answers what waits, if anything, by `json` for it. At once, where nothing waits.
  void Answer(const std::function<std::string(const ReportSince&)>& json);

 private:
  HttpResponse Handle(const HttpRequest& request);
  HttpResponse WaitForData(const ReportSince& since);

  std::string page_;
  std::mutex mutex_;
  std::condition_variable answered_;
  std::optional<ReportSince> question_;
  std::optional<std::string> answer_;
  bool closing_ = false;
  // Last made, first gone: its thread uses all of the above.
  std::optional<HttpServer> server_;
};

}  // namespace plslam
