// SPDX-License-Identifier: BSD-3-Clause
// The player against a stand-in for vo_process, both on real buses over loopback.
#include "player/node/player_node.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <atomic>
#include <condition_variable>
#include <filesystem>
#include <map>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

#include "core/bus/transport/transport.h"
#include "core/bus/transport/wire.h"
#include "core/datasets/open_dataset.h"
#include "core/io/images/png_codec.h"
#include "plslam/camera_t.hpp"
#include "plslam/command_t.hpp"
#include "plslam/ground_truth_t.hpp"
#include "plslam/pose_t.hpp"
#include "plslam/repair_request_t.hpp"
#include "plslam/status_t.hpp"
#include "plslam/stream_t.hpp"
#include "tests/unit/datasets/dataset_folders.h"

namespace plslam::player {
namespace {

using std::chrono::seconds;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

// A separate port for each test process.
bus::BusOptions Loopback() {
  bus::BusOptions options;
  options.url = fmt::format("udpm://239.255.76.67:{}?ttl=0", 20000 + getpid() % 12000);
  return options;
}

// Returns options of a publisher that waits at most a second for silent readers.
bus::BusOptions Impatient() {
  bus::BusOptions options = Loopback();
  options.give_up_s = 1.0;
  return options;
}

// Publishes a POSE for each frame, and stores the received messages.
class Reader {
 public:
  explicit Reader(bool answers) : bus_(Loopback(), "vo"), answers_(answers) {
    bus_.Subscribe<stream_t>(bus::kStream, [this](const stream_t& m) { Keep([&] { streams_.push_back(m); }); });
    bus_.Subscribe<ground_truth_t>(bus::kGroundTruth,
                                   [this](const ground_truth_t& m) { Keep([&] { truths_.push_back(m.frame_id); }); });
    bus_.Subscribe<camera_t>(bus::kCamera, [this](const camera_t& m) { Keep([&] { rigs_.push_back(m); }); });
    bus_.Subscribe<status_t>(bus::kStatus, [this](const status_t& m) {
      if (m.process == "player") Keep([&] { reasons_.push_back(m.state + ": " + m.reason); });
    });
    frames_ = std::make_unique<bus::FrameSubscriber>(bus_, bus::FrameSubscriber::Mode::kReliable,
                                                     [this](const auto& frame) { OnFrame(frame); });
    bus_.Every(std::chrono::milliseconds(100), [this] { SayAlive(); });
    thread_ = std::thread([this] { bus_.Run(); });
  }
  ~Reader() {
    bus_.Stop();
    thread_.join();
  }

  template <class Condition>
  bool WaitFor(Condition condition) {
    std::unique_lock lock(mutex_);
    return changed_.wait_for(lock, seconds(30), condition);
  }

  // Instead of answering frame `at`, requests once the frames after `to` again.
  void GoBack(int64_t at, int64_t to) { go_back_ = {at, to}; }

  // Requests the frames after `to` from this player.
  void AskForFrames(int64_t player, int64_t to) {
    command_t command{};
    command.target = "player";
    command.verb = "go_back";
    command.argument = std::to_string(player) + " " + stream::ToText({FrameId(to), t_ns_.at(to)});
    bus_.Publish(bus::kCommand, command);
  }
  int64_t player() const { return player_; }

  std::vector<int64_t> frame_ids_;
  std::vector<int> first_pixels_;
  std::vector<int64_t> truths_;
  std::vector<stream_t> streams_;
  std::vector<camera_t> rigs_;
  std::vector<std::string> reasons_;

 private:
  template <class F>
  void Keep(F f) {
    const std::scoped_lock lock(mutex_);
    f();
    changed_.notify_all();
  }
  void OnFrame(const bus::FrameSubscriber::Frame& frame) {
    Keep([&] {
      frame_ids_.push_back(frame.images.frame_id.value);
      first_pixels_.push_back(frame.images.left.at<uint8_t>(0, 0));
    });
    t_ns_[frame.images.frame_id.value] = frame.images.t_ns;
    player_ = frame.source.value;
    if (frame.images.frame_id.value == go_back_.first) {
      AskForFrames(player_, go_back_.second);
      go_back_ = {-1, -1};
      return;
    }
    if (!answers_) return;
    pose_t pose{};
    pose.header.t_ns = frame.images.t_ns;
    pose.frame_id = frame.images.frame_id.value;
    bus_.Publish(bus::kPose, pose);
  }
  void SayAlive() {
    status_t status{};
    status.process = "vo";
    status.state = "running";
    bus_.Publish(bus::kStatus, status);
  }

  bus::Bus bus_;
  const bool answers_;
  std::pair<int64_t, int64_t> go_back_{-1, -1};
  std::map<int64_t, int64_t> t_ns_;
  int64_t player_ = 0;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::unique_ptr<bus::FrameSubscriber> frames_;
  std::thread thread_;
};

// The player in this process, its run loop on a thread.
class Player {
 public:
  explicit Player(const PlayerOptions& options, const bus::BusOptions& bus_options = Loopback())
      : process_("player", bus_options), node_(std::make_unique<PlayerNode>(process_, options)) {
    thread_ = std::thread([this] { Run(); });
  }
  ~Player() {
    process_.bus().Stop();
    if (thread_.joinable()) thread_.join();
    node_.reset();
  }
  // Returns the exception of the run loop; empty if it ended by itself.
  std::string Join() {
    thread_.join();
    return error_;
  }

 private:
  void Run() {
    try {
      process_.bus().Run();
    } catch (const std::exception& error) {
      error_ = error.what();
    }
  }

  bus::Process process_;
  std::unique_ptr<PlayerNode> node_;
  std::string error_;
  std::thread thread_;
};

class PlayerNodeTest : public testing::Test {
 protected:
  PlayerNodeTest() {
    test::MakeKittiFolder(folder_.path());
    options_.dataset = folder_.path().string();
    options_.exit = true;
  }
  test::TemporaryFolder folder_;
  PlayerOptions options_;
};

TEST_F(PlayerNodeTest, LockstepSendsEveryFrameAndEnds) {
  Reader reader(true);
  options_.loop = 2;
  options_.bounce = true;
  Player player(options_);
  EXPECT_EQ(player.Join(), "");
  ASSERT_TRUE(reader.WaitFor([&] { return reader.streams_.size() == 2 && reader.truths_.size() == 9; }));
  EXPECT_THAT(reader.frame_ids_, ElementsAre(0, 1, 2, 3, 4, 5, 6, 7, 8));
  EXPECT_THAT(reader.first_pixels_, ElementsAre(0, 31, 62, 31, 0, 31, 62, 31, 0));
  EXPECT_EQ(reader.streams_[0].event, "begin");
  EXPECT_EQ(reader.streams_[0].n_frames, 9);
  EXPECT_EQ(reader.streams_[1].event, "end");
  EXPECT_EQ(reader.streams_[1].n_frames, 9);
  ASSERT_FALSE(reader.rigs_.empty());
  EXPECT_EQ(reader.rigs_[0].left.fx_px, 40.0);
  EXPECT_DOUBLE_EQ(reader.rigs_[0].baseline_m, 0.5);
}

TEST_F(PlayerNodeTest, RequestedFramesAreResent) {
  Reader reader(true);
  reader.GoBack(6, 2);
  options_.loop = 2;
  options_.bounce = true;
  Player player(options_);
  EXPECT_EQ(player.Join(), "");
  ASSERT_TRUE(reader.WaitFor([&] { return reader.streams_.size() == 2; }));
  EXPECT_THAT(reader.frame_ids_, ElementsAre(0, 1, 2, 3, 4, 5, 6, 3, 4, 5, 6, 7, 8));
  EXPECT_THAT(reader.first_pixels_, ElementsAre(0, 31, 62, 31, 0, 31, 62, 31, 0, 31, 62, 31, 0));
  EXPECT_EQ(reader.streams_[1].n_frames, 9);
}

TEST_F(PlayerNodeTest, FramesAreResentAfterTheEndOnRequest) {
  Reader reader(true);
  options_.exit = false;
  const Player player(options_);
  ASSERT_TRUE(reader.WaitFor([&] { return reader.streams_.size() == 2; }));
  reader.AskForFrames(reader.player() + 1, 1);
  reader.AskForFrames(reader.player(), 0);
  ASSERT_TRUE(reader.WaitFor([&] { return reader.streams_.size() == 3; }));
  EXPECT_THAT(reader.frame_ids_, ElementsAre(0, 1, 2, 1, 2));
}

TEST_F(PlayerNodeTest, RestartedReaderGetsThePendingFrameAgain) {
  Player player(options_, Impatient());
  {
    Reader crashes(false);
    ASSERT_TRUE(crashes.WaitFor([&] { return crashes.frame_ids_.size() == 1; }));
    ASSERT_TRUE(crashes.WaitFor([&] {
      return std::find(crashes.reasons_.begin(), crashes.reasons_.end(),
                       "running: waiting for the pose of frame 0") != crashes.reasons_.end();
    }));
  }
  Reader restarted(true);
  EXPECT_EQ(player.Join(), "");
  ASSERT_TRUE(restarted.WaitFor([&] { return restarted.frame_ids_.size() >= 3; }));
  EXPECT_EQ(restarted.frame_ids_.front(), 0);
  EXPECT_EQ(restarted.frame_ids_.back(), 2);
}

TEST_F(PlayerNodeTest, RestartResumesAfterTheAcknowledgedFrame) {
  Reader reader(true);
  options_.stop = 2;
  EXPECT_EQ(Player(options_).Join(), "");
  options_.stop = -1;
  options_.resume_after = "bus";
  Player resumed(options_);
  EXPECT_EQ(resumed.Join(), "");
  ASSERT_TRUE(reader.WaitFor([&] { return reader.streams_.size() == 4; }));
  EXPECT_THAT(reader.frame_ids_, ElementsAre(0, 1, 2));
  EXPECT_THAT(reader.first_pixels_, ElementsAre(0, 31, 62));
  EXPECT_EQ(reader.streams_[0].event, "begin");
  EXPECT_EQ(reader.streams_[2].event, "resume");
  EXPECT_EQ(reader.streams_[3].n_frames, 3);
}

TEST_F(PlayerNodeTest, FrameAnsweredMeanwhileIsNotAwaited) {
  Reader reader(true);
  EXPECT_EQ(Player(options_).Join(), "");
  const int64_t t_ns = OpenDataset(options_.dataset, "")->t_ns(0);
  // The launcher had received only the first pose.
  options_.resume_after = stream::ToText({0, t_ns});
  Player resumed(options_);
  EXPECT_EQ(resumed.Join(), "");
  ASSERT_TRUE(reader.WaitFor([&] { return reader.streams_.size() == 4; }));
  EXPECT_THAT(reader.frame_ids_, ElementsAre(0, 1, 2, 1, 2)) << "who reads frames leaves those it has";
}

TEST_F(PlayerNodeTest, InvalidResumePointIsRefused) {
  options_.resume_after = "seven";
  bus::Process process("player", Loopback());
  EXPECT_THROW(PlayerNode(process, options_), std::runtime_error);
}

TEST_F(PlayerNodeTest, MaskOptionsAreAddedToTheRig) {
  cv::Mat image(test::kTinyHeight_px, test::kTinyWidth_px, CV_8UC1, cv::Scalar(255));
  image.rowRange(20, 32).setTo(0);
  options_.mask_right = (folder_.path() / "mask.png").string();
  WritePng(options_.mask_right, image);
  Reader reader(true);
  {
    Player player(options_);
    ASSERT_TRUE(reader.WaitFor([&] { return !reader.rigs_.empty(); }));
    EXPECT_EQ(reader.rigs_.front().left.n_mask, 0);
    EXPECT_EQ(reader.rigs_.front().right.n_mask, 1);
  }
  WritePng(options_.mask_right, image.colRange(0, 20).clone());
  bus::Process process("player", Loopback());
  EXPECT_THAT([&] { PlayerNode(process, options_); },
              testing::ThrowsMessage<DatasetError>(
                  AllOf(HasSubstr("player.mask_right = " + options_.mask_right), HasSubstr("20 x 32"))));
}

TEST_F(PlayerNodeTest, MissingImageIsReportedBeforeTheFirstFrame) {
  std::filesystem::remove(folder_.path() / "image_1" / "000001.png");
  bus::Process process("player", Loopback());
  EXPECT_THAT([&] { PlayerNode(process, options_); },
              testing::ThrowsMessage<DatasetError>(AllOf(HasSubstr("image_1/000001.png: the image is missing"),
                                                         HasSubstr("1 of 3 frames"), HasSubstr("--skip-bad"))));
  // Only the frames that are played count.
  options_.stop = 1;
  EXPECT_NO_THROW(PlayerNode(process, options_));
}

TEST_F(PlayerNodeTest, BadFrameEndsTheStreamAndTheProcess) {
  std::filesystem::resize_file(folder_.path() / "image_1" / "000001.png", 50);
  Reader reader(true);
  Player player(options_);
  EXPECT_THAT(player.Join(), HasSubstr("image_1/000001.png: the image is truncated after 50 bytes"));
  ASSERT_TRUE(reader.WaitFor([&] { return reader.streams_.size() == 2; }));
  EXPECT_EQ(reader.streams_[1].n_frames, 1);
  EXPECT_EQ(reader.streams_[1].n_bad, 1);
}

TEST_F(PlayerNodeTest, SkipBadContinuesAndCounts) {
  std::filesystem::remove(folder_.path() / "image_1" / "000001.png");
  options_.skip_bad = true;
  Reader reader(true);
  Player player(options_);
  EXPECT_EQ(player.Join(), "");
  ASSERT_TRUE(reader.WaitFor([&] { return reader.streams_.size() == 2; }));
  EXPECT_THAT(reader.frame_ids_, ElementsAre(0, 1));
  EXPECT_THAT(reader.first_pixels_, ElementsAre(0, 62));
  EXPECT_EQ(reader.streams_[1].n_frames, 2);
  EXPECT_EQ(reader.streams_[1].n_bad, 1);
}

// Announces that it reads the stream, and never acknowledges anything.
class ReaderThatNeverAcknowledges {
 public:
  ReaderThatNeverAcknowledges() : wire_(Loopback().url), thread_([this] { SayHellos(); }) {}
  ~ReaderThatNeverAcknowledges() {
    stopping_ = true;
    thread_.join();
  }

 private:
  void SayHellos() {
    repair_request_t hello{};
    hello.header.schema = bus::kSchemaVersion;
    hello.header.source = 77;
    hello.channel = bus::kStream.name;
    hello.delivered = -1;
    for (; !stopping_; ++hello.header.seq) {
      wire_.Send(std::string(bus::kRepairRequest.name), bus::Encoded(hello));
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
    }
  }

  bus::Transport wire_;
  std::atomic<bool> stopping_ = false;
  std::thread thread_;
};

TEST_F(PlayerNodeTest, StalledReaderIsNotAwaitedAtTheEnd) {
  const ReaderThatNeverAcknowledges silent;
  Reader reader(true);
  options_.exit = false;
  const Player player(options_, Impatient());
  EXPECT_TRUE(reader.WaitFor([&] {
    return std::find(reader.reasons_.begin(), reader.reasons_.end(), "finished: 3 frames sent, 0 bad, 0 late") !=
           reader.reasons_.end();
  }));
}

TEST_F(PlayerNodeTest, RealtimeNeedsNoReader) {
  options_.pace = "realtimex4";
  Player player(options_);
  EXPECT_EQ(player.Join(), "");
}

TEST_F(PlayerNodeTest, StopsWhileWaitingForAReader) {
  Player player(options_);  // no reader answers; the destructor must end it
}

}  // namespace
}  // namespace plslam::player
