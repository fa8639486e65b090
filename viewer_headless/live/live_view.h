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
#include "viewer_headless/live/order_proof.h"
#include "viewer_headless/report/report_json.h"

namespace plslam::viewer {

/// The live page of the report during a run: `/` is the page, `/data.json?since=...` the data that are new since then
/// (ReportSince); that request waits until the owner of the data calls `Answer` on its own thread. `/end` waits for the
/// end of the run and then returns "finished", or "live" after 25 s: a page requests it beside the data, so that it
/// learns of the end however seldom it requests data.
///
/// A POST to `/orders/VERB` gives an order (pause, resume, save, reset), one at a time; the body of "save" is its file, with
/// "--force " in front to replace any file. The answer is a sentence, with status 200 if the order was carried out. GET
/// `/orders` describes what an order needs: {"needs_key", "challenge" (OrderProof), "file" (proposed for "save")}.
class LiveView {
 public:
  struct Orders {
    std::optional<OrderKey> key;  ///< orders have to prove that they know it
    std::string file;             ///< proposed for "save"
  };

  /// `page` is the template, filled without data. Throws std::runtime_error if the port is not available.
  LiveView(int port, std::string page, Orders orders = {});
  /// Rejects the waiting requests.
  ~LiveView();
  LiveView(const LiveView&) = delete;
  LiveView& operator=(const LiveView&) = delete;

  int port() const { return server_->port(); }

  /// Answers the waiting requests, if any, with the result of `json` for each. Returns at once if none are waiting.
  void Answer(const std::function<std::string(const ReportSince&)>& json);

  /// An order of a page, checked except for its file.
  struct Order {
    std::string verb;
    std::string argument;
  };
  /// Returns the order that a page waits for, once; nullopt: there is none.
  std::optional<Order> TakeOrder();
  /// Answers the order that was taken last: whether it was carried out, and a sentence.
  void AnswerOrder(bool done, const std::string& sentence);

  /// Sets whether the run has ended, or another one has begun.
  void SetFinished(bool finished);
  /// Continues to answer until each page that was notified of the end has received its last data, for 2 s at most.
  void SendFinalData(const std::function<std::string(const ReportSince&)>& json);

 private:
  struct Question {
    ReportSince since;
    std::optional<std::string> answer;
  };

  /// The order of a page between its arrival and its answer.
  struct OpenOrder {
    Order order;
    bool is_taken = false;
    std::optional<HttpResponse> answer;
  };

  HttpResponse Handle(const HttpRequest& request);
  HttpResponse DescribeOrders() const;
  HttpResponse HandleOrder(const HttpRequest& request);
  HttpResponse WaitForOrder(Order order);
  HttpResponse WaitForData(const ReportSince& since);
  HttpResponse WaitForEnd();
  void CountLastData();
  void CountRejection();
  void AwaitRejection();

  std::string page_;
  const std::string save_file_;
  OrderProof proof_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::map<int64_t, Question> questions_;  // by number
  int64_t n_questions_ = 0;
  std::optional<OpenOrder> order_;
  bool finished_ = false;
  bool closing_ = false;
  int64_t n_rejected_ = 0;  ///< orders whose rejection is not sent yet
  int64_t n_waiting_ = 0;   ///< pages that wait for the end
  /// Counts since the end of the run: pages that were notified of it, and data that were sent.
  int64_t n_notified_ = 0;
  int64_t n_last_data_ = 0;
  // Declared last, so destroyed first: its threads use all of the above.
  std::optional<HttpServer> server_;
};

}  // namespace plslam::viewer
