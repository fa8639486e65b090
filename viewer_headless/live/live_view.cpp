// SPDX-License-Identifier: BSD-3-Clause
#include "viewer_headless/live/live_view.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <nlohmann/json.hpp>
#include <string_view>
#include <utility>
#include <vector>

#include "core/run/process_names.h"

namespace plslam::viewer {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

// The owner may be writing its files.
constexpr seconds kPatience(10);
// Shorter than a proxy between would wait.
constexpr seconds kLongestWaitForEnd(25);
constexpr seconds kLastAnswers(2);
constexpr milliseconds kLastAnswersTick(10);
// Longer than the owner waits for an answer (OrderSender).
constexpr seconds kLongestOrder(140);

constexpr std::array<std::string_view, 4> kVerbs = {command_verb::kPause, command_verb::kResume, command_verb::kSave,
                                                    command_verb::kReset};

bool IsControl(char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7f; }

}  // namespace

LiveView::LiveView(int port, std::string page, Orders orders)
    : page_(std::move(page)), save_file_(std::move(orders.file)), proof_(orders.key) {
  server_.emplace(port, [this](const HttpRequest& request) { return Handle(request); });
}

LiveView::~LiveView() {
  {
    const std::scoped_lock lock(mutex_);
    closing_ = true;
  }
  changed_.notify_all();
  AwaitRejection();
  server_.reset();
}

/// The server closes its connections at once, also those whose answer is on its way.
void LiveView::AwaitRejection() {
  std::unique_lock lock(mutex_);
  changed_.wait_for(lock, kLastAnswers, [this] { return !order_ && n_rejected_ == 0; });
}

HttpResponse LiveView::Handle(const HttpRequest& request) {
  if (request.is_order) return HandleOrder(request);
  if (request.path == "/orders") return DescribeOrders();
  if (request.path == "/" || request.path == "/index.html") return {200, page_, "text/html; charset=utf-8"};
  if (request.path == "/end") return WaitForEnd();
  if (request.path != "/data.json") return {404, "available: /, /data.json, /end and /orders\n"};
  const std::optional<ReportSince> since = ReportSince::Parse(request.since);
  if (!since) return {400, "'since' is not a 'next' value of /data.json\n"};
  return WaitForData(*since);
}

HttpResponse LiveView::DescribeOrders() const {
  const nlohmann::json description = {
      {"needs_key", proof_.needs_key()}, {"challenge", proof_.challenge()}, {"file", save_file_}};
  // A file name may be no UTF-8.
  return {200, description.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace), "application/json"};
}

HttpResponse LiveView::HandleOrder(const HttpRequest& request) {
  const std::string_view verb = std::string_view(request.path).substr(kOrderPath.size());
  if (std::ranges::find(kVerbs, verb) == kVerbs.end()) {
    return {404, "available orders: pause, resume, save and reset\n"};
  }
  if (std::ranges::any_of(request.body, IsControl) || request.body.empty() == (verb == command_verb::kSave)) {
    return {400, "the body of 'save' is a file name, and that of other orders is empty\n"};
  }
  if (!proof_.Accept(verb, request.body, request.proof)) {
    return {401, "this system uses bus.key_file: enter the 64 hex digits of that file\n"};
  }
  return WaitForOrder({std::string(verb), request.body});
}

HttpResponse LiveView::WaitForOrder(Order order) {
  std::unique_lock lock(mutex_);
  if (order_) return {409, "another order is being carried out\n"};
  order_ = OpenOrder{std::move(order), false, std::nullopt};
  changed_.wait_for(lock, kLongestOrder, [this] { return order_->answer.has_value() || closing_; });
  const std::optional<HttpResponse> answer = std::exchange(order_, std::nullopt)->answer;
  if (answer) return *answer;
  ++n_rejected_;
  HttpResponse rejection{503, "the run has ended, or the viewer is busy\n"};
  rejection.sent = [this] { CountRejection(); };
  return rejection;
}

std::optional<LiveView::Order> LiveView::TakeOrder() {
  const std::scoped_lock lock(mutex_);
  if (!order_ || std::exchange(order_->is_taken, true)) return std::nullopt;
  return order_->order;
}

void LiveView::AnswerOrder(bool done, const std::string& sentence) {
  {
    const std::scoped_lock lock(mutex_);
    // The page may have stopped waiting, and another one may have begun to.
    if (!order_ || !order_->is_taken) return;
    order_->answer = HttpResponse{done ? 200 : 422, sentence + "\n"};
  }
  changed_.notify_all();
}

HttpResponse LiveView::WaitForData(const ReportSince& since) {
  std::unique_lock lock(mutex_);
  const int64_t number = n_questions_++;
  const Question& question = questions_[number] = {since, std::nullopt};
  changed_.wait_for(lock, kPatience, [&] { return question.answer.has_value() || closing_; });
  const std::optional<std::string> answer = std::move(questions_.extract(number).mapped().answer);
  if (!answer) return {503, "the viewer is busy\n"};
  HttpResponse response{200, *answer, "application/json"};
  if (finished_) response.sent = [this] { CountLastData(); };
  return response;
}

HttpResponse LiveView::WaitForEnd() {
  std::unique_lock lock(mutex_);
  ++n_waiting_;
  changed_.wait_for(lock, kLongestWaitForEnd, [this] { return finished_ || closing_; });
  --n_waiting_;
  if (!finished_) return {200, "live\n"};
  ++n_notified_;
  return {200, "finished\n"};
}

void LiveView::CountRejection() {
  {
    const std::scoped_lock lock(mutex_);
    --n_rejected_;
  }
  changed_.notify_all();
}

void LiveView::CountLastData() {
  const std::scoped_lock lock(mutex_);
  ++n_last_data_;
}

void LiveView::Answer(const std::function<std::string(const ReportSince&)>& json) {
  std::vector<std::pair<int64_t, ReportSince>> open;
  {
    const std::scoped_lock lock(mutex_);
    for (const auto& [number, question] : questions_) {
      if (!question.answer) open.emplace_back(number, question.since);
    }
  }
  for (const auto& [number, since] : open) {
    std::string text = json(since);
    {
      const std::scoped_lock lock(mutex_);
      // The client may have disconnected meanwhile.
      const auto found = questions_.find(number);
      if (found != questions_.end()) found->second.answer = std::move(text);
    }
    changed_.notify_all();
  }
}

void LiveView::SetFinished(bool finished) {
  {
    const std::scoped_lock lock(mutex_);
    if (std::exchange(finished_, finished) == finished) return;
    n_notified_ = n_last_data_ = 0;
  }
  changed_.notify_all();
}

void LiveView::SendFinalData(const std::function<std::string(const ReportSince&)>& json) {
  const auto until = std::chrono::steady_clock::now() + kLastAnswers;
  std::unique_lock lock(mutex_);
  // The pages that wait for the end are notified within a moment.
  while (finished_ && std::chrono::steady_clock::now() < until && (n_waiting_ > 0 || n_last_data_ < n_notified_)) {
    lock.unlock();
    Answer(json);
    lock.lock();
    changed_.wait_for(lock, kLastAnswersTick);
  }
}

}  // namespace plslam::viewer
