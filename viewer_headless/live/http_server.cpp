// SPDX-License-Identifier: BSD-3-Clause
#include "viewer_headless/live/http_server.h"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <microhttpd.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <condition_variable>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <map>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <string_view>
#include <thread>
#include <utility>

namespace plslam::viewer {
namespace {

using Clock = std::chrono::steady_clock;

constexpr unsigned kConnections = 256;
// Limit for a connection without any byte. A client that sends single bytes now and then is cut off by the deadlines.
constexpr unsigned kTimeout_s = 15;
constexpr std::chrono::seconds kHeadLimit(5);
constexpr std::chrono::seconds kAnswerLimit(60);
constexpr std::chrono::seconds kOrderLimit(150);
constexpr std::chrono::milliseconds kWatchTick(200);
constexpr size_t kConnectionBytes = 32 * 1024;
constexpr size_t kMaxSince = 128;
constexpr size_t kMaxBody = 4096;

std::string_view OrEmpty(const char* text) { return text == nullptr ? std::string_view() : std::string_view(text); }

/// "localhost:8080", "127.0.0.1", "[::1]:80": names of this machine, whatever the port, which a forwarded one
/// changes.
bool NamesThisMachine(std::string_view host) {
  const size_t colon = host.rfind(':');
  if (colon != std::string_view::npos && host.find(']', colon) == std::string_view::npos)
    host = host.substr(0, colon);
  return host == "localhost" || host == "127.0.0.1" || host == "[::1]";
}

std::string_view Header(MHD_Connection* connection, const char* name) {
  return OrEmpty(MHD_lookup_connection_value(connection, MHD_HEADER_KIND, name));
}

bool IsOrder(std::string_view method, std::string_view url) {
  return method == "POST" && url.starts_with(kOrderPath);
}

/// Returns the reason why an order is rejected by its head; nullopt: it is accepted.
std::optional<HttpResponse> RefuseOrder(MHD_Connection* connection) {
  // A page of another origin cannot set this header without a preflight, which no method but GET and POST passes.
  if (Header(connection, "X-PLSLAM-Order") != "1") {
    return HttpResponse{MHD_HTTP_FORBIDDEN, "orders need the header X-PLSLAM-Order: 1\n"};
  }
  const std::string_view origin = Header(connection, "Origin");
  const std::string own = "http://" + std::string(Header(connection, "Host"));
  const std::string_view site = Header(connection, "Sec-Fetch-Site");
  const bool is_foreign = (!origin.empty() && origin != own) || (!site.empty() && site != "same-origin");
  if (is_foreign) return HttpResponse{MHD_HTTP_FORBIDDEN, "orders are accepted from this page only\n"};
  const std::string_view length = Header(connection, "Content-Length");
  // More digits than the limit has are too many whatever they are.
  const bool is_large = length.size() > 4 || std::atoi(std::string(length).c_str()) > static_cast<int>(kMaxBody);
  if (is_large) return HttpResponse{MHD_HTTP_CONTENT_TOO_LARGE, "the order is too long\n"};
  return std::nullopt;
}

/// Returns the answer to a request that is rejected by its head; nullopt: it is accepted.
std::optional<HttpResponse> Refuse(MHD_Connection* connection, const char* url, const char* method) {
  const bool is_order = IsOrder(OrEmpty(method), OrEmpty(url));
  if (!is_order && OrEmpty(method) != "GET" && OrEmpty(method) != "HEAD") {
    return HttpResponse{MHD_HTTP_METHOD_NOT_ALLOWED, "only GET\n"};
  }
  if (!NamesThisMachine(Header(connection, "Host"))) {
    return HttpResponse{MHD_HTTP_FORBIDDEN, "this page is served to this machine only\n"};
  }
  return is_order ? RefuseOrder(connection) : std::nullopt;
}

MHD_Result Send(MHD_Connection* connection, const HttpResponse& answer) {
  MHD_Response* response = MHD_create_response_from_buffer(answer.body.size(), const_cast<char*>(answer.body.data()),
                                                           MHD_RESPMEM_MUST_COPY);
  if (response == nullptr) return MHD_NO;
  constexpr std::array<std::array<const char*, 2>, 4> kHeaders{{
      {"Cache-Control", "no-store"},
      {"X-Content-Type-Options", "nosniff"},
      {"X-Frame-Options", "DENY"},
      {"Referrer-Policy", "no-referrer"},
  }};
  MHD_add_response_header(response, "Content-Type", answer.type.c_str());
  for (const auto& [name, value] : kHeaders) MHD_add_response_header(response, name, value);
  if (answer.status == MHD_HTTP_METHOD_NOT_ALLOWED) MHD_add_response_header(response, "Allow", "GET, HEAD");
  const MHD_Result result = MHD_queue_response(connection, static_cast<unsigned>(answer.status), response);
  MHD_destroy_response(response);
  return result;
}

/// Answers a request whose head was accepted; `body` is that of an order.
HttpResponse Answer(MHD_Connection* connection, const char* url, const char* method, std::string body,
                    const HttpServer::Handler& handler) {
  const std::string_view since = OrEmpty(MHD_lookup_connection_value(connection, MHD_GET_ARGUMENT_KIND, "since"));
  if (since.size() > kMaxSince) return {MHD_HTTP_BAD_REQUEST, "'since' is too long\n"};
  if (body.size() > kMaxBody) return {MHD_HTTP_CONTENT_TOO_LARGE, "the order is too long\n"};
  try {
    return handler({std::string(OrEmpty(url)), std::string(since), IsOrder(OrEmpty(method), OrEmpty(url)),
                    std::move(body), std::string(Header(connection, "X-PLSLAM-Proof"))});
  } catch (const std::exception& e) {
    return {MHD_HTTP_INTERNAL_SERVER_ERROR, std::string(e.what()) + "\n"};
  }
}

/// Closes connections that take too long, which libmicrohttpd keeps open as long as a byte arrives now and then.
class DeadlineWatch {
 public:
  DeadlineWatch() : thread_([this] { Watch(); }) {}
  ~DeadlineWatch() {
    {
      const std::scoped_lock lock(mutex_);
      stopping_ = true;
    }
    changed_.notify_all();
    thread_.join();
  }
  DeadlineWatch(const DeadlineWatch&) = delete;
  DeadlineWatch& operator=(const DeadlineWatch&) = delete;

  void Add(MHD_Connection* connection, int fd, Clock::duration limit) {
    const std::scoped_lock lock(mutex_);
    watched_[connection] = {fd, Clock::now() + limit};
  }
  void SetLimit(MHD_Connection* connection, Clock::duration limit) {
    const std::scoped_lock lock(mutex_);
    const auto found = watched_.find(connection);
    if (found != watched_.end()) found->second.deadline = Clock::now() + limit;
  }
  /// Before its socket is closed.
  void Remove(MHD_Connection* connection) {
    const std::scoped_lock lock(mutex_);
    watched_.erase(connection);
  }

 private:
  struct Watched {
    int fd = -1;
    Clock::time_point deadline;
  };

  void Watch() {
    std::unique_lock lock(mutex_);
    while (!stopping_) {
      const auto now = Clock::now();
      for (const auto& [connection, watched] : watched_) {
        if (now >= watched.deadline) shutdown(watched.fd, SHUT_RDWR);
      }
      changed_.wait_for(lock, kWatchTick);
    }
  }

  std::mutex mutex_;
  std::condition_variable changed_;
  std::map<MHD_Connection*, Watched> watched_;
  bool stopping_ = false;
  std::thread thread_;
};

}  // namespace

struct HttpServer::Impl {
  Handler handler;
  DeadlineWatch watch;
  MHD_Daemon* daemon = nullptr;

  /// State of a request between its head and its end.
  struct Request {
    std::string body;
    std::function<void()> sent;
  };

  static void OnConnection(void* self, MHD_Connection* connection, void**, MHD_ConnectionNotificationCode code) {
    DeadlineWatch& watch = static_cast<Impl*>(self)->watch;
    if (code == MHD_CONNECTION_NOTIFY_CLOSED) return watch.Remove(connection);
    const auto* info = MHD_get_connection_info(connection, MHD_CONNECTION_INFO_CONNECTION_FD);
    if (info != nullptr) watch.Add(connection, info->connect_fd, kHeadLimit);
  }

  static MHD_Result OnRequest(void* self, MHD_Connection* connection, const char* url, const char* method,
                              const char*, const char* bytes, size_t* n_bytes, void** state) {
    auto* impl = static_cast<Impl*>(self);
    // Called once with the head only; an answer would be dropped if it came before the second call for a GET with a
    // body.
    const bool has_begun = *state != nullptr;
    if (!has_begun) *state = new Request;
    auto* request = static_cast<Request*>(*state);
    const bool may_have_body = OrEmpty(method) != "GET" && OrEmpty(method) != "HEAD";
    if (!has_begun && !may_have_body) return MHD_YES;
    if (has_begun && may_have_body && *n_bytes > 0) {
      // One byte above the limit is kept, so that the end knows; the deadline cuts a body without end.
      request->body.append(bytes, std::min(*n_bytes, kMaxBody + 1 - request->body.size()));
      *n_bytes = 0;
      return MHD_YES;
    }
    std::optional<HttpResponse> answer;
    if (!has_begun || !may_have_body) answer = Refuse(connection, url, method);
    if (!answer && !has_begun) return MHD_YES;
    impl->watch.SetLimit(connection, may_have_body ? kOrderLimit : kAnswerLimit);
    if (!answer) answer = Answer(connection, url, method, std::move(request->body), impl->handler);
    request->sent = answer->sent;
    return Send(connection, *answer);
  }

  static void OnCompleted(void* self, MHD_Connection* connection, void** state, MHD_RequestTerminationCode code) {
    static_cast<Impl*>(self)->watch.SetLimit(connection, std::chrono::seconds(kTimeout_s) + kHeadLimit);
    const std::unique_ptr<Request> request(static_cast<Request*>(std::exchange(*state, nullptr)));
    if (request && request->sent && code == MHD_REQUEST_TERMINATED_COMPLETED_OK) request->sent();
  }
};

namespace {

/// Returns a socket that listens at the port (0: any free one) of this host only. A socket of libmicrohttpd
/// would hide, from version 1 on, why that failed.
int ListenAt(int port) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<uint16_t>(port));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  const int fd = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  const int on = 1;
  const bool listens = fd >= 0 && setsockopt(fd, SOL_SOCKET, SO_REUSEADDR, &on, sizeof(on)) == 0 &&
                       bind(fd, reinterpret_cast<const sockaddr*>(&address), sizeof(address)) == 0 &&
                       listen(fd, SOMAXCONN) == 0;
  if (listens) return fd;
  const std::string reason = std::strerror(errno);
  if (fd >= 0) close(fd);
  throw std::runtime_error(fmt::format("port {} of 127.0.0.1 cannot be served: {}", port, reason));
}

}  // namespace

HttpServer::HttpServer(int port, Handler handler) : impl_(std::make_unique<Impl>()) {
  impl_->handler = std::move(handler);
  const int socket = ListenAt(port);
  impl_->daemon = MHD_start_daemon(MHD_USE_AUTO | MHD_USE_INTERNAL_POLLING_THREAD | MHD_USE_THREAD_PER_CONNECTION, 0,
                                   nullptr, nullptr, &Impl::OnRequest, impl_.get(), MHD_OPTION_LISTEN_SOCKET, socket,
                                   MHD_OPTION_CONNECTION_LIMIT, kConnections, MHD_OPTION_CONNECTION_TIMEOUT,
                                   kTimeout_s, MHD_OPTION_CONNECTION_MEMORY_LIMIT, kConnectionBytes,
                                   MHD_OPTION_NOTIFY_CONNECTION, &Impl::OnConnection, impl_.get(),
                                   MHD_OPTION_NOTIFY_COMPLETED, &Impl::OnCompleted, impl_.get(), MHD_OPTION_END);
  if (impl_->daemon == nullptr) {
    close(socket);
    throw std::runtime_error(fmt::format("port {} of 127.0.0.1 cannot be served: the server does not start", port));
  }
}

HttpServer::~HttpServer() { MHD_stop_daemon(impl_->daemon); }

int HttpServer::port() const {
  const MHD_DaemonInfo* info = MHD_get_daemon_info(impl_->daemon, MHD_DAEMON_INFO_BIND_PORT);
  return info == nullptr ? 0 : info->port;
}

}  // namespace plslam::viewer
