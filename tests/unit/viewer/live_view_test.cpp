#include "viewer_headless/live/live_view.h"

#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <atomic>
#include <thread>
#include <vector>

namespace plslam {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

/// A client without manners: sends any bytes and reads until the other side has enough.
class Socket {
 public:
  explicit Socket(int port) : fd_(socket(AF_INET, SOCK_STREAM, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(static_cast<uint16_t>(port));
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    timeval limit{10, 0};
    setsockopt(fd_, SOL_SOCKET, SO_RCVTIMEO, &limit, sizeof limit);
    connected_ = connect(fd_, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
  }
  ~Socket() { close(fd_); }
  Socket(const Socket&) = delete;
  Socket& operator=(const Socket&) = delete;

  void Send(const std::string& bytes) { send(fd_, bytes.data(), bytes.size(), MSG_NOSIGNAL); }
  void HangUpSending() { shutdown(fd_, SHUT_WR); }
  std::string ReadAll() {
    std::string all;
    char buffer[4096];
    for (ssize_t n = 0; (n = recv(fd_, buffer, sizeof buffer, 0)) > 0;) all.append(buffer, static_cast<size_t>(n));
    return all;
  }
  bool connected() const { return connected_; }

 private:
  int fd_;
  bool connected_ = false;
};

std::string Ask(int port, const std::string& bytes) {
  Socket socket(port);
  socket.Send(bytes);
  socket.HangUpSending();
  return socket.ReadAll();
}

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
  EXPECT_THAT(Ask(port(), Get("/data.json?since=0.1.42.7.-1")), HasSubstr("{\"rows\": 42}"));
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

TEST_F(LiveViewTest, OtherHostsAreTurnedAway) {
  for (const std::string host :
       {"evil.example", "localhost.evil.example", "127.0.0.1.nip.io", "", "[::1", "192.168.0.1"}) {
    EXPECT_THAT(Ask(port(), Get("/", host)), testing::Not(StartsWith("HTTP/1.1 200"))) << host;
  }
}

TEST_F(LiveViewTest, NonsenseDoesNoHarm) {
  EXPECT_THAT(Ask(port(), Get("/../../etc/passwd")), StartsWith("HTTP/1.1 404"));
  EXPECT_THAT(Ask(port(), Get("/data.json?since=junk")), StartsWith("HTTP/1.1 400"));
  EXPECT_THAT(Ask(port(), Get("/data.json?since=" + std::string(5000, '1'))), StartsWith("HTTP/1.1 400"));
  EXPECT_THAT(Ask(port(), Get("/data.json?since")), StartsWith("HTTP/1.1 200"));
  Ask(port(), Get("/" + std::string(200'000, 'a')));
  // Binary garbage may be waited for until the time is up: nobody here does.
  Socket(port()).Send(std::string("\0\xff\x16\x03\x01 GET\r\n\r\n", 13));
  Ask(port(), "GET / HTTP/9.9\r\n\r\n");
  Ask(port(), "GET / HTTP/1.1\r\nHost: localhost\r\nContent-Length: -5\r\n\r\n");
  Ask(port(), "GET / HTTP/1.1\r\nHost: localhost\r\nContent-Length: 99999999999999999999\r\n\r\n");
  Ask(port(), std::string(100'000, '\r'));
  EXPECT_THAT(Ask(port(), Get("/")), StartsWith("HTTP/1.1 200")) << "it still lives";
}

TEST_F(LiveViewTest, MoreConnectionsThanAllowedWaitForTheirTurn) {
  std::vector<std::unique_ptr<Socket>> idle;
  for (int i = 0; i < 16; ++i) {
    idle.push_back(std::make_unique<Socket>(port()));
    // What has begun a request holds its place.
    idle.back()->Send("GET / HTTP/1.1\r\n");
  }
  Socket more(port());
  more.Send(Get("/"));
  idle.front()->Send("Host: localhost\r\nConnection: close\r\n\r\n");
  EXPECT_THAT(idle.front()->ReadAll(), HasSubstr("<page>")) << "those who are in are served";
  EXPECT_THAT(more.ReadAll(), HasSubstr("<page>")) << "and then it is the next one's turn";
}

TEST(LiveView, WhoWaitsIsTurnedAwayAtTheEnd) {
  std::string answer;
  std::thread client;
  {
    LiveView view(0, "<page>");
    // Nobody answers; the client has asked when its question could be taken.
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

TEST(LiveView, IsNotHeardBeyondThisMachine) {
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
}  // namespace plslam
