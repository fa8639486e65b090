// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <string_view>

namespace plslam::viewer {

/// A request that the server accepted, to one of this host's names: GET (or HEAD), or an order, which is a POST to a
/// path below `kOrderPath`.
struct HttpRequest {
  std::string path;   ///< "/data.json"
  std::string since;  ///< argument of that name; empty if there is none
  bool is_order = false;
  std::string body;   ///< of an order
  std::string proof;  ///< of an order: its header of that name; empty if there is none
};

struct HttpResponse {
  int status = 200;
  std::string body;
  std::string type = "text/plain; charset=utf-8";
  /// Called when all of it is on its way; may be empty.
  std::function<void()> sent = nullptr;
};

inline constexpr std::string_view kOrderPath = "/orders/";

/// Serves GET and orders on 127.0.0.1 only, to 256 connections at a time (more are cut), each on its own thread, so that no client
/// waits for another. A connection may be idle for 15 s, take 5 s for a request, and 60 s for the answer (an order
/// 150 s); then it is cut. Other methods are rejected, and so are requests that name another host, so that a foreign web
/// page cannot read the data through a local browser.
///
/// A foreign web page cannot give orders either: an order must have the header "X-PLSLAM-Order: 1", which a browser
/// sends to another origin only with its permission (a preflight, OPTIONS, which is rejected), and no foreign Origin. Its
/// body has 4096 bytes at most.
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
