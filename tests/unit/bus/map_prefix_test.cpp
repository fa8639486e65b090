// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <fstream>
#include <set>

#include "core/bus/transport/transport.h"
#include "core/bus/transport/wire.h"
#include "plslam/announce_t.hpp"
#include "plslam/camera_t.hpp"
#include "plslam/command_t.hpp"
#include "plslam/loop_closure_t.hpp"
#include "plslam/repair_request_t.hpp"
#include "plslam/status_t.hpp"
#include "tests/unit/bus/bus_fixture.h"

namespace plslam::bus {
namespace {

using test::Waiter;

/// Two robots, Ann and Bob, and the owner of their shared map. Each member stores the ids that it receives.
class MapPrefix : public testing::TestWithParam<bool> {
 protected:
  struct Member {
    explicit Member(const BusOptions& options) : bus(options) {
      bus->Subscribe<loop_closure_t>(kLoopClosure, [this](const loop_closure_t& m) {
        closures += m.session_keyframe_id;
        n_closures.Add();
      });
      bus->Subscribe<camera_t>(kCamera, [this](const camera_t& m) { Hear(cameras, m.rig_name, n_cameras); });
      bus->Subscribe<status_t>(kStatus, [this](const status_t& m) { Hear(statuses, m.process, n_statuses); });
      bus->Subscribe<command_t>(kCommand, [this](const command_t& m) { Hear(commands, m.verb, n_commands); });
      bus.Start();
    }
    void Hear(std::string& heard, const std::string& word, Waiter& count) {
      heard += word;
      count.Add();
    }
    int64_t closures = 0;
    std::string cameras, statuses, commands;
    Waiter n_closures, n_cameras, n_statuses, n_commands;
    test::RunningBus bus;  // last, so that it is the first to go: its thread uses the others
  };

  BusOptions Options(const std::string& prefix, const std::string& map_prefix) const {
    BusOptions options;
    options.url = url_;
    options.prefix = prefix;
    options.map_prefix = map_prefix;
    if (GetParam()) {
      options.key_file = folder_ / "key";
      std::ofstream(options.key_file) << std::string(64, 'a');
    }
    return options;
  }

  const std::string url_ = test::PrivateUrl();
  test::TemporaryFolder folder_;
  Member ann_{Options("ann/", "team/")};
  Member bob_{Options("bob/", "team/")};
  Member owner_{Options("team/", "")};
};

TEST_P(MapPrefix, OnlyMapChannelsAreSharedInOrder) {
  ASSERT_TRUE(test::WaitForReaders(*owner_.bus, kLoopClosure, 3));
  loop_closure_t closure{};
  for (closure.session_keyframe_id = 1; closure.session_keyframe_id <= 10; ++closure.session_keyframe_id) {
    owner_.bus->Publish(kLoopClosure, closure);
  }
  for (Member* member : {&ann_, &bob_, &owner_}) {
    ASSERT_TRUE(member->n_closures.Reaches(10));
    EXPECT_EQ(member->closures, 55);
  }
  command_t command{};
  command.verb = "for ann";
  ann_.bus->Publish(kCommand, command);
  command.verb = "for the owner";
  owner_.bus->Publish(kCommand, command);
  ASSERT_TRUE(ann_.n_commands.Reaches(1));
  ASSERT_TRUE(owner_.n_commands.Reaches(1));
  EXPECT_EQ(ann_.commands, "for ann");
  EXPECT_EQ(owner_.commands, "for the owner");
  EXPECT_EQ(bob_.commands, "");
}

TEST_P(MapPrefix, OwnerGetsCamerasAndRobotsGetItsStatus) {
  ASSERT_TRUE(test::WaitForReaders(*owner_.bus, kLoopClosure, 3));
  camera_t camera{};
  camera.rig_name = "ann's";
  ann_.bus->Publish(kCamera, camera);
  status_t status{};
  status.process = "mapping";
  owner_.bus->Publish(kStatus, status);
  status.process = "vo";
  ann_.bus->Publish(kStatus, status);
  for (Member* member : {&ann_, &owner_}) {
    ASSERT_TRUE(member->n_cameras.Reaches(1));
    EXPECT_EQ(member->cameras, "ann's");
  }
  ASSERT_TRUE(ann_.n_statuses.Reaches(2));
  ASSERT_TRUE(bob_.n_statuses.Reaches(1));
  ASSERT_TRUE(owner_.n_statuses.Reaches(1));
  EXPECT_EQ(bob_.statuses, "mapping");
  EXPECT_EQ(bob_.cameras, "");
  EXPECT_EQ(owner_.statuses, "mapping");
}

TEST_P(MapPrefix, OwnChannelsHaveNoReadersOfTheMapPrefix) {
  // A reader is announced in the order of the names of its channels, COMMAND before LOOP_CLOSURE.
  for (Member* member : {&ann_, &owner_}) ASSERT_TRUE(test::WaitForReaders(*member->bus, kLoopClosure, 3));
  EXPECT_EQ(ann_.bus->ReaderCount(kCommand), 1) << "itself";
  EXPECT_EQ(owner_.bus->ReaderCount(kCommand), 1) << "itself";
  ann_.bus->Publish(kCommand, command_t{});
  EXPECT_TRUE(ann_.bus->Flush(std::chrono::seconds(10)));
}

INSTANTIATE_TEST_SUITE_P(KeyedOrNot, MapPrefix, testing::Bool(),
                         [](const auto& test) { return test.param ? "WithKey" : "WithoutKey"; });

TEST(MapPrefixAnnouncement, CountsUnderThePrefixOfItsChannelOnly) {
  BusOptions options;
  options.url = test::PrivateUrl();
  options.prefix = "ann/";
  options.map_prefix = "team/";
  test::RunningBus ann(options);
  ann->Subscribe<command_t>(kCommand, [](const command_t&) {});
  ann.Start();
  Transport wire(options.url);
  std::set<int64_t> asked;  // publishers
  wire.SetReceiver([&](std::string_view, ByteView bytes) {
    repair_request_t request;
    if (request.decode(bytes.data(), 0, static_cast<int>(bytes.size())) > 0) asked.insert(request.publisher);
  });
  wire.Listen("ann/REPAIR_REQUEST");
  announce_t announce{};
  announce.header.schema = kSchemaVersion;
  announce.channel = kCommand.name;
  announce.next_seq = 3;
  constexpr int64_t kOfTheMap = 77, kAnns = 78;
  EXPECT_TRUE(test::Eventually([&] {
    announce.header.source = kOfTheMap;
    wire.Send("team/ANNOUNCE", Encoded(announce));
    announce.header.source = kAnns;
    wire.Send("ann/ANNOUNCE", Encoded(announce));
    ++announce.header.seq;
    wire.Receive(10);
    return asked.contains(kAnns);
  }));
  EXPECT_FALSE(asked.contains(kOfTheMap)) << "commands under another prefix are not missed";
}

TEST(MapPrefixOption, OnlyPlainNames) {
  BusOptions options;
  options.url = test::PrivateUrl();
  options.map_prefix = "team 7";
  EXPECT_THROW(Bus(options, "test"), std::runtime_error);
}

}  // namespace
}  // namespace plslam::bus
