// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <memory>
#include <string>

namespace plslam::viewer {

/// A request that the server accepted: only GET (and HEAD) to one of this host's names.
struct HttpRequest {
  std::string path;   ///< "/data.json"
  std::string since;  ///< argument of that name; empty if there is none
};

struct HttpResponse {
  int status = 200;
  std::string body;
  std::string type = "text/plain; charset=utf-8";
  /// Called when all of it is on its way; may be empty.
  std::function<void()> sent = nullptr;
};

/// Serves GET on 127.0.0.1 only, to 256 connections at a time (more are cut), each on its own thread, so that no client
/// waits for another. A connection may be idle for 15 s, take 5 s for the head of a request, and 60 s for the answer;
/// then it is cut. Other methods are rejected, and so are requests that name another host, so that a foreign web page
/// cannot read the data through a local browser.
class HttpServer {
 public:
  using Handler = std::function<HttpResponse(const HttpRequest&)>;

  /// `port` 0 selects any free one. `handler` is called on many threads. Throws std::runtime_error if the port is
  /// taken.
  HttpServer(int port, Handler handler);
  /// Returns after the last running handler.
  ~HttpServer();
  HttpServer(const HttpServer&) = delete;
  HttpServer& operator=(const HttpServer&) = delete;

  int port() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace plslam::viewer
