#include "viewer_headless/live/http_server.h"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <microhttpd.h>
#include <netinet/in.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <exception>
#include <stdexcept>
#include <string_view>

namespace plslam {
namespace {

constexpr unsigned kConnections = 16;
constexpr unsigned kTimeout_s = 15;
constexpr size_t kConnectionBytes = 32 * 1024;
constexpr size_t kMaxSince = 128;

std::string_view OrEmpty(const char* text) { return text == nullptr ? std::string_view() : std::string_view(text); }

/// "localhost:8080", "127.0.0.1", "[::1]:80": names of this machine, whatever the port, which a forwarded one changes.
bool NamesThisMachine(std::string_view host) {
  const size_t colon = host.rfind(':');
  if (colon != std::string_view::npos && host.find(']', colon) == std::string_view::npos)
    host = host.substr(0, colon);
  return host == "localhost" || host == "127.0.0.1" || host == "[::1]";
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

HttpResponse Answer(MHD_Connection* connection, const char* url, const char* method,
                    const HttpServer::Handler& handler) {
  if (OrEmpty(method) != "GET" && OrEmpty(method) != "HEAD") return {MHD_HTTP_METHOD_NOT_ALLOWED, "only GET\n"};
  if (!NamesThisMachine(OrEmpty(MHD_lookup_connection_value(connection, MHD_HEADER_KIND, "Host")))) {
    return {MHD_HTTP_FORBIDDEN, "this is served to this machine alone\n"};
  }
  const std::string_view since = OrEmpty(MHD_lookup_connection_value(connection, MHD_GET_ARGUMENT_KIND, "since"));
  if (since.size() > kMaxSince) return {MHD_HTTP_BAD_REQUEST, "'since' is too long\n"};
  try {
    return handler({std::string(OrEmpty(url)), std::string(since)});
  } catch (const std::exception& e) {
    return {MHD_HTTP_INTERNAL_SERVER_ERROR, std::string(e.what()) + "\n"};
  }
}

MHD_Result OnRequest(void* handler, MHD_Connection* connection, const char* url, const char* method, const char*,
                     const char*, size_t*, void** state) {
  // Called once with the head; an answer before the body of a GET is asked for a second time would be dropped.
  static int seen = 0;
  const bool may_have_body = OrEmpty(method) != "GET" && OrEmpty(method) != "HEAD";
  if (*state == nullptr && !may_have_body) {
    *state = &seen;
    return MHD_YES;
  }
  return Send(connection, Answer(connection, url, method, *static_cast<HttpServer::Handler*>(handler)));
}

}  // namespace

struct HttpServer::Impl {
  Handler handler;
  MHD_Daemon* daemon = nullptr;
};

HttpServer::HttpServer(int port, Handler handler) : impl_(std::make_unique<Impl>()) {
  impl_->handler = std::move(handler);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<uint16_t>(port));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  errno = 0;
  impl_->daemon = MHD_start_daemon(MHD_USE_AUTO | MHD_USE_INTERNAL_POLLING_THREAD, 0, nullptr, nullptr, &OnRequest,
                                   &impl_->handler, MHD_OPTION_SOCK_ADDR, &address, MHD_OPTION_CONNECTION_LIMIT,
                                   kConnections, MHD_OPTION_CONNECTION_TIMEOUT, kTimeout_s,
                                   MHD_OPTION_CONNECTION_MEMORY_LIMIT, kConnectionBytes, MHD_OPTION_END);
  if (impl_->daemon == nullptr) {
    throw std::runtime_error(fmt::format("port {} of 127.0.0.1 cannot be served: {}", port,
                                         errno != 0 ? std::strerror(errno) : "no reason"));
  }
}

HttpServer::~HttpServer() { MHD_stop_daemon(impl_->daemon); }

int HttpServer::port() const {
  const MHD_DaemonInfo* info = MHD_get_daemon_info(impl_->daemon, MHD_DAEMON_INFO_BIND_PORT);
  return info == nullptr ? 0 : info->port;
}

}  // namespace plslam
