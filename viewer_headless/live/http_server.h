#pragma once

#include <functional>
#include <memory>
#include <string>

namespace plslam {

/// A question that reached the server: only GET (and HEAD) to this machine by one of its own names does.
struct HttpRequest {
  std::string path;   ///< "/data.json"
  std::string since;  ///< argument of that name; empty where there is none
};

struct HttpResponse {
  int status = 200;
  std::string body;
  std::string type = "text/plain; charset=utf-8";
};

/// Serves GET on 127.0.0.1 and nowhere else, from a thread of its own, to 16 connections at a time that may be idle for
/// 15 s (others wait); other methods are refused. So are requests that name another host, so that a
/// page of the network cannot read it through a browser here.
class HttpServer {
 public:
  using Handler = std::function<HttpResponse(const HttpRequest&)>;

  /// `port` 0: any free one. `handler` is called on the server's thread. Throws std::runtime_error where the port is taken.
  HttpServer(int port, Handler handler);
  /// Returns when no handler runs any more.
  ~HttpServer();
  HttpServer(const HttpServer&) = delete;
  HttpServer& operator=(const HttpServer&) = delete;

  int port() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace plslam
