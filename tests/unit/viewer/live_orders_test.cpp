// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <sodium.h>

#include <atomic>
#include <nlohmann/json.hpp>
#include <random>
#include <set>
#include <thread>

#include "tests/support/http_client.h"
#include "viewer_headless/live/live_view.h"

namespace plslam::viewer {
namespace {

using test::Ask;
using test::HttpSocket;
using testing::HasSubstr;
using testing::StartsWith;

const std::string kHeader = "X-PLSLAM-Order: 1\r\n";

std::string Post(const std::string& target, const std::string& headers, const std::string& body = "",
                 const std::string& host = "localhost:8080") {
  return "POST " + target + " HTTP/1.1\r\nHost: " + host + "\r\n" + headers +
         "Content-Length: " + std::to_string(body.size()) + "\r\nConnection: close\r\n\r\n" + body;
}

/// A live page, and an owner that carries out each order at once, but for those about the file "bad".
class LiveOrders : public testing::Test {
 protected:
  explicit LiveOrders(std::optional<OrderKey> key = std::nullopt)
      : view_(0, "<page>", {key, "/out/map.plmap"}), owner_([this] { Own(); }) {}
  ~LiveOrders() override {
    done_ = true;
    owner_.join();
  }

  void Own() {
    while (!done_) {
      const std::optional<LiveView::Order> order = view_.TakeOrder();
      if (order) {
        ++n_orders_;
        verbs_.insert(order->verb);
        view_.AnswerOrder(order->argument != "bad", "did " + order->verb + " '" + order->argument + "'");
      }
      std::this_thread::yield();
    }
  }

  std::string Give(const std::string& verb, const std::string& body = "", const std::string& headers = kHeader) {
    return Ask(view_.port(), Post("/orders/" + verb, headers, body));
  }
  nlohmann::json Description() {
    const std::string answer =
        Ask(view_.port(), "GET /orders HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n");
    return nlohmann::json::parse(answer.substr(answer.find("\r\n\r\n")));
  }

  std::atomic<bool> done_ = false;
  std::atomic<int> n_orders_ = 0;
  std::set<std::string> verbs_;  ///< of the owner's thread
  LiveView view_;
  std::thread owner_;
};

TEST_F(LiveOrders, AreAnsweredByTheOwnersSentence) {
  for (const std::string verb : {"pause", "resume", "reset"}) {
    const std::string answer = Give(verb);
    EXPECT_THAT(answer, StartsWith("HTTP/1.1 200"));
    EXPECT_THAT(answer, HasSubstr("\r\n\r\ndid " + verb + " ''\n"));
  }
  EXPECT_THAT(Give("save", "--force a b.plmap"), HasSubstr("did save '--force a b.plmap'"));
  EXPECT_THAT(Give("save", "bad"), StartsWith("HTTP/1.1 422"));
  EXPECT_EQ(n_orders_, 5);
  EXPECT_EQ(Description()["needs_key"], false);
  EXPECT_EQ(Description()["file"], "/out/map.plmap");
}

TEST_F(LiveOrders, AreRefusedFromElsewhere) {
  EXPECT_THAT(Ask(view_.port(), "GET /orders/pause HTTP/1.1\r\nHost: localhost\r\n" + kHeader + "\r\n"),
              StartsWith("HTTP/1.1 404"));
  EXPECT_THAT(Give("pause", "", ""), StartsWith("HTTP/1.1 403")) << "a form of any page sends it";
  EXPECT_THAT(Give("pause", "", "X-PLSLAM-Order: 0\r\n"), StartsWith("HTTP/1.1 403"));
  EXPECT_THAT(Give("pause", "", kHeader + "Origin: http://evil.example\r\n"), StartsWith("HTTP/1.1 403"));
  EXPECT_THAT(Give("pause", "", kHeader + "Origin: null\r\n"), StartsWith("HTTP/1.1 403"));
  EXPECT_THAT(Give("pause", "", kHeader + "Origin: http://localhost:9090\r\n"), StartsWith("HTTP/1.1 403"))
      << "another service of this machine";
  EXPECT_THAT(Give("pause", "", kHeader + "Origin: https://localhost:8080\r\n"), StartsWith("HTTP/1.1 403"));
  EXPECT_THAT(Give("pause", "", kHeader + "Sec-Fetch-Site: cross-site\r\n"), StartsWith("HTTP/1.1 403"));
  EXPECT_THAT(Give("pause", "", kHeader + "Sec-Fetch-Site: same-site\r\n"), StartsWith("HTTP/1.1 403"));
  EXPECT_THAT(Ask(view_.port(), Post("/orders/pause", kHeader, "", "evil.example:8080")), StartsWith("HTTP/1.1 403"));
  EXPECT_THAT(Ask(view_.port(), "OPTIONS /orders/pause HTTP/1.1\r\nHost: localhost\r\n\r\n"),
              StartsWith("HTTP/1.1 405"))
      << "a preflight";
  EXPECT_THAT(Ask(view_.port(), Post("/data.json", kHeader)), StartsWith("HTTP/1.1 405"));
  EXPECT_EQ(n_orders_, 0);
  EXPECT_THAT(Give("pause", "", kHeader + "Origin: http://localhost:8080\r\nSec-Fetch-Site: same-origin\r\n"),
              StartsWith("HTTP/1.1 200"));
}

TEST_F(LiveOrders, BadOnesAreRefused) {
  for (const std::string verb : {"", "load", "finish", "go_back", "pause/", "Pause", "save?x", "../end"}) {
    EXPECT_THAT(Give(verb, ""), testing::AnyOf(StartsWith("HTTP/1.1 404"), StartsWith("HTTP/1.1 400"))) << verb;
  }
  EXPECT_THAT(Give("pause", "x"), StartsWith("HTTP/1.1 400"));
  EXPECT_THAT(Give("save", ""), StartsWith("HTTP/1.1 400"));
  EXPECT_THAT(Give("save", std::string("a\0b", 3)), StartsWith("HTTP/1.1 400"));
  EXPECT_THAT(Give("save", "a\nb"), StartsWith("HTTP/1.1 400"));
  EXPECT_THAT(Give("save", std::string(4097, 'a')), StartsWith("HTTP/1.1 413"));
  EXPECT_EQ(n_orders_, 0);
  EXPECT_THAT(Give("save", std::string(4096, 'a')), StartsWith("HTTP/1.1 200"));
}

TEST_F(LiveOrders, ChunkedBodiesAreBoundedToo) {
  const std::string head = "POST /orders/save HTTP/1.1\r\nHost: localhost\r\n" + kHeader +
                           "Transfer-Encoding: chunked\r\nConnection: close\r\n\r\n";
  EXPECT_THAT(Ask(view_.port(), head + "3\r\na.b\r\n2\r\nmp\r\n0\r\n\r\n"), HasSubstr("did save 'a.bmp'"));
  std::string large = head;
  for (int i = 0; i < 1000; ++i) large += "64\r\n" + std::string(100, 'a') + "\r\n";
  EXPECT_THAT(Ask(view_.port(), large + "0\r\n\r\n"), StartsWith("HTTP/1.1 413"));
  EXPECT_EQ(n_orders_, 1);
}

TEST_F(LiveOrders, AnUnfinishedBodyIsCut) {
  HttpSocket socket(view_.port());
  socket.Send("POST /orders/save HTTP/1.1\r\nHost: localhost\r\n" + kHeader + "Content-Length: 100\r\n\r\nabc");
  const auto began = std::chrono::steady_clock::now();
  socket.ReadAll();
  EXPECT_LT(std::chrono::steady_clock::now() - began, std::chrono::seconds(9));
  EXPECT_EQ(n_orders_, 0);
}

TEST_F(LiveOrders, MutatedRequestsGiveNoOtherOrders) {
  std::mt19937 random(7);
  const auto below = [&](size_t n) { return std::uniform_int_distribution<size_t>(0, n - 1)(random); };
  const std::string whole = Post("/orders/save", kHeader + "Origin: http://localhost:8080\r\n", "a.plmap");
  for (int i = 0; i < 1500; ++i) {
    std::string bytes = whole;
    for (size_t n = 1 + below(3); n > 0; --n) {
      const size_t at = below(bytes.size());
      switch (below(4)) {
        case 0:
          bytes[at] = static_cast<char>(below(256));
          break;
        case 1:
          bytes.erase(at, 1 + below(8));
          break;
        case 2:
          bytes.insert(at, bytes.substr(below(bytes.size()), below(40)));
          break;
        default:
          bytes.resize(at + 1);
          break;
      }
    }
    // Without waiting for answers to requests that lack their end.
    HttpSocket socket(view_.port());
    socket.Send(bytes);
  }
  // Some mutated ones are still being carried out.
  std::string answer = Give("save", "after");
  while (answer.starts_with("HTTP/1.1 409")) answer = Give("save", "after");
  EXPECT_THAT(answer, HasSubstr("did save 'after'"));
  done_ = true;
  owner_.join();
  for (const std::string& verb : verbs_) EXPECT_EQ(verb, "save");
  owner_ = std::thread([] {});
}

TEST(LiveOrder, WaitingOnesEndWithThePage) {
  std::string answer, second;
  std::thread client;
  {
    LiveView view(0, "<page>");
    client = std::thread([&answer, port = view.port()] { answer = Ask(port, Post("/orders/pause", kHeader)); });
    while (!view.TakeOrder()) std::this_thread::yield();
    second = Ask(view.port(), Post("/orders/resume", kHeader));
  }
  client.join();
  EXPECT_THAT(answer, StartsWith("HTTP/1.1 503"));
  EXPECT_THAT(second, StartsWith("HTTP/1.1 409")) << "one at a time";
}

OrderKey SomeKey() {
  OrderKey key{};
  for (size_t i = 0; i < key.size(); ++i) key[i] = static_cast<uint8_t>(7 * i);
  return key;
}

class KeyedOrders : public LiveOrders {
 protected:
  KeyedOrders() : LiveOrders(SomeKey()) {}

  static std::string Proof(const OrderKey& key, const std::string& text) {
    std::array<uint8_t, crypto_auth_hmacsha256_BYTES> mac{};
    static_assert(crypto_auth_hmacsha256_KEYBYTES == std::tuple_size_v<OrderKey>);
    crypto_auth_hmacsha256(mac.data(), reinterpret_cast<const uint8_t*>(text.data()), text.size(), key.data());
    std::string hex;
    for (const uint8_t byte : mac) hex += {"0123456789abcdef"[byte >> 4], "0123456789abcdef"[byte & 15]};
    return hex;
  }
  std::string Challenge() { return Description()["challenge"]; }
  std::string GiveProved(const std::string& verb, const std::string& body, const std::string& proof) {
    return Give(verb, body, kHeader + "X-PLSLAM-Proof: " + proof + "\r\n");
  }
};

TEST_F(KeyedOrders, NeedAProof) {
  EXPECT_EQ(Description()["needs_key"], true);
  EXPECT_THAT(Give("pause"), StartsWith("HTTP/1.1 401"));
  EXPECT_THAT(GiveProved("pause", "", ""), StartsWith("HTTP/1.1 401"));
  EXPECT_THAT(GiveProved("pause", "", std::string(64, '0')), StartsWith("HTTP/1.1 401"));
  OrderKey other = SomeKey();
  other[31] ^= 1;
  EXPECT_THAT(GiveProved("pause", "", Proof(other, Challenge() + "\npause\n")), StartsWith("HTTP/1.1 401"));
  const std::string proof = Proof(SomeKey(), Challenge() + "\nsave\na.plmap");
  EXPECT_THAT(GiveProved("reset", "", proof), StartsWith("HTTP/1.1 401")) << "a proof of another order";
  EXPECT_THAT(GiveProved("save", "b.plmap", proof), StartsWith("HTTP/1.1 401")) << "of another file";
  EXPECT_EQ(n_orders_, 0);
  EXPECT_THAT(GiveProved("save", "a.plmap", proof), HasSubstr("did save 'a.plmap'"));
  EXPECT_THAT(GiveProved("save", "a.plmap", proof), StartsWith("HTTP/1.1 401")) << "sent again";
  EXPECT_EQ(n_orders_, 1);
}

}  // namespace
}  // namespace plslam::viewer
