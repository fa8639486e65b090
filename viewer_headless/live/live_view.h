// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <condition_variable>
#include <cstdint>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <string>

#include "viewer_headless/live/http_server.h"
#include "viewer_headless/report/report_json.h"

namespace plslam::viewer {

/// The report's page while the run goes on: `/` is the page, `/data.json?since=...` what is new since (ReportSince),
/// which waits until the owner of the data, on its own thread, calls `Answer`. `/end` waits for the end of the run
/// and then says "finished", or "live" after 25 s: a page asks it beside the data, so that it hears of the end
/// however seldom it asks for those.
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

  /// The run is over, or another has begun.
  void SetFinished(bool finished);
  /// Goes on answering until each page that was told of the end has got what was new then, 2 s at most.
  void AnswerTheLast(const std::function<std::string(const ReportSince&)>& json);

 private:
  struct Question {
    ReportSince since;
    std::optional<std::string> answer;
  };

  HttpResponse Handle(const HttpRequest& request);
  HttpResponse WaitForData(const ReportSince& since);
  HttpResponse WaitForEnd();
  void CountLastData();

  std::string page_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::map<int64_t, Question> questions_;  // by number
  int64_t n_questions_ = 0;
  bool finished_ = false;
  bool closing_ = false;
  int64_t n_waiting_ = 0;  ///< pages that wait for the end
  /// Since the run is over: pages that were told so, and data that were sent.
  int64_t n_told_ = 0;
  int64_t n_last_data_ = 0;
  // Last made, first gone: its threads use all of the above.
  std::optional<HttpServer> server_;
};

}  // namespace plslam::viewer
