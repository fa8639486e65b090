// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <vector>

#include "core/bus/transport/authenticator.h"
#include "core/io/maps/map_file.h"
#include "core/run/process_names.h"
#include "tests/integration/run_watcher.h"
#include "tests/integration/whole_run.h"
#include "tests/support/data_folder.h"
#include "tests/support/http_client.h"
#include "tests/support/key_file.h"
#include "tests/support/text_file.h"
#include "tools/launch/child_process.h"
#include "viewer_headless/live/order_proof.h"

namespace plslam {
namespace {

using test::Heard;
using test::RunWatcher;
using test::WholeRun;
using testing::HasSubstr;

/// A run of a small world, a listener, and a source of orders.
class Orders : public testing::Test {
 protected:
  static constexpr const char* kWorld = "synthetic:room?size=376x240&frames=120";
  static constexpr const char* kLongWorld = "synthetic:room?size=376x240&frames=200";

  /// At the pace of the data, so that there is time for orders on any machine.
  std::vector<std::string> Arguments(const char* world = kWorld) const {
    return {"run",        world,
            "--url",      watcher_.url(),
            "--pace",     "realtime",
            "--set",      "mapping.state_every=10",
            "--save-map", File("new.plmap").string()};
  }

  /// Returns the exit code of `plslam ORDER... --url URL`; its output is in `said_`.
  int Order(std::vector<std::string> order) {
    order.insert(order.end(), {"--url", watcher_.url()});
    const std::filesystem::path log = run_.folder() / "order.log";
    std::filesystem::remove(log);
    launcher::ChildProcess process(test::BinaryFolder() / "plslam", order, log);
    EXPECT_TRUE(WholeRun::WaitFor([&] { return process.Poll().has_value(); }));
    said_ = ReadText(log);
    return process.Poll().value_or(launcher::ChildExit{-1}).code;
  }

  /// Kills a process of the run, and waits until its replacement runs.
  void Kill(const std::string& name, const std::string& executable) {
    const pid_t pid = run_.PidOf(executable);
    ASSERT_GT(pid, 0);
    ASSERT_EQ(kill(pid, SIGKILL), 0);
    ASSERT_TRUE(WholeRun::WaitFor([&] {
      const pid_t next = run_.PidOf(executable);
      return next > 0 && next != pid && watcher_.WaitUntilReady(name, next, 1);
    })) << run_.Logs();
  }

  bool HasSessions(size_t n) const {
    return watcher_.WaitFor([n](const Heard& heard) { return heard.poses.size() >= n; });
  }

  std::set<SessionId> SessionsOf(const std::filesystem::path& map) const {
    std::set<SessionId> sessions;
    const StoredMap stored = ReadMapFile(map.string());
    for (const auto& [id, keyframe] : stored.map.keyframes()) sessions.insert(keyframe.name.session);
    return sessions;
  }

  std::filesystem::path File(const std::string& name) const { return run_.folder() / name; }

  WholeRun run_;
  RunWatcher watcher_;
  std::string said_;
};

TEST_F(Orders, PausedPlayerStaysPausedAfterAKill) {
  WholeRun reference;
  ASSERT_EQ(reference.Run({"run", kWorld}), 0) << reference.Logs();

  run_.Start({"run", kWorld, "--url", watcher_.url()});
  ASSERT_TRUE(watcher_.WaitForFrame(10));
  ASSERT_EQ(Order({"pause"}), 0) << said_;
  Kill("player", "player");
  Kill("vo", "vo_process");
  // The frames after the last keyframe are sent again, and no others.
  const int64_t newest = watcher_.Get().newest_frame;
  EXPECT_LT(newest, 119);
  EXPECT_FALSE(watcher_.WaitForFrame(newest + 1, 3));
  ASSERT_EQ(Order({"resume"}), 0) << said_;
  ASSERT_EQ(run_.Wait(), 0) << run_.Logs();
  EXPECT_EQ(run_.Read("trajectory.tum"), reference.Read("trajectory.tum"));
}

TEST_F(Orders, ResetMapSurvivesAMapperKill) {
  run_.Start(Arguments());
  ASSERT_TRUE(watcher_.WaitForFrame(30));
  ASSERT_EQ(Order({"reset"}), 0) << said_;
  ASSERT_TRUE(HasSessions(2)) << run_.Logs();
  Kill("mapping", "mapping_process");
  ASSERT_EQ(run_.Wait(), 0) << run_.Logs();
  EXPECT_EQ(watcher_.Get().poses.size(), 2U);
  EXPECT_EQ(SessionsOf(File("new.plmap")), std::set{SessionId(watcher_.Get().poses.rbegin()->first)});
}

TEST_F(Orders, LoadContinuesInASavedMap) {
  WholeRun before;
  ASSERT_EQ(before.Run({"run", kWorld, "--save-map", File("old.plmap").string()}), 0) << before.Logs();
  std::ofstream(File("none.plmap")) << "not a map";
  run_.Start(Arguments());
  ASSERT_TRUE(watcher_.WaitForFrame(20));
  EXPECT_EQ(Order({"load", File("none.plmap").string()}), 1);
  EXPECT_THAT(said_, HasSubstr("none.plmap"));
  ASSERT_EQ(Order({"pause"}), 0) << said_;
  EXPECT_EQ(watcher_.Get().poses.size(), 1U);
  ASSERT_EQ(Order({"load", File("old.plmap").string()}), 0) << said_;
  ASSERT_EQ(Order({"resume"}), 0) << said_;
  ASSERT_EQ(run_.Wait(), 0) << run_.Logs();
  const std::set<SessionId> old = SessionsOf(File("old.plmap"));
  std::set<SessionId> expected = old;
  expected.insert(SessionId(watcher_.Get().poses.rbegin()->first));
  EXPECT_EQ(SessionsOf(File("new.plmap")), expected);
}

TEST_F(Orders, LocaliseOnFreezesTheMapUntilOff) {
  run_.Start(Arguments(kLongWorld));
  ASSERT_TRUE(watcher_.WaitForFrame(15));
  ASSERT_EQ(Order({"localise", "on"}), 0) << said_;
  const auto mapped = watcher_.Get().mapped;
  const int64_t newest = watcher_.Get().newest_frame;
  Kill("mapping", "mapping_process");
  ASSERT_TRUE(watcher_.WaitForFrame(newest + 20)) << run_.Logs();
  ASSERT_EQ(Order({"pause"}), 0) << said_;
  EXPECT_EQ(watcher_.Get().mapped, mapped);
  EXPECT_EQ(watcher_.Get().poses.size(), 1U);
  ASSERT_LT(watcher_.Get().newest_frame, 170) << "too late for what follows";
  ASSERT_EQ(Order({"localise", "off"}), 0) << said_;
  ASSERT_EQ(Order({"resume"}), 0) << said_;
  ASSERT_EQ(run_.Wait(), 0) << run_.Logs();
  EXPECT_EQ(watcher_.Get().poses.size(), 2U) << "keyframes that were not sent are no gap in a session";
  EXPECT_EQ(SessionsOf(File("new.plmap")).size(), 2U);
  EXPECT_EQ(watcher_.Get().lost_frames, 0);
}

/// A run with a live page, whose buttons are pressed as a browser does.
class LivePageOrders : public Orders {
 protected:
  void Start(std::vector<std::string> more) {
    std::vector<std::string> arguments = Arguments(kLongWorld);
    more.insert(more.end(), {"--serve", std::to_string(port_)});
    arguments.insert(arguments.end(), more.begin(), more.end());
    run_.Start(arguments);
  }
  std::string Send(const std::string& method, const std::string& target, const std::string& headers,
                   const std::string& body = "") const {
    return test::Ask(port_, method + " " + target + " HTTP/1.1\r\nHost: 127.0.0.1:" + std::to_string(port_) + "\r\n" +
                                headers + "Content-Length: " + std::to_string(body.size()) +
                                "\r\nConnection: close\r\n\r\n" + body);
  }
  /// Returns the status and the sentence: "200 paused".
  std::string Press(const std::string& verb, const std::string& body = "", const std::string& proof = "") const {
    return Short(Send("POST", "/orders/" + verb, kHeader + "X-PLSLAM-Proof: " + proof + "\r\n", body));
  }
  nlohmann::json Description() const {
    const std::string answer = Send("GET", "/orders", "");
    return nlohmann::json::parse(answer.substr(answer.find("\r\n\r\n")));
  }
  static std::string Short(const std::string& answer) {
    const size_t body = answer.find("\r\n\r\n");
    if (body == std::string::npos) return "no answer: " + answer;
    return answer.substr(9, 4) + answer.substr(body + 4, answer.size() - body - 5);
  }

  const std::string kHeader = "X-PLSLAM-Order: 1\r\n";
  const int port_ = test::FreePort();
};

TEST_F(LivePageOrders, ButtonsDoWhatTheCommandsDo) {
  Start({});
  ASSERT_TRUE(watcher_.WaitForFrame(20)) << run_.Logs();
  EXPECT_EQ(Press("pause"), "200 paused");
  ASSERT_EQ(Order({"pause"}), 0);
  EXPECT_EQ(said_, "paused\n") << "the same sentence";
  const int64_t newest = watcher_.Get().newest_frame;
  EXPECT_FALSE(watcher_.WaitForFrame(newest + 10, 2)) << "paused";

  const std::string proposed = Description()["file"];
  EXPECT_EQ(proposed, (run_.out() / "map.plmap").string());
  EXPECT_EQ(Press("save", proposed), "200 the map is saved in " + proposed);
  EXPECT_EQ(SessionsOf(proposed).size(), 1U);
  EXPECT_EQ(Press("save", "map.plmap"), "200 the map is saved in " + proposed) << "an older state of the same map";
  std::ofstream(run_.out() / "letter.txt") << "Dear reader";
  EXPECT_THAT(Press("save", "letter.txt"), testing::MatchesRegex("422 .*letter.txt: exists, and is not a map;.*"));
  EXPECT_EQ(run_.Read("letter.txt"), "Dear reader");
  EXPECT_EQ(Press("save", "--force letter.txt"), "200 the map is saved in " + (run_.out() / "letter.txt").string());

  EXPECT_THAT(Send("GET", "/orders/reset", kHeader), testing::StartsWith("HTTP/1.1 404"));
  EXPECT_THAT(Send("POST", "/orders/reset", ""), testing::StartsWith("HTTP/1.1 403"));
  EXPECT_THAT(Send("POST", "/orders/reset", kHeader + "Origin: http://evil.example\r\n"),
              testing::StartsWith("HTTP/1.1 403"));
  EXPECT_THAT(Send("POST", "/orders/save", kHeader, std::string(5000, 'a')), testing::StartsWith("HTTP/1.1 413"));
  EXPECT_EQ(Press("resume"), "200 resumed");
  ASSERT_TRUE(watcher_.WaitForFrame(newest + 10)) << run_.Logs();
  EXPECT_EQ(watcher_.Get().poses.size(), 1U) << "no rejected order was carried out";
  EXPECT_EQ(Press("reset"), "200 a new map was started");
  ASSERT_TRUE(HasSessions(2)) << run_.Logs();
  ASSERT_EQ(run_.Wait(), 0) << run_.Logs();
}

TEST_F(LivePageOrders, OrdersNeedTheKeyOfTheBus) {
  const std::string key = test::KeyFile(run_.folder(), 'a');
  Start({"--set", "bus.key_file=" + key});
  ASSERT_TRUE(WholeRun::WaitFor([&] { return !Send("GET", "/", "").empty(); })) << run_.Logs();
  EXPECT_EQ(Press("pause").substr(0, 3), "401");
  EXPECT_EQ(Press("pause", "", ReadText(key)).substr(0, 3), "401") << "the key itself is no proof";
  const nlohmann::json description = Description();
  EXPECT_EQ(description["needs_key"], true);
  const std::string proof =
      viewer::OrderProof::Compute(bus::ReadKey(key), std::string(description["challenge"]), command_verb::kPause, "");
  EXPECT_EQ(Press("pause", "", proof), "200 paused");
  EXPECT_EQ(Press("pause", "", proof).substr(0, 3), "401") << "sent again";
  run_.process().Signal(SIGINT);
  EXPECT_NE(run_.Wait(), -1) << run_.Logs();
}

TEST_F(Orders, OrderWithoutReceiverFails) {
  EXPECT_EQ(Order({"pause"}), 1);
  EXPECT_THAT(said_, HasSubstr("plslam: pause: waiting up to 10 s for a process 'player' or 'camera' on udpm://"));
  EXPECT_THAT(said_, HasSubstr("no process 'player' or 'camera' was found"));
  EXPECT_EQ(Order({"localise", "perhaps"}), 1);
}

}  // namespace
}  // namespace plslam
