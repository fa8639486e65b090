// SPDX-License-Identifier: BSD-3-Clause
#include "viewer_headless/live/live_view.h"

#include <chrono>
#include <utility>
#include <vector>

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

}  // namespace

LiveView::LiveView(int port, std::string page) : page_(std::move(page)) {
  server_.emplace(port, [this](const HttpRequest& request) { return Handle(request); });
}

LiveView::~LiveView() {
  {
    const std::scoped_lock lock(mutex_);
    closing_ = true;
  }
  changed_.notify_all();
  server_.reset();
}

HttpResponse LiveView::Handle(const HttpRequest& request) {
  if (request.path == "/" || request.path == "/index.html") return {200, page_, "text/html; charset=utf-8"};
  if (request.path == "/end") return WaitForEnd();
  if (request.path != "/data.json") return {404, "available: /, /data.json and /end\n"};
  const std::optional<ReportSince> since = ReportSince::Parse(request.since);
  if (!since) return {400, "'since' is not a 'next' value of /data.json\n"};
  return WaitForData(*since);
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
