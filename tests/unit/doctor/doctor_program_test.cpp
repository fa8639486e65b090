// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <thread>

#include "core/process/process_status.h"
#include "tests/support/data_folder.h"
#include "tests/support/text_file.h"

namespace plslam::doctor {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class DoctorProgram : public testing::Test {
 protected:
  DoctorProgram() {
    std::string pattern = testing::TempDir() + "doctor XXXXXX";
    folder_ = mkdtemp(pattern.data());
  }
  ~DoctorProgram() override { fs::remove_all(folder_); }

  std::string Doctor(const std::string& arguments) const {
    return fmt::format("'{}' doctor --out '{}' {}", (test::BinaryFolder() / "plslam").string(), folder_.string(),
                       arguments);
  }
  int Shell(const std::string& command) const {
    std::ofstream(folder_ / "script") << command << "\n";
    const std::string line = fmt::format("sh '{0}/script' >'{0}/out' 2>'{0}/error'", folder_.string());
    return WEXITSTATUS(std::system(line.c_str()));  // NOLINT: the test runs the program
  }
  /// Runs it in a new network namespace: without any route, the loopback device down.
  int InNewNetwork(const std::string& command) const {
    std::ofstream(folder_ / "inside") << command << "\n";
    return Shell(fmt::format("unshare --map-root-user --net sh '{}/inside'", folder_.string()));
  }
  std::string Text(const std::string& name) const { return ReadText(folder_ / name); }
  nlohmann::json Json() const { return nlohmann::json::parse(Text("out"), nullptr, false); }
  /// Findings of one kind of check that are not good.
  std::vector<nlohmann::json> Bad(const std::string& check) const {
    std::vector<nlohmann::json> bad;
    const nlohmann::json json = Json();
    for (const auto& f : json["findings"]) {
      if (f["check"] == check && f["verdict"] != "good") bad.push_back(f);
    }
    return bad;
  }
  std::string KeyFile(const std::string& name, char digit) const {
    std::ofstream(folder_ / name) << std::string(64, digit) << "\n";
    return (folder_ / name).string();
  }
  fs::path folder_;
};

/// A process that only publishes its status.
class FakeProcess {
 public:
  FakeProcess(const std::string& name, const bus::BusOptions& options)
      : bus_(options, name), status_(name, options, bus_) {
    thread_ = std::thread([this] { bus_.Run(); });
    status_.SetState("running");
  }
  ~FakeProcess() {
    bus_.Stop();
    thread_.join();
  }
  FakeProcess(const FakeProcess&) = delete;
  FakeProcess& operator=(const FakeProcess&) = delete;

 private:
  bus::Bus bus_;
  bus::StatusPublisher status_;
  std::thread thread_;
};

/// Network namespaces may be forbidden.
#define REQUIRE_NETWORKS() \
  if (InNewNetwork("ip link") != 0) GTEST_SKIP() << "no network namespaces here: " << Text("error")

TEST_F(DoctorProgram, SuggestedRouteRepairsANetwork) {
  REQUIRE_NETWORKS();
  EXPECT_EQ(InNewNetwork(Doctor("--listen 0 --json --url 'udpm://239.255.76.67:7667?ttl=0'")), 1) << Text("error");
  const auto bad = Bad("multicast");
  ASSERT_EQ(bad.size(), 1U) << Text("out");
  EXPECT_THAT(bad[0]["what"].get<std::string>(), HasSubstr("no route to the multicast group"));
  std::string mend = bad[0]["mend"];
  for (size_t at = mend.find("sudo "); at != std::string::npos; at = mend.find("sudo ")) mend.erase(at, 5);
  EXPECT_EQ(InNewNetwork(mend + " && " + Doctor("--listen 0 --json --url 'udpm://239.255.76.67:7667?ttl=0'")), 0)
      << mend << "\n"
      << Text("out") << Text("error");
  EXPECT_TRUE(Json()["healthy"].get<bool>());
}

TEST_F(DoctorProgram, TtlOneOverTheLoopbackDevice) {
  REQUIRE_NETWORKS();
  EXPECT_EQ(InNewNetwork("ip link set lo up && ip route add 224.0.0.0/4 dev lo && " +
                         Doctor("--listen 0 --json --url 'udpm://239.255.76.67:7667?ttl=1'")),
            1);
  ASSERT_EQ(Bad("multicast").size(), 1U) << Text("out");
  EXPECT_THAT(Bad("multicast")[0]["what"].get<std::string>(), HasSubstr("uses lo, which reaches none"));
}

TEST_F(DoctorProgram, WrongKeyAndForeignPrefix) {
  bus::BusOptions options;
  options.url = "udpm://239.255.76.67:" + std::to_string(20000 + getpid() % 12000) + "?ttl=0";
  if (Shell(Doctor("--listen 0 --json --url '" + options.url + "'")) != 0)
    GTEST_SKIP() << "no multicast here: " << Text("out");
  options.key_file = KeyFile("key", 'a');
  const FakeProcess vo("vo", options);
  options.prefix = "robot1/";
  const FakeProcess other("vo", options);

  const std::string listen = "--listen 1.2 --json --url '" + options.url + "' ";
  EXPECT_EQ(Shell(Doctor(listen)), 1);
  ASSERT_EQ(Bad("key").size(), 1U) << Text("out");
  EXPECT_THAT(Bad("key")[0]["what"].get<std::string>(), HasSubstr("no key is set here"));
  EXPECT_EQ(Json()["processes"].size(), 2U);

  EXPECT_EQ(Shell(Doctor(listen + "--set bus.key_file='" + KeyFile("wrong", 'b') + "'")), 1);
  EXPECT_THAT(Bad("key").at(0)["what"].get<std::string>(), HasSubstr("has a key that differs")) << Text("out");

  EXPECT_EQ(Shell(Doctor(listen + "--set bus.key_file='" + options.key_file + "'")), 0) << Text("out");
  EXPECT_TRUE(Bad("key").empty());
  EXPECT_EQ(Shell(Doctor(listen + "--prefix robot2/ --set bus.key_file='" + options.key_file + "'")), 1);
  EXPECT_EQ(Bad("prefix").size(), 2U) << Text("out");
}

TEST_F(DoctorProgram, BadArgumentsAreOneSentence) {
  EXPECT_EQ(Shell(Doctor("--url udpm://239.255.76.67:http")), 1);
  EXPECT_THAT(Text("error"), HasSubstr("'http' is not a number from 1 to 65535"));
  EXPECT_EQ(Shell(Doctor("--listen -1")), 1);
  EXPECT_EQ(Shell(Doctor("--listen 0 --quiet --url udpm://10.0.0.1:7667")), 1);
  EXPECT_THAT(Text("out"), HasSubstr("10.0.0.1' is not a multicast group"));
}

}  // namespace
}  // namespace plslam::doctor
