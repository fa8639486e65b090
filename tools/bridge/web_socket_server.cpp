// SPDX-License-Identifier: BSD-3-Clause
#include "tools/bridge/web_socket_server.h"

#include <fmt/format.h>
#include <libwebsockets.h>
#include <sys/socket.h>

#include <array>
#include <atomic>
#include <cstring>
#include <map>
#include <stdexcept>
#include <string_view>
#include <thread>
#include <vector>

#include "core/errors/log.h"

namespace plslam::bridge {
namespace {

constexpr const char* kSdkProtocol = "foxglove.sdk.v1";
constexpr const char* kWebSocketProtocol = "foxglove.websocket.v1";
constexpr size_t kMostClients = 32;
constexpr size_t kMostReceivedBytes = 1 << 20;

std::string HeaderOf(lws* wsi, lws_token_indexes token) {
  std::array<char, 1024> text{};
  const int n = lws_hdr_copy(wsi, text.data(), static_cast<int>(text.size()), token);
  return n <= 0 ? "" : std::string(text.data(), static_cast<size_t>(n));
}

/// The kernel keeps megabytes for a client that reads slowly, which then sees images that are seconds old: those wait in
/// its `ClientQueue` instead, where newer ones replace them.
void BoundSendBuffer(int socket) {
  constexpr int kBytes = 256 << 10;
  setsockopt(socket, SOL_SOCKET, SO_SNDBUF, &kBytes, sizeof(kBytes));
}

int Refuse(lws* wsi, const std::string& sentence) {
  return lws_return_http_status(wsi, HTTP_STATUS_BAD_REQUEST, sentence.c_str()) < 0 ? -1 : 1;
}

}  // namespace

bool IsAllowedOrigin(const std::string& origin, const std::string& allowed) {
  if (origin.empty() || origin == allowed || origin == "https://app.foxglove.dev" || origin == "file://") return true;
  for (const std::string_view scheme : {"http://", "https://"}) {
    if (!origin.starts_with(scheme)) continue;
    std::string host = origin.substr(scheme.size());
    const size_t colon = host.rfind(':');
    if (colon != std::string::npos && host.find(']', colon) == std::string::npos) host.resize(colon);
    if (host == "localhost" || host == "127.0.0.1" || host == "[::1]") return true;
  }
  return false;
}

struct WebSocketServer::Impl {
  struct Connection {
    int64_t client = 0;
    std::string received;
    std::vector<uint8_t> sent;  ///< with room for the header of the library
  };

  Impl(FoxgloveServer& of, const Place& where) : server(of), place(where) {
    lws_set_log_level(LLL_ERR, [](int, const char* line) {
      LogDebug("libwebsockets: {}", std::string_view(line).substr(0, std::strcspn(line, "\n")));
    });
    protocols[0].name = kSdkProtocol;
    protocols[1].name = kWebSocketProtocol;
    for (lws_protocols& protocol : {std::ref(protocols[0]), std::ref(protocols[1])}) protocol.callback = OnEvent;
    lws_context_creation_info info{};
    info.options = LWS_SERVER_OPTION_EXPLICIT_VHOSTS | LWS_SERVER_OPTION_FAIL_UPON_UNABLE_TO_BIND;
    info.gid = info.uid = -1;
    info.user = this;
    context = lws_create_context(&info);
    if (context == nullptr) throw std::runtime_error("the WebSocket server cannot be started");
    info.protocols = protocols.data();
    info.port = place.port;
    info.iface = place.address == "0.0.0.0" ? nullptr : place.address.c_str();
    info.vhost_name = "plslam";
    info.options |= LWS_SERVER_OPTION_DISABLE_IPV6;
    vhost = lws_create_vhost(context, &info);
    if (vhost == nullptr) {
      lws_context_destroy(context);
      throw std::runtime_error(
          fmt::format("{}:{} cannot be listened on: another program has the port, or the address is not of this "
                      "machine; give another bridge.port or bridge.address",
                      place.address, place.port));
    }
    thread = std::thread([this] {
      while (!stopped) lws_service(context, 0);
    });
  }
  ~Impl() {
    stopped = true;
    lws_cancel_service(context);
    thread.join();
    lws_context_destroy(context);
  }

  static int OnEvent(lws* wsi, lws_callback_reasons reason, void*, void* in, size_t n) {
    auto* const impl = static_cast<Impl*>(lws_context_user(lws_get_context(wsi)));
    try {
      return impl == nullptr ? 0 : impl->Handle(wsi, reason, static_cast<const char*>(in), n);
    } catch (const std::exception& error) {  // no exception may pass through the library
      LogWarning("a client is disconnected: {}", error.what());
      return -1;
    }
  }

  int Handle(lws* wsi, lws_callback_reasons reason, const char* in, size_t n) {
    switch (reason) {
      case LWS_CALLBACK_HTTP:
        return Refuse(wsi, fmt::format("This is no web page: connect with Foxglove or Lichtblick (ws://HOST:{}).",
                                       lws_get_vhost_listen_port(vhost)));
      case LWS_CALLBACK_HTTP_CONFIRM_UPGRADE:
        return Confirm(wsi);
      case LWS_CALLBACK_ESTABLISHED:
        connections[wsi].client = ++n_clients;
        BoundSendBuffer(lws_get_socket_fd(wsi));
        server.Open(n_clients);
        lws_callback_on_writable(wsi);
        return 0;
      case LWS_CALLBACK_CLOSED:
        if (const auto closed = connections.find(wsi); closed != connections.end()) {
          server.Close(closed->second.client);
          connections.erase(closed);
        }
        return 0;
      case LWS_CALLBACK_RECEIVE:
        return Receive(wsi, in, n);
      case LWS_CALLBACK_SERVER_WRITEABLE:
        return Send(wsi);
      case LWS_CALLBACK_EVENT_WAIT_CANCELLED:
        for (const auto& [client, connection] : connections) {
          if (server.IsTooSlow(connection.client)) {
            lws_set_timeout(client, PENDING_TIMEOUT_CLOSE_SEND, LWS_TO_KILL_ASYNC);
          } else if (server.HasOutput(connection.client)) {
            lws_callback_on_writable(client);
          }
        }
        return 0;
      default:
        return 0;
    }
  }

  int Confirm(lws* wsi) const {
    const std::string wanted = HeaderOf(wsi, WSI_TOKEN_PROTOCOL), origin = HeaderOf(wsi, WSI_TOKEN_ORIGIN);
    if (wanted.find(kSdkProtocol) == std::string::npos && wanted.find(kWebSocketProtocol) == std::string::npos) {
      return Refuse(wsi, fmt::format("The protocols here are {} and {}.", kSdkProtocol, kWebSocketProtocol));
    }
    if (!IsAllowedOrigin(origin, place.origin)) {
      return Refuse(wsi, "Pages of this origin may not connect: name it with --origin.");
    }
    if (connections.size() >= kMostClients) return Refuse(wsi, "There are too many clients.");
    return 0;
  }

  int Receive(lws* wsi, const char* in, size_t n) {
    Connection& connection = connections.at(wsi);
    if (connection.received.size() + n > kMostReceivedBytes) return -1;
    connection.received.append(in, n);
    if (lws_remaining_packet_payload(wsi) != 0 || lws_is_final_fragment(wsi) == 0) return 0;
    const std::string message = std::exchange(connection.received, {});
    if (lws_frame_is_binary(wsi) != 0) {
      server.TakeBinary(connection.client, {reinterpret_cast<const uint8_t*>(message.data()), message.size()});
    } else {
      server.TakeText(connection.client, message);
    }
    lws_callback_on_writable(wsi);
    return 0;
  }

  int Send(lws* wsi) {
    Connection& connection = connections.at(wsi);
    const std::optional<OutFrame> frame = server.Next(connection.client);
    if (!frame) return 0;
    connection.sent.resize(LWS_PRE + frame->size());
    std::memcpy(connection.sent.data() + LWS_PRE, frame->head.data(), frame->head.size());
    if (frame->payload) {
      std::memcpy(connection.sent.data() + LWS_PRE + frame->head.size(), frame->payload->data(),
                  frame->payload->size());
    }
    const auto type = frame->is_binary ? LWS_WRITE_BINARY : LWS_WRITE_TEXT;
    if (lws_write(wsi, connection.sent.data() + LWS_PRE, frame->size(), type) < 0) return -1;
    if (server.HasOutput(connection.client)) lws_callback_on_writable(wsi);
    return 0;
  }

  FoxgloveServer& server;
  const Place place;
  std::array<lws_protocols, 3> protocols{};
  lws_context* context = nullptr;
  lws_vhost* vhost = nullptr;
  std::map<lws*, Connection> connections;
  int64_t n_clients = 0;
  std::atomic<bool> stopped = false;
  std::thread thread;
};

WebSocketServer::WebSocketServer(FoxgloveServer& server, const Place& place)
    : impl_(std::make_unique<Impl>(server, place)) {}

WebSocketServer::~WebSocketServer() = default;

int WebSocketServer::port() const { return lws_get_vhost_listen_port(impl_->vhost); }

void WebSocketServer::Wake() { lws_cancel_service(impl_->context); }

}  // namespace plslam::bridge
