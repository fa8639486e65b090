// SPDX-License-Identifier: BSD-3-Clause
// A robot of ROS 2 by Fast DDS, on a host that has loopback alone.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <random>
#include <regex>
#include <string>
#include <thread>
#include <vector>

#include "core/datasets/open_dataset.h"
#include "core/io/images/png_codec.h"
#include "core/io/trajectories/trajectory.h"
#include "core/ros/ros_topics.h"
#include "ros2/names.h"
#include "tests/integration/by_hand.h"
#include "tests/integration/rgbd_wall.h"
#include "tests/integration/ros2_robot.h"
#include "tests/integration/systemd_unit.h"
#include "tests/support/key_file.h"
#include "tests/support/sanitized.h"
#include "tests/support/shell.h"

namespace plslam::test {
namespace {

using nlohmann::json;
using testing::HasSubstr;
using testing::Not;

/// The frame of the world whose time a pose has.
int IndexOf(const json& odom) { return static_cast<int>((odom[0].get<int64_t>() - 1'000'000'000) / 50'000'000); }

/// Each row of the table is a topic with its type and its quality of service, and has messages. The robot has its own
/// images, and no surfaces are made here (Ros2Output has some).
void ExpectTheRowsOfTheTable(const json& topics) {
  int n_rows = 0;
  for (const RosTopic& row : RosTopics()) {
    const bool is_dense = row.name == ros_topic::kGrid.name || row.name == ros_topic::kSurfaces.name;
    if (!row.is_live || row.rate == RosRate::kImage || is_dense) continue;
    const bool is_tf = row.name == ros_topic::kTf.name || row.name == ros_topic::kTfStatic.name;
    const std::string topic = (is_tf ? "rt" : "rt/plslam") + std::string(row.name);
    ASSERT_TRUE(topics.contains(topic)) << topic << " in " << topics;
    EXPECT_EQ(topics[topic]["type"], ros2::DdsTypeName(row.type));
    EXPECT_EQ(topics[topic]["latched"], row.qos == RosQos::kLatched) << topic;
    EXPECT_EQ(topics[topic]["reliable"], true) << topic;
    EXPECT_TRUE(is_tf || topics[topic]["n"].get<int>() > 0) << topic << " in " << topics;
    ++n_rows;
  }
  // Others of the process are its node's and its services'.
  int n_topics = 0;
  for (const auto& [topic, found] : topics.items()) n_topics += topic.starts_with("rt/") ? 1 : 0;
  EXPECT_EQ(n_topics, n_rows) << topics;
}

TEST_F(Ros2, EveryFrameHasAPose) {
  const std::string out = folder_.Path("out");
  const auto run =
      Start(BinaryFolder() / "plslam", {"run", fmt::format("ros2:{}", kTopics), "--out", out}, "run.log");
  const auto robot = StartRobot({kWorld, "20", "80", "census"});
  Wait(*robot);
  const json heard = Heard();
  const auto late = StartRobot({kWorld, "20", "0"});
  Wait(*late);
  EXPECT_GT(Heard()["points"].get<int>(), 500) << "a late subscriber";
  run->Signal(SIGINT);
  Wait(*run);
  ASSERT_EQ(run->Poll()->code, 0) << Log("run.log");
  ASSERT_EQ(heard["sent"], 80) << heard;
  // A machine that is busy otherwise may skip frames.
  const size_t n = heard["odom"].size();
  ASSERT_GT(n, 60U) << heard;
  EXPECT_EQ(heard["odom_frames"], json({"odom", "base_link"}));
  EXPECT_GE(heard["tf"]["map odom"].get<size_t>(), n - 10);
  EXPECT_EQ(heard["tf"]["odom base_link"], n);
  EXPECT_GT(heard["points"].get<int>(), 500);
  EXPECT_GT(heard["path"].get<int>(), 40);
  ExpectTheRowsOfTheTable(heard["topics"]);

  const Trajectory poses = ReadTrajectory(out + "/trajectory.tum", TrajectoryFormat::kTum);
  ASSERT_EQ(poses.size(), n);
  const auto world = OpenDataset(kWorld, "");
  const SE3 T_first = world->GroundTruth(0)->Inverse();
  for (size_t i = 0; i < n; ++i) {
    const json& odom = heard["odom"][i];
    const SE3 T_true = T_first * *world->GroundTruth(IndexOf(odom));
    EXPECT_LT((poses[i].T_a_b.translation() - T_true.translation()).norm(), 0.05) << i;
    // The body looks along x, and its y is to the left: the camera's z, and -x.
    const Eigen::Vector3d p = T_true.translation(), p_body(p.z(), -p.x(), -p.y());
    EXPECT_LT((Eigen::Vector3d(odom[1], odom[2], odom[3]) - p_body).norm(), 0.05) << i;
  }
}

// The body moves to its right where the camera moves forward.
TEST_F(Ros2, CameraIsWhereTfStaticHasIt) {
  RunWithRobot({}, {"synthetic:room?size=376x240&frames=140", "20", "140", "tf_static", "listen_s=1"});
  if (HasFatalFailure()) return;
  EXPECT_THAT(Log("out/logs/ros2.log"), HasSubstr("a message on /tf_static has an invalid transform of tool"));
  const json heard = Heard();
  ASSERT_GT(heard["odom"].size(), 20U) << heard;
  const auto world = OpenDataset("synthetic:room?size=376x240&frames=140", "");
  const SE3 T_b_l(Eigen::Quaterniond(Eigen::AngleAxisd(0.5 * M_PI, Eigen::Vector3d::UnitZ())) *
                      Eigen::Quaterniond(0.5, -0.5, 0.5, -0.5),
                  {0.3, 0.0, 0.2});
  // The first frames may pass before /tf_static has arrived.
  const SE3 T_first = world->GroundTruth(IndexOf(heard["odom"][0]))->Inverse();
  for (const json& odom : heard["odom"]) {
    const SE3 T_true = T_b_l * T_first * *world->GroundTruth(IndexOf(odom)) * T_b_l.Inverse();
    EXPECT_LT((Eigen::Vector3d(odom[1], odom[2], odom[3]) - T_true.translation()).norm(), 0.05) << odom;
  }
}

TEST_F(Ros2, ColourAndDepthAreTracked) {
  const std::string wall = WallOfAnRgbdCamera(folder_, 60);
  const auto run = Start(BinaryFolder() / "plslam",
                         {"run", "ros2:/camera/color/image_raw,/camera/aligned_depth_to_color/image_raw", "--out",
                          folder_.Path("out"), "--no-loops"},
                         "run.log");
  const auto robot = StartRobot({wall, "20", "60", "listen_s=1"});
  Wait(*robot);
  run->Signal(SIGINT);
  Wait(*run);
  ASSERT_EQ(run->Poll()->code, 0) << Log("run.log");
  EXPECT_THAT(ReadText(folder_.Path("out/summary.json")), Not(HasSubstr("ros2_no_frames")))
      << "a robot that starts later is no fault";
  const json odom = Heard()["odom"];
  ASSERT_GT(odom.size(), 40U) << Heard();
  // The camera looks along x of the body, so that its right is -y.
  const int first = IndexOf(odom.front()), last = IndexOf(odom.back());
  const double moved_m = odom.front()[2].get<double>() - odom.back()[2].get<double>();
  EXPECT_NEAR(moved_m, 0.02 * (last - first), 0.02);
}

TEST_F(Ros2, MissingInputIsNamedInFiveSeconds) {
  const auto process = StartProcess();
  ASSERT_TRUE(LogHas("waiting for images")) << Log();
  const auto robot = StartRobot({kWorld, "20", "80", "no_info", "listen_s=4"});
  const auto begin = std::chrono::steady_clock::now();
  EXPECT_TRUE(LogHas("no frames: images arrive without CameraInfo: no topic /stereo/left/camera_info")) << Log();
  EXPECT_LT(std::chrono::steady_clock::now() - begin, Patience(std::chrono::seconds(5)));
  robot->Signal(SIGTERM);
  Wait(*robot);
  Stop(*process);
}

TEST_F(Ros2, WrongDataAreCountedAndTheRestIsUsed) {
  const auto process = StartProcess({"--set", "ros2.robot_odometry=/wheels"});
  const auto robot = StartRobot({kWorld, "20", "60", "lies", "reliable", "wheels", "listen_s=2"});
  Wait(*robot);
  Stop(*process);
  EXPECT_THAT(Log(), HasSubstr("a message on /wheels has an invalid pose"));
  EXPECT_THAT(Log(), HasSubstr("no message can be used of /wheels (ros2.robot_odometry)"));
  EXPECT_THAT(Log(), HasSubstr("a message on /stereo/right/image_raw has 376 x 4000000000 pixels"));
  EXPECT_THAT(Log(), HasSubstr("ended: 20 frames, 0 unpaired, 40 rejected"));
}

// By the right types' names, with other bytes: lengths of 4 GB, ends too soon, the other endianness. The wheels' topic,
// the inertial sensor, CameraInfo and /tf_static, too.
TEST_F(Ros2, DamagedMessagesLeaveTheRobotAlone) {
  const auto process = StartProcess({"--set", "ros2.robot_odometry=/wheels", "--set", "ros2.imu=/imu/data"});
  ASSERT_TRUE(LogHas("waiting for images")) << Log();
  const auto robot = StartRobot({kWorld, "20", "40", "hostile=1500", "wheels", "listen_s=1"});
  Wait(*robot);
  Stop(*process);
  std::smatch ended;
  const std::string log = Log();
  ASSERT_TRUE(std::regex_search(log, ended, std::regex(R"(ended: (\d+) frames, \d+ unpaired, (\d+) rejected)")))
      << log;
  EXPECT_GE(std::stoi(ended[1]), 35) << log;
  EXPECT_GT(std::stoi(ended[2]), 50) << log;
}

TEST_F(Ros2, EitherEndMayRestart) {
  auto process = StartProcess();
  auto robot = StartRobot({kWorld, "20", "40", "listen_s=0.5"});
  Wait(*robot);
  robot = StartRobot({kWorld, "20", "40", "begin_s=100", "listen_s=0.5"});
  Wait(*robot);
  Stop(*process);
  EXPECT_THAT(Log(), HasSubstr("ended: 80 frames, 0 unpaired, 0 rejected"));
  process = StartProcess();
  robot = StartRobot({kWorld, "20", "40", "begin_s=200", "jpeg", "listen_s=0.5"});
  EXPECT_TRUE(
      LogHas("no topic /stereo/left/image_raw in the domain 0; topics of its type are "
             "/stereo/left/image_raw/compressed"))
      << Log();
  robot->Signal(SIGTERM);
  Wait(*robot);
  Stop(*process);
}

// The tracker's session continues, and the robot hears its poses from the new process.
TEST_F(Ros2, PosesComeBackAfterAKill) {
  std::unique_ptr<StatusListener> listener;
  bus::BusOptions options;
  options.url = kBusUrl;
  host_->Do([&] { listener = std::make_unique<StatusListener>(*host_, options); });
  const auto tracker = Start(BinaryFolder() / "vo_process", {"--url", kBusUrl}, "vo.log");
  auto process = StartProcess();
  const auto robot = StartRobot({"synthetic:room?size=376x240&frames=400", "20", "400", "listen_s=1"});
  const auto has_tracked = [&](double n) {
    return WholeRun::WaitFor([&] { return listener->Counter("vo", "frames") >= n; });
  };
  ASSERT_TRUE(has_tracked(15)) << Log() << Log("vo.log");
  process->Signal(SIGKILL);
  ASSERT_TRUE(WholeRun::WaitFor([&] { return process->Poll().has_value(); }));
  const double before = listener->Counter("vo", "frames");
  process = StartProcess();
  ASSERT_TRUE(has_tracked(before + 40)) << Log();
  robot->Signal(SIGTERM);
  Wait(*robot);
  Stop(*process);
  Stop(*tracker);
  const json heard = Heard();
  int64_t last_ns = 0, gap_ns = 0;
  int n_after = 0;
  for (const json& odom : heard["odom"]) {
    const int64_t step_ns = last_ns > 0 ? odom[0].get<int64_t>() - last_ns : 0;
    n_after = step_ns > gap_ns ? 1 : n_after + 1;
    gap_ns = std::max(gap_ns, step_ns);
    last_ns = odom[0].get<int64_t>();
  }
  fmt::print("without poses for {:.1f} s\n", 1e-9 * static_cast<double>(gap_ns));
  EXPECT_GT(static_cast<int>(heard["odom"].size()) - n_after, 10) << heard;
  EXPECT_GT(n_after, 15) << heard;
}

TEST_F(Ros2, DomainsAreApart) {
  const auto in_domain = [&](const std::string& domain, const std::string& log) {
    return Start("/usr/bin/env",
                 {"ROS_DOMAIN_ID=" + domain, "ROS_LOCALHOST_ONLY=1", (BinaryFolder() / "plslam_ros2").string(),
                  "--left", "/stereo/left/image_raw", "--right", "/stereo/right/image_raw", "--url",
                  "udpm://239.255.76.67:77" + domain + "?ttl=0"},
                 log);
  };
  const auto process = in_domain("05", "ros2.log"), other = in_domain("06", "other.log");
  ASSERT_TRUE(LogHas("waiting for images")) << Log();
  const auto robot = Start("/usr/bin/env",
                           {"ROS_DOMAIN_ID=5", (BinaryFolder().parent_path() / "tests/fast_dds_robot").string(),
                            kWorld, "20", "60", "listen_s=1"},
                           "robot.json");
  Wait(*robot);
  Stop(*process);
  Stop(*other);
  EXPECT_THAT(Log(), HasSubstr("ended: 60 frames, 0 unpaired, 0 rejected"));
  EXPECT_THAT(Log("other.log"), HasSubstr("no publisher of ROS 2 was found in the domain 6"));
}

// Wheels carry the pose while the camera is covered for a second.
TEST_F(Ros2, WheelsPredictAndNothingElse) {
  RunWithRobot({"--set", "ros2.robot_odometry=/wheels", "--set", "vo.robot_motion.enabled=true"},
               {"synthetic:room?size=376x240&frames=100", "20", "100", "wheels", "covered"});
  if (HasFatalFailure()) return;
  const json heard = Heard();
  const auto world = OpenDataset("synthetic:room?size=376x240&frames=100", "");
  const SE3 T_first = world->GroundTruth(0)->Inverse();
  int n_covered = 0;
  for (const json& odom : heard["odom"]) {
    const int i = IndexOf(odom);
    n_covered += i >= 40 && i < 60;
    const SE3 T_true = T_first * *world->GroundTruth(i);
    const Eigen::Vector3d p = T_true.translation(), p_body(p.z(), -p.x(), -p.y());
    EXPECT_LT((Eigen::Vector3d(odom[1], odom[2], odom[3]) - p_body).norm(), 0.05) << i;
  }
  EXPECT_GT(n_covered, 10) << heard;
}

/// Runs with an inertial sensor, whose mounting is on /tf_static, through a second of darkness.
class Ros2Imu : public Ros2 {
 protected:
  void ExpectCarriedFrames(const std::string& topic, const std::string& robot_option) {
    constexpr const char* kRoom = "synthetic:room?size=376x240&frames=100&imu=200";
    RunWithRobot({"--set", "ros2.imu=" + topic}, {kRoom, "20", "100", robot_option, "tf_static", "covered"});
    if (HasFatalFailure()) return;
    EXPECT_THAT(Log("out/logs/ros2.log"), HasSubstr(topic + " has no noise densities"));
    const json summary = json::parse(ReadText(folder_.Path("out/summary.json")));
    EXPECT_GT(summary["carried_frames"].get<int>(), 10) << Log("run.log") << Log("out/logs/ros2.log");
    EXPECT_GT(summary["imu"]["used_frames"].get<int>(), 40) << summary["imu"];
    EXPECT_LT(summary["imu"]["innovation"].get<double>(), 4.0) << summary["imu"];
    const json heard = Heard();
    const auto world = OpenDataset(kRoom, "");
    const SE3 T_b_l(Eigen::Quaterniond(Eigen::AngleAxisd(0.5 * M_PI, Eigen::Vector3d::UnitZ())) *
                        Eigen::Quaterniond(0.5, -0.5, 0.5, -0.5),
                    {0.3, 0.0, 0.2});
    ASSERT_GT(heard["odom"].size(), 60U) << heard;
    const SE3 T_first = world->GroundTruth(IndexOf(heard["odom"][0]))->Inverse();
    int n_covered = 0;
    for (const json& odom : heard["odom"]) {
      n_covered += IndexOf(odom) >= 40 && IndexOf(odom) < 60;
      const SE3 T_true = T_b_l * T_first * *world->GroundTruth(IndexOf(odom)) * T_b_l.Inverse();
      EXPECT_LT((Eigen::Vector3d(odom[1], odom[2], odom[3]) - T_true.translation()).norm(), 0.05) << odom;
    }
    EXPECT_GT(n_covered, 10) << heard;
  }
};

TEST_F(Ros2Imu, CarriesThroughDarkness) { ExpectCarriedFrames("/imu/data", "imu"); }

TEST_F(Ros2Imu, PoseThatArrivesLaterIsUsed) {
  RunWithRobot({"--set", "ros2.imu=/imu/data"},
               {"synthetic:room?size=376x240&frames=100&imu=200", "20", "100", "imu", "late_tf_static"});
  if (HasFatalFailure()) return;
  const std::string log = Log("out/logs/ros2.log");
  EXPECT_THAT(log, HasSubstr("the camera (camera) looks along x of the body: /tf_static has no transform of it"));
  EXPECT_THAT(log, HasSubstr("the camera (camera) is on the body where /tf_static has it"));
  EXPECT_THAT(log, HasSubstr("/imu/data: the pose of the inertial sensor is known: it is used"));
}

TEST_F(Ros2Imu, RatesAndForcesApart) { ExpectCarriedFrames("/camera/gyro/sample", "imu_apart"); }

// By clients of both middlewares of ROS, which have no code in common with the process but DDS itself.
TEST_F(Ros2, ServicesAreOrders) {
  const std::string map = folder_.Path("house.plmap");
  const auto run = Start(BinaryFolder() / "plslam",
                         {"run", fmt::format("ros2:{}", kTopics), "--out", folder_.Path("out"), "--set",
                          "ros2.map_file=" + map, "--no-loops"},
                         "run.log");
  const auto robot = StartRobot({kWorld, "20", "60", "listen_s=0.5"});
  Wait(*robot);
  EXPECT_EQ(Call({"fast_dds_caller", "call", "/plslam/save"}),
            json({{"success", true}, {"message", fmt::format("the map is saved in {}", map)}}));
  EXPECT_TRUE(std::filesystem::exists(map));
  EXPECT_EQ(Call({"fast_dds_caller", "call", "/plslam/localise_only", "true"})["success"], true);
  const json extend = Call({"cyclone_caller", "/plslam/localise_only", "false"});
  EXPECT_EQ(extend["success"], true) << extend;
  EXPECT_EQ(Call({"fast_dds_caller", "call", "/plslam/reset"})["success"], true);
  const json load = Call({"fast_dds_caller", "call", "/plslam/load"});
  EXPECT_EQ(load["success"], true) << load;
  EXPECT_THAT(load["message"].get<std::string>(), HasSubstr(map)) << load;
  // Only a player can pause.
  const json pause = Call({"cyclone_caller", "/plslam/pause", "true"});
  EXPECT_EQ(pause["success"], false) << pause;
  EXPECT_THAT(pause["message"].get<std::string>(), HasSubstr("player")) << pause;
  run->Signal(SIGINT);
  Wait(*run);
  EXPECT_EQ(run->Poll()->code, 0) << Log("run.log");
}

/// Names of the topics, among them those of answers to services, to which a node says that it writes.
std::vector<std::string> WritersOf(const json& node) {
  std::vector<std::string> topics = node["writers"].get<std::vector<std::string>>();
  std::sort(topics.begin(), topics.end());
  return topics;
}

// The other node decides on the form. A key of the bus leaves no services: DDS cannot prove who calls.
TEST_F(Ros2, NodeIsListedInBothFormsOfRos) {
  const std::string key = KeyFile(folder_.Path(""), '7');
  const std::vector<std::string> all{"rr/robot/loadReply",  "rr/robot/localise_onlyReply", "rr/robot/pauseReply",
                                     "rr/robot/resetReply", "rr/robot/saveReply",          "rt/robot/diagnostics"};
  for (const bool has_key : {false, true}) {
    std::vector<std::string> options{"--namespace", "/robot"};
    if (has_key) options.insert(options.end(), {"--set", "bus.key_file=" + key});
    const auto process = StartProcess(options);
    ASSERT_TRUE(LogHas("waiting for images")) << Log();
    const json heard = Call({"fast_dds_caller", "nodes", has_key ? "0" : "1"});
    Stop(*process);
    ASSERT_EQ(heard["nodes"].size(), 1U) << heard;
    const json& node = heard["nodes"][0];
    EXPECT_EQ(node["name"], "plslam_ros2");
    EXPECT_EQ(node["namespace"], "/robot");
    // Images and CameraInfo of both sides, /tf_static, and five services.
    EXPECT_EQ(node["readers"].size(), has_key ? 5U : 10U) << heard;
    EXPECT_EQ(WritersOf(node), has_key ? std::vector<std::string>{"rt/robot/diagnostics"} : all);
    EXPECT_EQ(heard["gid"].get<std::string>().size(), has_key ? 32U : 48U);
  }
  EXPECT_THAT(Log(), HasSubstr("services are not offered: the bus has a key (bus.key_file)"));
}

// The robot sends for 12 s.
TEST_F(Ros2, FiveSecondsWithoutANetwork) {
  const auto process = StartProcess();
  const auto robot = StartRobot({"synthetic:room?size=376x240&frames=240", "20", "240", "listen_s=1"});
  ASSERT_TRUE(LogHas("plslam_ros2: running")) << Log();
  host_->Shell("ip link set lo down");
  std::this_thread::sleep_for(std::chrono::seconds(5));
  host_->Shell("ip link set lo up multicast on && ip route replace 224.0.0.0/4 dev lo");
  Wait(*robot);
  Stop(*process);
  std::smatch ended;
  const std::string log = Log();
  ASSERT_TRUE(std::regex_search(log, ended, std::regex(R"(ended: (\d+) frames, (\d+) unpaired, 0 rejected)"))) << log;
  // Without the outage there are 240.
  EXPECT_GE(std::stoi(ended[1]), 100) << log;
  EXPECT_LE(std::stoi(ended[1]), 160) << log;
}

TEST_F(Ros2, TopicsAreListedWithTheirCommand) {
  const auto robot = StartRobot({kWorld, "20", "80", "no_info"});
  const auto list = Start(BinaryFolder() / "plslam", {"topics", "ros2:"}, "topics.log");
  Wait(*list);
  EXPECT_EQ(list->Poll()->code, 0) << Log("topics.log");
  EXPECT_THAT(Log("topics.log"), HasSubstr("sensor_msgs/msg/Image  1 publisher, best effort, transient local, "));
  EXPECT_THAT(Log("topics.log"), HasSubstr("MB/s, 376 x 240 mono8"));
  EXPECT_THAT(Log("topics.log"), HasSubstr(fmt::format("plslam run ros2:{}\n", kTopics)));
  Wait(*robot);
}

// As systemd starts it, with the topics in the configuration of the robot.
TEST_F(Ros2, UnitOfTheExamplesStartsIt) {
  const std::filesystem::path file = SourceFolder() / "ros2/examples/plslam-ros2@.service";
  const SystemdFolders folders{folder_.Path("etc"), folder_.Path("state"), folder_.Path("run")};
  SystemdUnit unit = ReadSystemdUnit(file, "front", folders);
  std::filesystem::create_directories(folders.etc / "plslam");
  folder_.Write("etc/plslam/front.yaml",
                fmt::format("bus:\n  url: {}\nros2:\n  left: /left/image_raw\n  right: /right/image_raw\n", kBusUrl));
  std::filesystem::create_directories(folders.state / unit.state_directory);
  ASSERT_EQ(unit.start.words.front(), "/usr/bin/plslam_ros2");
  unit.start.words.erase(unit.start.words.begin());
  const auto process = Start(BinaryFolder() / "plslam_ros2", unit.start.words, "ros2.log");
  EXPECT_TRUE(LogHas("waiting for images")) << Log();
  Stop(*process);
  if (!HasProgram("systemd-analyze")) GTEST_SKIP() << "no systemd-analyze here: the unit is not verified";
  const ShellResult verified =
      Shell(folder_, fmt::format("cd '{}' && sed 's|/usr/bin/plslam_ros2|{}|' '{}' >plslam-ros2@front.service && "
                                 "cp '{}' plslam@front.target && SYSTEMD_UNIT_PATH=\"$PWD:\" systemd-analyze verify "
                                 "--man=no ./plslam-ros2@front.service",
                                 folder_.Path(""), (BinaryFolder() / "plslam_ros2").string(), file.string(),
                                 (SourceFolder() / "scripts/systemd/plslam@.target.in").string()));
  EXPECT_EQ(verified.exit_code, 0) << verified.error;
  EXPECT_EQ(verified.out + verified.error, "");
}

}  // namespace
}  // namespace plslam::test
