#include "viewer_headless/live/live_view.h"

#include <chrono>

namespace plslam {
namespace {

// The owner may be writing its files.
constexpr std::chrono::seconds kPatience(10);

}  // namespace

LiveView::LiveView(int port, std::string page) : page_(std::move(page)) {
  server_.emplace(port, [this](const HttpRequest& request) { return Handle(request); });
}

LiveView::~LiveView() {
  {
    const std::scoped_lock lock(mutex_);
    closing_ = true;
  }
  answered_.notify_all();
  server_.reset();
}

HttpResponse LiveView::Handle(const HttpRequest& request) {
  if (request.path == "/" || request.path == "/index.html") return {200, page_, "text/html; charset=utf-8"};
  if (request.path != "/data.json") return {404, "there is / and /data.json\n"};
  const std::optional<ReportSince> since = ReportSince::Parse(request.since);
  if (!since) return {400, "'since' is not what /data.json gave as 'next'\n"};
  return WaitForData(*since);
}

HttpResponse LiveView::WaitForData(const ReportSince& since) {
  std::unique_lock lock(mutex_);
  question_ = since;
  answer_.reset();
  answered_.wait_for(lock, kPatience, [this] { return answer_.has_value() || closing_; });
  question_.reset();
  if (!answer_) return {503, "the viewer is busy\n"};
  return {200, std::move(*answer_), "application/json"};
}

void LiveView::Answer(const std::function<std::string(const ReportSince&)>& json) {
  std::unique_lock lock(mutex_);
  if (!question_ || answer_) return;
  const ReportSince since = *question_;
  lock.unlock();
  std::string text = json(since);
  lock.lock();
  // Who asked may have gone meanwhile.
  if (!question_ || *question_ != since) return;
  answer_ = std::move(text);
  answered_.notify_all();
}

}  // namespace plslam
