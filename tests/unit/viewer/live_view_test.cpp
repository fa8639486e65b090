// SPDX-License-Identifier: BSD-3-Clause
#include "viewer_headless/live/live_view.h"

#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <thread>
#include <vector>

#include "tests/support/http_client.h"

namespace plslam::viewer {
namespace {

using test::Ask;
using test::HttpSocket;
using testing::HasSubstr;
using testing::StartsWith;

std::string Get(const std::string& target, const std::string& host = "localhost") {
  return "GET " + target + " HTTP/1.1\r\nHost: " + host + "\r\nConnection: close\r\n\r\n";
}

/// A view whose data are given by a thread of the test, as the node would give them.
class LiveViewTest : public testing::Test {
 protected:
  LiveViewTest() : view_(0, "<page>"), owner_([this] { Own(); }) {}
  ~LiveViewTest() override {
    done_ = true;
    owner_.join();
  }

  void Own() {
    while (!done_) {
      view_.Answer([](const ReportSince& since) { return "{\"rows\": " + std::to_string(since.rows) + "}"; });
      std::this_thread::yield();
    }
  }

  int port() const { return view_.port(); }

  std::atomic<bool> done_ = false;
  LiveView view_;
  std::thread owner_;
};

TEST_F(LiveViewTest, GivesThePageAndTheData) {
  const std::string page = Ask(port(), Get("/"));
  EXPECT_THAT(page, StartsWith("HTTP/1.1 200"));
  EXPECT_THAT(page, HasSubstr("\r\n\r\n<page>"));
  EXPECT_THAT(page, HasSubstr("text/html"));
  EXPECT_THAT(page, HasSubstr("nosniff"));
  EXPECT_THAT(Ask(port(), Get("/data.json")), HasSubstr("{\"rows\": 0}"));
  EXPECT_THAT(Ask(port(), Get("/data.json?since=0.1.42.7.-1.-1")), HasSubstr("{\"rows\": 42}"));
  EXPECT_THAT(Ask(port(), Get("/", "127.0.0.1:1234")), StartsWith("HTTP/1.1 200"));
  EXPECT_THAT(Ask(port(), Get("/", "[::1]:1234")), StartsWith("HTTP/1.1 200"));
}

TEST_F(LiveViewTest, OnlyGetIsAnswered) {
  for (const std::string method : {"POST", "PUT", "DELETE", "OPTIONS", "PATCH", "BREW"}) {
    const std::string answer =
        Ask(port(), method + " /data.json HTTP/1.1\r\nHost: localhost\r\nContent-Length: 3\r\n\r\nabc");
    EXPECT_THAT(answer, StartsWith("HTTP/1.1 405")) << method;
  }
  EXPECT_THAT(Ask(port(), "HEAD / HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n"),
              StartsWith("HTTP/1.1 200"));
}

TEST_F(LiveViewTest, OtherHostsAreRejected) {
  for (const std::string host :
       {"evil.example", "localhost.evil.example", "127.0.0.1.nip.io", "", "[::1", "192.168.0.1"}) {
    EXPECT_THAT(Ask(port(), Get("/", host)), testing::Not(StartsWith("HTTP/1.1 200"))) << host;
  }
}

TEST_F(LiveViewTest, MalformedRequestsAreHarmless) {
  EXPECT_THAT(Ask(port(), Get("/../../etc/passwd")), StartsWith("HTTP/1.1 404"));
  EXPECT_THAT(Ask(port(), Get("/data.json?since=junk")), StartsWith("HTTP/1.1 400"));
  EXPECT_THAT(Ask(port(), Get("/data.json?since=" + std::string(5000, '1'))), StartsWith("HTTP/1.1 400"));
  EXPECT_THAT(Ask(port(), Get("/data.json?since")), StartsWith("HTTP/1.1 200"));
  Ask(port(), Get("/" + std::string(200'000, 'a')));
  // The server may wait for the rest of binary garbage until its timeout; this test does not.
  HttpSocket(port()).Send(std::string("\0\xff\x16\x03\x01 GET\r\n\r\n", 13));
  Ask(port(), "GET / HTTP/9.9\r\n\r\n");
  Ask(port(), "GET / HTTP/1.1\r\nHost: localhost\r\nContent-Length: -5\r\n\r\n");
  Ask(port(), "GET / HTTP/1.1\r\nHost: localhost\r\nContent-Length: 99999999999999999999\r\n\r\n");
  Ask(port(), std::string(100'000, '\r'));
  EXPECT_THAT(Ask(port(), Get("/")), StartsWith("HTTP/1.1 200")) << "it still lives";
}

TEST_F(LiveViewTest, IdleConnectionsDoNotBlockOthers) {
  std::vector<std::unique_ptr<HttpSocket>> idle;
  for (int i = 0; i < 100; ++i) {
    idle.push_back(std::make_unique<HttpSocket>(port()));
    idle.back()->Send("GET / HTTP/1.1\r\n");
  }
  EXPECT_THAT(Ask(port(), Get("/")), HasSubstr("<page>"));
  idle.front()->Send("Host: localhost\r\nConnection: close\r\n\r\n");
  EXPECT_THAT(idle.front()->ReadAll(), HasSubstr("<page>"));
}

TEST_F(LiveViewTest, ManySlowClientsAreDisconnected) {
  std::vector<std::unique_ptr<HttpSocket>> slow;
  for (int i = 0; i < 300; ++i) slow.push_back(std::make_unique<HttpSocket>(port()));
  std::atomic<bool> over = false;
  std::thread dripping([&] {
    const std::string head = "GET /" + std::string(10'000, 'a');
    for (size_t at = 0; !over && at < head.size(); ++at) {
      for (const auto& socket : slow) socket->Send(head.substr(at, 1));
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
    }
  });
  const auto began = std::chrono::steady_clock::now();
  std::string page;
  // Retries like a browser that was rejected.
  while (page.empty() && std::chrono::steady_clock::now() - began < std::chrono::seconds(30)) {
    page = Ask(port(), Get("/"));
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
  EXPECT_THAT(page, HasSubstr("<page>"));
  std::printf("  served after %.1f s\n",
              std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count());
  over = true;
  dripping.join();
}

TEST_F(LiveViewTest, ClientsDoNotBlockEachOther) {
  // The first client waits for the end, which does not come.
  HttpSocket waits(port());
  waits.Send(Get("/end"));
  EXPECT_THAT(Ask(port(), Get("/data.json")), HasSubstr("{\"rows\": 0}"));
  EXPECT_THAT(Ask(port(), Get("/")), HasSubstr("<page>"));
  view_.SetFinished(true);
  EXPECT_THAT(waits.ReadAll(), HasSubstr("\r\n\r\nfinished"));
}

TEST(LiveView, LastDataFollowTheEnd) {
  LiveView view(0, "<page>");
  std::string end, data;
  std::atomic<bool> asked = false;
  // Like the page: new data are requested when the end is known.
  std::thread page([&] {
    HttpSocket socket(view.port());
    socket.Send(Get("/end"));
    asked = true;
    end = socket.ReadAll();
    data = Ask(view.port(), Get("/data.json"));
  });
  while (!asked) std::this_thread::yield();
  const auto json = [](const ReportSince&) { return std::string("{\"finished\": true}"); };
  // Its arrival cannot be observed from here.
  std::this_thread::sleep_for(std::chrono::milliseconds(200));
  const auto began = std::chrono::steady_clock::now();
  view.SetFinished(true);
  view.SendFinalData(json);
  EXPECT_LT(std::chrono::steady_clock::now() - began, std::chrono::milliseconds(1900)) << "no longer than needed";
  page.join();
  EXPECT_THAT(end, HasSubstr("finished"));
  EXPECT_THAT(data, HasSubstr("{\"finished\": true}"));
}

TEST(LiveView, EndIsImmediateWithoutAPage) {
  LiveView view(0, "<page>");
  view.SetFinished(true);
  const auto began = std::chrono::steady_clock::now();
  view.SendFinalData([](const ReportSince&) { return std::string(); });
  EXPECT_LT(std::chrono::steady_clock::now() - began, std::chrono::seconds(1));
}

TEST(LiveView, WaitingClientIsRejectedAtTheEnd) {
  std::string answer;
  std::thread client;
  {
    LiveView view(0, "<page>");
    // The request is not answered; it has arrived when it could be taken.
    client = std::thread([&answer, port = view.port()] { answer = Ask(port, Get("/data.json")); });
    std::atomic<bool> asked = false;
    while (!asked) {
      view.Answer([&](const ReportSince&) {
        asked = true;
        return std::string("{}");
      });
      std::this_thread::yield();
    }
  }
  client.join();
  EXPECT_THAT(answer, testing::AnyOf(HasSubstr("{}"), HasSubstr("503"), testing::IsEmpty()));
}

TEST(LiveView, ATakenPortIsOneSentence) {
  const LiveView first(0, "");
  EXPECT_THAT(
      [&] { LiveView(first.port(), ""); },
      testing::ThrowsMessage<std::runtime_error>(HasSubstr("of 127.0.0.1 cannot be served: Address already in use")));
}

TEST(LiveView, ListensOnThisMachineOnly) {
  const LiveView view(0, "");
  // 127.0.0.2 is this machine as well, but not the address that is served.
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<uint16_t>(view.port()));
  inet_pton(AF_INET, "127.0.0.2", &address.sin_addr);
  const int fd = socket(AF_INET, SOCK_STREAM, 0);
  EXPECT_NE(connect(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  close(fd);
}

}  // namespace
}  // namespace plslam::viewer
