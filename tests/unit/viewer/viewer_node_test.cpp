// SPDX-License-Identifier: BSD-3-Clause
#include "viewer_headless/node/viewer_node.h"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <thread>

#include "core/bus/messages/convert.h"
#include "core/io/images/image_file.h"
#include "core/io/trajectories/trajectory.h"
#include "core/run/run_writer.h"
#include "plslam/ground_truth_t.hpp"
#include "plslam/tracks_t.hpp"
#include "plslam/warning_t.hpp"
#include "tests/support/text_file.h"
#include "tests/unit/viewer/some_rig.h"
#include "tests/unit/viewer/viewer_fixture.h"
#include "viewer_headless/live/http_server.h"
#include "viewer_headless/report/report_page.h"

namespace plslam::viewer {
namespace {

int FreePort() {
  const HttpServer server(0, [](const HttpRequest&) { return HttpResponse(); });
  return server.port();
}

/// Everything that is answered to a GET, head and all.
std::string Get(int port, const std::string& target) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<uint16_t>(port));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  const int fd = socket(AF_INET, SOCK_STREAM, 0);
  std::string answer;
  if (connect(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0) {
    const std::string request = "GET " + target + " HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n";
    send(fd, request.data(), request.size(), MSG_NOSIGNAL);
    char buffer[4096];
    for (ssize_t n = 0; (n = recv(fd, buffer, sizeof buffer, 0)) > 0;) answer.append(buffer, static_cast<size_t>(n));
  }
  close(fd);
  return answer;
}

using ViewerNodeTest = ViewerFixture;

TEST_F(ViewerNodeTest, WritesEverythingWhenTheStreamHasEnded) {
  const ViewerNode node(*process_, Options());
  PublishCamera();
  PublishStream("begin", kFrames);
  for (int64_t frame = 0; frame < kFrames; ++frame) {
    PublishTruth(frame);
    PublishPose(frame, frame == 5 ? 3 : 1);
  }
  PublishStream("end", kFrames);
  bus().Run();
  const Trajectory trajectory = ReadTrajectory(Out("trajectory.tum"));
  ASSERT_EQ(trajectory.size(), 11u) << "one frame was lost";
  EXPECT_EQ(trajectory[5].t_ns, Time(6));
  EXPECT_LT((trajectory[5].T_a_b.translation() - TruePose(6).translation()).norm(), 1e-9);
  EXPECT_EQ(ReadTrajectory(Out("keyframes.tum")).size(), 3u);
  EXPECT_EQ(ReadTrajectory(Out("groundtruth.tum")).size(), 12u);
  EXPECT_THAT(states_, testing::Contains("running"));
  EXPECT_EQ(states_.back(), "finished");
}

TEST_F(ViewerNodeTest, WaitsUntilTheMapHasTheLastKeyframe) {
  const ViewerNode node(*process_, Options());
  PublishCamera();
  bus::MapUpdatePublisher mapping(bus(), [] {});
  PublishMappingStatus();
  for (int64_t frame = 0; frame < kFrames; ++frame) PublishPose(frame);
  PublishStream("end", kFrames);
  mapping.Publish(MapOf(1, 1.0));
  // The map is late: all poses have arrived for several ticks before it has the last keyframe.
  int ticks = 0;
  bus().Every(std::chrono::milliseconds(200), [&] {
    if (++ticks == 6) mapping.Publish(MapOf(2, 3.0));
  });
  bus().Run();
  EXPECT_GE(ticks, 6);
  const Trajectory trajectory = ReadTrajectory(Out("trajectory.tum"));
  ASSERT_EQ(trajectory.size(), 12u);
  EXPECT_NEAR(trajectory[7].T_a_b.translation().x(), 3.0, 1e-9);
  EXPECT_NEAR(ReadTrajectory(Out("trajectory_live.tum")).at(7).T_a_b.translation().x(), 0.0, 1e-9);
  EXPECT_EQ(ReadTrajectory(Out("keyframes.tum")).size(), 3u);
  EXPECT_TRUE(std::filesystem::exists(Out("map.ply")));
}

TEST_F(ViewerNodeTest, NewRunClearsAllOfTheOldOne) {
  PrepareOutputFolder(Out("overlays"));
  for (const char* name : {"summary.json", "map.ply", "overlays/000099.png"})
    folder_.Write(std::string("out/") + name, "");
  EXPECT_THROW(ViewerNode(*process_, Options(), ViewerNode::Earlier::kRefuse), std::runtime_error);
  const ViewerNode node(*process_, Options(), ViewerNode::Earlier::kReplace);
  EXPECT_TRUE(std::filesystem::exists(Out("summary.json"))) << "no frame has arrived";
  PublishCamera();
  PublishStream("begin", 1);
  PublishPose(0);
  PublishStream("end", 1);
  bus().Run();
  EXPECT_TRUE(std::filesystem::exists(Out("trajectory.tum")));
  for (const char* name : {"summary.json", "map.ply", "overlays/000099.png"}) {
    EXPECT_FALSE(std::filesystem::exists(Out(name))) << name;
  }
}

TEST_F(ViewerNodeTest, WithoutMappingThereIsNoMapFile) {
  const ViewerNode node(*process_, Options());
  PublishCamera();
  for (int64_t frame = 0; frame < kFrames; ++frame) PublishPose(frame);
  PublishStream("end", kFrames);
  bus().Run();
  EXPECT_FALSE(std::filesystem::exists(Out("map.ply")));
  EXPECT_EQ(ReadTrajectory(Out("keyframes.tum")).size(), 3u);
}

TEST_F(ViewerNodeTest, WritesPartialOutputsWhenStoppedEarly) {
  stop_at_ = "running";
  {
    const ViewerNode node(*process_, Options());
    PublishCamera();
    PublishPose(0);
    bus().Run();
  }
  EXPECT_EQ(ReadTrajectory(Out("trajectory.tum")).size(), 1u);
}

TEST_F(ViewerNodeTest, FinishCommandWritesAndEnds) {
  const ViewerNode node(*process_, Options());
  PublishCamera();
  PublishPose(0);
  command_t other{};
  other.target = "vo";
  other.verb = "finish";
  bus().Publish(bus::kCommand, other);
  PublishPose(1);
  // Commands and poses are different channels: the order between them is not kept.
  bool sent = false;
  bus().Every(std::chrono::milliseconds(5), [&] {
    if (sent || std::find(states_.begin(), states_.end(), "running") == states_.end()) return;
    sent = true;
    command_t command{};
    command.target = "viewer";
    command.verb = "finish";
    bus().Publish(bus::kCommand, command);
  });
  bus().Run();
  EXPECT_TRUE(sent);
  EXPECT_GE(ReadTrajectory(Out("trajectory.tum")).size(), 1u);
}

TEST_F(ViewerNodeTest, DrawsEveryNthFrame) {
  const ViewerNode node(*process_, Options(4));
  PublishCamera();
  PublishStream("begin", 2);
  bool sent = false;
  // The rig must be known before the first image arrives.
  bus().Every(std::chrono::milliseconds(50), [&] {
    if (sent) return;
    sent = true;
    for (const int64_t frame : {4, 5}) PublishPose(frame);
    PublishImages(4);
    PublishImages(5);
    PublishTracks(4);
    PublishStream("end", 2);
  });
  bus().Run();
  const cv::Mat picture = ReadGreyImage(Out("overlays/000004.png"));
  EXPECT_EQ(picture.cols, 320);
  EXPECT_GT(picture.rows, 240);
  EXPECT_FALSE(std::filesystem::exists(Out("overlays/000005.png")));
}

TEST_F(ViewerNodeTest, WritesAReportAndServesIt) {
  if (!ReadReportTemplate()) GTEST_SKIP() << "built without node and npm: there are no reports";
  ViewerOptions options = Options();
  options.serve = FreePort();
  const ViewerNode node(*process_, options);
  PublishCamera();
  bus::MapUpdatePublisher mapping(bus(), [] {});
  PublishMappingStatus();
  PublishStream("begin", kFrames);
  for (int64_t frame = 0; frame < kFrames; ++frame) PublishPose(frame);
  mapping.Publish(MapOf(2, 1.0));
  PublishStream("end", kFrames);
  std::string answer;
  // The answer is given by handlers of this bus, which must run meanwhile.
  std::thread client([&] { answer = Get(static_cast<int>(options.serve), "/data.json"); });
  bus().Run();
  client.join();
  EXPECT_THAT(answer, testing::StartsWith("HTTP/1.1 200"));
  EXPECT_THAT(answer, testing::HasSubstr("\"whole\":true"));
  const std::string report = ReadText(Out("report.html"));
  EXPECT_THAT(report, testing::HasSubstr("\"facts\":{"));
  EXPECT_THAT(report, testing::HasSubstr("\"frames\":12"));
  EXPECT_THAT(report, testing::HasSubstr("\"keyframes\":3"));
  EXPECT_THAT(report, testing::HasSubstr("\"finished\":true"));
}

TEST_F(ViewerNodeTest, ResumedPlayerKeepsOutputsUntilTheNewEnd) {
  if (!ReadReportTemplate()) GTEST_SKIP() << "built without node and npm: there are no reports";
  const ViewerNode node(*process_, Options());
  stop_at_ = "";
  std::string first, then;
  bus().Subscribe<stream_t>(bus::kStream, [&](const stream_t& m) {
    if (m.event != "resume") return;
    then = ReadText(Out("report.html"));
    // The messages of the first player are republished.
    PublishStream("begin", kFrames, "realtime", 1);
    PublishPose(kFrames);
    PublishStream("end", kFrames + 1, "realtime", 2);
  });
  bus().Every(std::chrono::milliseconds(20), [&] {
    const std::string report = ReadText(Out("report.html"));
    if (first.empty() && !report.empty()) {
      first = report;
      PublishStream("resume", kFrames, "realtime", 2);
    } else if (!then.empty() && report != first) {
      bus().Stop();
    }
  });
  PublishCamera();
  PublishStream("begin", kFrames, "realtime", 1);
  for (int64_t frame = 0; frame < kFrames; ++frame) PublishPose(frame);
  PublishStream("end", kFrames, "realtime", 1);
  bus().Run();
  EXPECT_TRUE(!first.empty() && then == first);
  EXPECT_EQ(ReadTrajectory(Out("trajectory.tum")).size(), static_cast<size_t>(kFrames + 1));
}

TEST_F(ViewerNodeTest, WithoutReportThereIsNone) {
  ViewerOptions options = Options();
  options.report = false;
  const ViewerNode node(*process_, options);
  PublishCamera();
  PublishPose(0);
  PublishStream("end", 1);
  bus().Run();
  EXPECT_FALSE(std::filesystem::exists(Out("report.html")));
}

/// The film program is not beside the program of this test.
TEST_F(ViewerNodeTest, FilmWithoutEncoderIsAFolder) {
  std::vector<std::string> warnings;
  bus().Subscribe<warning_t>(bus::kWarning, [&](const warning_t& m) {
    warnings.push_back(m.code + ": " + m.sentence);
    bus().Stop();
  });
  ViewerOptions options = Options();
  options.video = folder_.Path("film.mp4");
  const ViewerNode node(*process_, options);
  PublishCamera();
  PublishStream("begin", 2);
  int64_t frame = -1;
  bus().Every(std::chrono::milliseconds(30), [&] {
    if (++frame == 2) PublishStream("end", 2);
    if (frame > 1) return;
    PublishPose(frame);
    PublishImages(frame);
    PublishTracks(frame);
  });
  bus().Run();
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_THAT(warnings[0], testing::StartsWith("film_as_pictures: "));
  EXPECT_THAT(warnings[0], testing::HasSubstr("numbered pictures are written to " + folder_.Path("film")));
  EXPECT_TRUE(std::filesystem::exists(folder_.Path("film/000001.png")));
}

TEST_F(ViewerNodeTest, FilmsTheRun) {
  ViewerOptions options = Options();
  options.video = folder_.Path("film");
  const ViewerNode node(*process_, options);
  PublishCamera();
  PublishStream("begin", 5);
  int64_t frame = -1;
  // One at a time: newer features replace older ones. Frame 3 is missing, and the next one replaces it.
  bus().Every(std::chrono::milliseconds(30), [&] {
    if (++frame == 3) return;
    if (frame == 5) PublishStream("end", 4);
    if (frame > 4) return;
    PublishPose(frame);
    PublishImages(frame);
    PublishTracks(frame);
  });
  bus().Run();
  int n = 0;
  while (std::filesystem::exists(folder_.Path(fmt::format("film/{:06}.png", n)))) ++n;
  EXPECT_EQ(n, 5);
  const cv::Mat picture = ReadGreyImage(folder_.Path("film/000000.png"));
  EXPECT_EQ(picture.cols, 320 + 284) << "image with its bar, and the map beside it";
}

TEST_F(ViewerNodeTest, InvalidMessagesAreCountedAndHarmless) {
  const ViewerNode node(*process_, Options());
  pose_t nan{};
  nan.T_odom_c = nan.T_w_odom = bus::ToMessage(SE3());
  nan.T_odom_c.position_m[1] = NAN;
  bus().Publish(bus::kPose, nan);
  pose_t zero_quaternion{};
  bus().Publish(bus::kPose, zero_quaternion);
  bus().Publish(bus::kGroundTruth, ground_truth_t{});
  camera_t camera{};
  bus().Publish(bus::kCamera, camera);
  PublishStream("sideways", 1);
  PublishCamera();
  PublishPose(0);
  PublishStream("end", 1);
  bus().Run();
  EXPECT_EQ(ReadTrajectory(Out("trajectory.tum")).size(), 1u);
  EXPECT_FALSE(std::filesystem::exists(Out("groundtruth.tum")));
}

TEST_F(ViewerNodeTest, UnwritableFolderIsReportedAtTheStart) {
  ViewerOptions options = Options();
  options.out = folder_.Write("file", "") + "/out";
  EXPECT_THAT(
      [&] { ViewerNode(*process_, options); },
      testing::ThrowsMessage<std::runtime_error>(testing::HasSubstr("file/out: the folder cannot be created")));
}

}  // namespace
}  // namespace plslam::viewer
