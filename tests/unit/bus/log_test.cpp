// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <opencv2/core.hpp>

#include "core/bus/logs/log_index.h"
#include "core/bus/logs/log_reader.h"
#include "core/bus/logs/log_writer.h"
#include "core/bus/messages/convert.h"
#include "core/bus/messages/frame_channel.h"
#include "core/bus/transport/wire.h"
#include "core/datasets/log_dataset.h"
#include "plslam/camera_t.hpp"
#include "plslam/ground_truth_t.hpp"
#include "plslam/image_strip_t.hpp"
#include "plslam/pose_t.hpp"
#include "tests/unit/bus/bus_fixture.h"

namespace plslam::bus {
namespace {

using test::Eventually;
using test::PrivateUrl;
using test::RunningBus;
using test::TemporaryFolder;
using test::Waiter;

constexpr int kWidth = 320;
constexpr int kHeight = 240;
constexpr int kFrames = 8;

RigCalibration SmallRig() {
  RigCalibration rig;
  rig.name = "small";
  rig.rate_hz = 20.0;
  rig.left.width_px = kWidth;
  rig.left.height_px = kHeight;
  rig.left.fx_px = rig.left.fy_px = 200.0;
  rig.right = rig.left;
  rig.baseline_m = 0.1;
  return rig;
}

StereoImages FrameOf(int id) {
  StereoImages frame;
  frame.frame_id = id;
  frame.t_ns = 50'000'000LL * (id + 1);
  cv::RNG random(static_cast<uint64_t>(id + 1));
  frame.left.create(kHeight, kWidth, CV_8UC1);
  frame.right.create(kHeight, kWidth, CV_8UC1);
  random.fill(frame.left, cv::RNG::UNIFORM, 0, 256);
  random.fill(frame.right, cv::RNG::UNIFORM, 0, 256);
  return frame;
}

/// Messages that a player publishes for a short stream.
ground_truth_t TruthOf(int i) {
  ground_truth_t truth{};
  truth.frame_id = i;
  truth.T_w_l = ToMessage(SE3(Eigen::Quaterniond::Identity(), {0.1 * i, 0.0, 0.0}));
  return truth;
}

void PublishStream(Bus& bus, bool lockstep) {
  camera_t camera = ToMessage(SmallRig());
  bus.Publish(kCamera, camera);
  FramePublisher frames(bus, lockstep);
  for (int i = 0; i < kFrames; ++i) {
    bus.Publish(kGroundTruth, TruthOf(i));
    frames.Publish(FrameOf(i));
  }
}

bool Equal(const cv::Mat& a, const cv::Mat& b) {
  return a.size() == b.size() && a.type() == b.type() && cv::norm(a, b, cv::NORM_INF) == 0.0;
}

void ExpectTheStream(const Dataset& dataset) {
  ASSERT_EQ(dataset.size(), kFrames);
  EXPECT_EQ(dataset.rig().name, "small");
  for (int i = 0; i < kFrames; ++i) {
    const StereoImages read = dataset.Read(i);
    EXPECT_TRUE(Equal(read.left, FrameOf(i).left)) << i;
    EXPECT_TRUE(Equal(read.right, FrameOf(i).right)) << i;
    EXPECT_EQ(read.t_ns, FrameOf(i).t_ns);
    EXPECT_EQ(dataset.t_ns(i), read.t_ns);
    ASSERT_TRUE(dataset.GroundTruth(i));
    EXPECT_DOUBLE_EQ(dataset.GroundTruth(i)->translation().x(), 0.1 * i);
  }
}

/// Events of a log, to be written again changed.
struct RawEvent {
  std::string channel;
  std::vector<uint8_t> data;
};

std::vector<RawEvent> ReadAll(const std::string& path) {
  LogReader reader(path);
  std::vector<RawEvent> events;
  while (const auto event = reader.Next()) {
    events.push_back({event->channel, *reader.Data(event->data_offset, event->data_bytes)});
  }
  return events;
}

void WriteAll(const std::string& path, const std::vector<RawEvent>& events) {
  LogWriter writer(path);
  int64_t time = 0;
  for (const RawEvent& event : events) writer.Write(event.channel, event.data, time += 1000);
}

/// A log of the stream, recorded by ourselves over a network that loses 5 %.
class RecordedLog : public testing::Test {
 protected:
  std::string Record(const BusOptions& options) {
    const std::string path = folder_ / "recorded.lcm";
    BusOptions lossy = options;
    lossy.drop_fraction = 0.05;
    LogRecorder recorder(lossy, path);
    std::thread thread([&] { recorder.Run(); });
    {
      RunningBus player(options, "player");
      EXPECT_TRUE(test::WaitForReaders(*player, kStereoFrame, 1));
      for (int i = 0; i < 5; ++i) player->Publish(kCamera, ToMessage(SmallRig()));
      PublishStream(*player, true);
      EXPECT_TRUE(player->Flush(std::chrono::seconds(10)));
    }
    recorder.Stop();
    thread.join();
    return path;
  }
  static BusOptions Options() {
    BusOptions options;
    options.url = PrivateUrl();
    return options;
  }

  const TemporaryFolder folder_;
};

TEST_F(RecordedLog, IsAWholeDatasetDespiteLosses) { ExpectTheStream(*OpenLogDataset(Record(Options()))); }

TEST_F(RecordedLog, StoppedRecorderWritesAcknowledgedMessages) {
  const std::string path = folder_ / "slow disk";
  ASSERT_EQ(mkfifo(path.c_str(), 0600), 0);
  Waiter awake;
  int64_t written_bytes = 0;
  std::thread disk([&] {
    std::ifstream fifo(path, std::ios::binary);
    EXPECT_TRUE(awake.Reaches(1));
    std::vector<char> block(65'536);
    while (fifo.read(block.data(), static_cast<std::streamsize>(block.size())), fifo.gcount() > 0) {
      written_bytes += fifo.gcount();
    }
  });
  const BusOptions options = Options();
  auto recorder = std::make_unique<LogRecorder>(options, path);
  std::thread thread([&] { recorder->Run(); });
  Bus player(options, "player");
  EXPECT_TRUE(test::WaitForReaders(player, kStereoFrame, 1));
  constexpr int64_t kStrips = 40, kStripBytes = 50'000;  // more than a pipe holds
  image_strip_t strip{};
  strip.n_bytes = kStripBytes;
  strip.data.assign(kStripBytes, 1);
  for (int i = 0; i < kStrips; ++i) player.Publish(kStereoFrame, strip);
  EXPECT_TRUE(player.Flush(std::chrono::seconds(10)));
  recorder->Stop();
  awake.Add();
  thread.join();
  EXPECT_GE(recorder->events(), kStrips);
  recorder.reset();
  disk.join();
  EXPECT_GT(written_bytes, kStrips * kStripBytes);
}

TEST_F(RecordedLog, FullDiskEndsOnlyTheRecording) {
  const BusOptions options = Options();
  LogRecorder recorder(options, "/dev/full");
  Waiter failed;
  recorder.OnFailure([&](const std::string&) { failed.Add(); });
  std::thread thread([&] { recorder.Run(); });
  Bus player(options, "player");
  EXPECT_TRUE(test::WaitForReaders(player, kStereoFrame, 1));
  image_strip_t strip{};
  strip.n_bytes = 50'000;
  strip.data.assign(50'000, 1);
  for (int i = 0; i < 5; ++i) player.Publish(kStereoFrame, strip);
  EXPECT_TRUE(failed.Reaches(1));
  for (int i = 0; i < 5; ++i) player.Publish(kStereoFrame, strip);
  EXPECT_TRUE(player.Flush(std::chrono::seconds(10))) << "the recorder still takes messages";
  recorder.Stop();
  thread.join();
  EXPECT_EQ(failed.value(), 1);
  EXPECT_EQ(recorder.failure(), "/dev/full: cannot be written: No space left on device");
}

TEST(LogDataset, LiveChannelWithPrefixAndSmallMessages) {
  const TemporaryFolder folder;
  const std::string log = folder / "log";
  {
    BusOptions options;
    options.url = "file://" + log + "?mode=w";
    options.prefix = "r1/";
    options.max_message_bytes = 1200;
    Bus player(options, "player");
    PublishStream(player, false);
  }
  ExpectTheStream(*OpenLogDataset(log));
}

/// A log of publishers, one after the other; each has a part of the stream, numbered from 0.
class LogOfSeveral : public testing::Test {
 protected:
  struct Publisher {
    int first = 0, last = 0;
    std::string prefix{};
    double fx_px = 200.0;
  };
  std::unique_ptr<Dataset> Open(const std::vector<Publisher>& publishers) {
    std::vector<std::string> parts;
    for (const Publisher& publisher : publishers) {
      parts.push_back(folder_ / fmt::format("part{}", parts.size()));
      BusOptions options;
      options.url = "file://" + parts.back() + "?mode=w";
      options.prefix = publisher.prefix;
      Bus bus(options, "player");
      RigCalibration rig = SmallRig();
      rig.left.fx_px = publisher.fx_px;
      bus.Publish(kCamera, ToMessage(rig));
      FramePublisher frames(bus, false);
      for (int i = publisher.first; i <= publisher.last; ++i) {
        ground_truth_t truth = TruthOf(i);
        StereoImages images = FrameOf(i);
        images.frame_id = i - publisher.first;
        truth.frame_id = images.frame_id.value;
        bus.Publish(kGroundTruth, truth);
        frames.Publish(images);
      }
    }
    std::vector<RawEvent> events;
    for (const std::string& part : parts) std::ranges::copy(ReadAll(part), std::back_inserter(events));
    if (at_once_) std::ranges::stable_sort(events, {}, [](const RawEvent& e) { return ReadHeader(e.data).seq; });
    WriteAll(folder_ / "log", events);
    return OpenLogDataset(folder_ / "log");
  }

  TemporaryFolder folder_;
  bool at_once_ = false;
};

TEST_F(LogOfSeveral, RestartedPublisherContinuesTheStream) {
  const auto dataset = Open({{0, 2}, {3, 7}});
  ExpectTheStream(*dataset);
  EXPECT_TRUE(dataset->Notes().warnings.empty());
  EXPECT_THAT(dataset->Notes().remarks,
              testing::ElementsAre("frames of 2 publishers, which followed one another, are played as one stream"));
}

TEST_F(LogOfSeveral, FramesThatAreLeftOutAreNoted) {
  const auto other_rig = Open({{0, 2, "", 210.0}, {3, 7}, {1, 1, "b/"}});
  EXPECT_EQ(other_rig->size(), 5);
  EXPECT_EQ(other_rig->rig().left.fx_px, 200.0);
  EXPECT_THAT(other_rig->Notes().warnings,
              testing::ElementsAre("3 frames of another publisher with another rig are not played: `lcm-logplayer` "
                                   "plays the whole log to running processes"));
  EXPECT_THAT(other_rig->Notes().remarks,
              testing::ElementsAre("1 frames of the prefix 'b/' are not played: `lcm-logplayer` plays them to "
                                   "processes with that --prefix"));
  at_once_ = true;
  const auto at_once = Open({{0, 2}, {3, 7}});
  EXPECT_EQ(at_once->size(), 5);
  EXPECT_THAT(
      at_once->Notes().warnings,
      testing::ElementsAre(testing::HasSubstr("3 frames of another publisher at the same time are not played")));
}

TEST_F(RecordedLog, RigThatChangesIsReported) {
  std::vector<RawEvent> events = ReadAll(Record(Options()));
  RigCalibration other = SmallRig();
  other.left.fx_px = 210.0;
  for (size_t i = events.size(); i-- > 0;) {
    if (events[i].channel != kCamera.name) continue;
    camera_t changed = ToMessage(other);
    changed.header.source = Decoded<camera_t>(events[i].data)->header.source;
    changed.header.seq = 1000;
    events.push_back({std::string(kCamera.name), Encoded(changed)});
    break;
  }
  WriteAll(folder_ / "zoomed", events);
  const auto dataset = OpenLogDataset(folder_ / "zoomed");
  ExpectTheStream(*dataset);
  EXPECT_THAT(dataset->Notes().warnings,
              testing::ElementsAre(
                  testing::HasSubstr("the rig changes in the log, and all frames are played with the first")));
}

TEST_F(RecordedLog, ToleratesRepeatedAndReorderedStrips) {
  auto events = ReadAll(Record(Options()));
  const auto copy = events;
  events.insert(events.end(), copy.begin(), copy.end());
  std::mt19937_64 random(4);
  std::shuffle(events.begin(), events.end(), random);
  WriteAll(folder_ / "shuffled", events);
  ExpectTheStream(*OpenLogDataset(folder_ / "shuffled"));
}

/// Changes the strips of a log; `change` returns whether to keep one.
template <class Change>
void ChangeStrips(std::vector<RawEvent>& events, const Change& change) {
  std::erase_if(events, [&](RawEvent& event) {
    image_strip_t strip;
    if (event.channel != "STEREO_FRAME") return false;
    EXPECT_GE(strip.decode(event.data.data(), 0, static_cast<int>(event.data.size())), 0);
    const bool keep = change(strip);
    event.data = Encoded(strip);
    return !keep;
  });
}

TEST_F(RecordedLog, FramesWithMissingStripsAreSkipped) {
  auto events = ReadAll(Record(Options()));
  ChangeStrips(events, [](const image_strip_t& s) { return s.frame_id != 3 || s.camera != 1 || s.strip != 0; });
  // A flipped bit of a frame id makes a strip without a frame, and a frame that lacks a strip.
  ChangeStrips(events, [](image_strip_t& s) {
    if (s.frame_id == 5 && s.camera == 0 && s.strip == 0) s.frame_id ^= int64_t{1} << 40;
    return true;
  });
  WriteAll(folder_ / "holed", events);
  const auto dataset = OpenLogDataset(folder_ / "holed");
  ASSERT_EQ(dataset->size(), kFrames - 2);
  EXPECT_THAT(dataset->Notes().warnings,
              testing::ElementsAre("frames skipped, because strips are missing: 3 (the first is frame 3)"));
  for (int i = 0; i < dataset->size(); ++i) {
    const int id = i + (i >= 3 ? 1 : 0) + (i >= 4 ? 1 : 0);
    EXPECT_TRUE(Equal(dataset->Read(i).left, FrameOf(id).left)) << i;
    EXPECT_EQ(dataset->t_ns(i), FrameOf(id).t_ns);
    EXPECT_DOUBLE_EQ(dataset->GroundTruth(i)->translation().x(), 0.1 * id);
  }
}

TEST_F(RecordedLog, FramesWithNonIncreasingTimesAreSkipped) {
  const auto events = ReadAll(Record(Options()));
  const auto with_times = [&](const std::string& name, const auto& time) {
    auto changed = events;
    ChangeStrips(changed, [&](image_strip_t& s) {
      s.header.t_ns = time(s.frame_id, s.header.t_ns);
      return true;
    });
    WriteAll(folder_ / name, changed);
    return OpenLogDataset(folder_ / name);
  };
  constexpr int64_t kSecond = 1'000'000'000;
  // The clock of the camera was set back once, by more than a frame: the frames of before, or of after, are in the
  // way.
  const auto stepped = with_times("stepped", [](int64_t id, int64_t t) { return id >= 5 ? t - 60'000'000 : t; });
  EXPECT_EQ(stepped->size(), kFrames - 1);
  const auto far = with_times("far", [](int64_t id, int64_t t) { return id >= 2 ? t - kSecond : t; });
  ASSERT_EQ(far->size(), kFrames - 2);
  EXPECT_THAT(
      far->Notes().warnings,
      testing::ElementsAre("frames skipped, because their times would not increase: 2 (the first is frame 0)"));
  EXPECT_TRUE(Equal(far->Read(0).left, FrameOf(2).left));
  // One impossible time does not discard all later frames.
  const auto wild = with_times("wild", [](int64_t id, int64_t t) { return id == 1 ? t + (int64_t{1} << 60) : t; });
  EXPECT_EQ(wild->size(), kFrames - 1);
  for (const Dataset* dataset : {stepped.get(), far.get(), wild.get()}) {
    for (int i = 1; i < dataset->size(); ++i) EXPECT_GT(dataset->t_ns(i), dataset->t_ns(i - 1));
  }
}

TEST_F(RecordedLog, MalformedStripIsNamedWithItsFrame) {
  auto events = ReadAll(Record(Options()));
  ChangeStrips(events, [](image_strip_t& s) {
    if (s.frame_id == 3 && s.camera == 1 && s.strip == 0) ++s.width_px;
    return true;
  });
  WriteAll(folder_ / "torn", events);
  const auto dataset = OpenLogDataset(folder_ / "torn");
  ASSERT_EQ(dataset->size(), kFrames);
  EXPECT_NO_THROW(dataset->Read(2));
  try {
    dataset->Read(3);
    FAIL();
  } catch (const DatasetError& error) {
    EXPECT_NE(std::string(error.what()).find("torn: frame 3 is incomplete"), std::string::npos) << error.what();
  }
}

TEST_F(RecordedLog, DamagedBytesAreSkipped) {
  const std::string path = Record(Options());
  std::ifstream in(path, std::ios::binary);
  std::string bytes((std::istreambuf_iterator<char>(in)), {});
  std::mt19937_64 random(9);
  for (int round = 0; round < 100; ++round) {
    std::string damaged = bytes;
    for (uint64_t n = 1 + random() % 20; n > 0; --n) damaged[random() % damaged.size()] = static_cast<char>(random());
    damaged.resize(damaged.size() - random() % 1000);
    std::ofstream(folder_ / "damaged", std::ios::binary) << damaged;
    try {
      const auto dataset = OpenLogDataset(folder_ / "damaged");
      for (int i = 0; i < dataset->size(); ++i) {
        try {
          dataset->Read(i);
        } catch (const DatasetError&) {
        }
      }
    } catch (const DatasetError&) {
    }
  }
}

TEST_F(RecordedLog, RigOfAnotherVersionIsReported) {
  std::vector<RawEvent> events = ReadAll(Record(Options()));
  for (RawEvent& event : events) {
    if (event.channel == kCamera.name) event.data[7] ^= 1;  // of LCM's fingerprint
  }
  const std::string path = folder_ / "other.lcm";
  WriteAll(path, events);
  try {
    OpenLogDataset(path);
    FAIL() << "accepted";
  } catch (const DatasetError& error) {
    EXPECT_NE(std::string(error.what()).find("other.lcm: its rig (channel CAMERA) is from another version of plslam"),
              std::string::npos)
        << error.what();
  }
}

TEST(LogDataset, MissingContentIsReported) {
  const TemporaryFolder folder;
  const auto error_of = [](const std::string& path) -> std::string {
    try {
      OpenLogDataset(path);
    } catch (const DatasetError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_NE(error_of(folder / "none").find("cannot be read"), std::string::npos);
  EXPECT_NE(error_of(folder.path()).find("not a regular file"), std::string::npos);
  std::ofstream(folder / "empty");
  EXPECT_NE(error_of(folder / "empty").find("is empty (0 bytes), not an LCM log"), std::string::npos);
  std::ofstream(folder / "text") << std::string(100'000, 'x');
  EXPECT_NE(error_of(folder / "text").find("is not an LCM log: it begins with '"), std::string::npos);
  EXPECT_FALSE(LooksLikeLcmLog(folder / "text"));
}

TEST(StockTools, LoggerRecordsPublishedMessages) {
  if (!test::HasProgram("lcm-logger")) GTEST_SKIP() << "lcm-logger is not installed";
  const TemporaryFolder folder;
  const std::string url = PrivateUrl();
  const std::string log = folder / "log";
  test::Shell("lcm-logger -q -f --lcm-url='" + url + "' " + log + " > " + (folder / "out") + " 2>&1 & echo $! > " +
              (folder / "pid"));
  BusOptions options;
  options.url = url;
  Bus player(options, "player");
  ASSERT_TRUE(Eventually([&] {  // until it listens
    player.Publish(kCamera, ToMessage(SmallRig()));
    return std::filesystem::exists(log) && std::filesystem::file_size(log) > 0;
  }));
  // So few that the logger's buffer holds them, however long it does not get to run.
  options.prefix = "truth_";
  Bus truth(options, "truth");
  for (int i = 0; i < kFrames; ++i) truth.Publish(kGroundTruth, TruthOf(i));
  options.prefix = "again_";
  Bus publisher(options, "player");
  PublishStream(publisher, true);
  test::Shell("sleep 0.3; kill -INT $(cat " + (folder / "pid") + "); sleep 0.3");
  const auto events = ReadAll(log);
  const auto count = [&](const std::string& channel) {
    return std::count_if(events.begin(), events.end(), [&](const RawEvent& e) { return e.channel == channel; });
  };
  EXPECT_GE(count("CAMERA"), 1);
  EXPECT_EQ(count("truth_GROUND_TRUTH"), kFrames);
  // The publisher is not paced here, and the logger cannot request repairs: the received share of a stream is random.
  EXPECT_GT(count("again_STEREO_FRAME"), 0);
}

pose_t NumberedPose(int64_t source, int64_t seq) {
  pose_t pose{};
  pose.header.schema = kSchemaVersion;
  pose.header.source = source;
  pose.header.seq = seq;
  pose.frame_id = 100 * source + seq;
  return pose;
}

TEST(LogIndex, RepairedMessagesAreInOrderAndOnce) {
  const TemporaryFolder folder;
  {
    LogWriter writer(folder / "log");
    for (const auto& [source, seq] : std::vector<std::pair<int64_t, int64_t>>{{9, 0}, {9, 2}, {7, 0}, {9, 1}, {9, 2}})
      writer.Write("a/POSE", Encoded(NumberedPose(source, seq)), 1);
    writer.Write("b/POSE", Encoded(camera_t{}), 2);
    writer.Write("a/CAMERA", Encoded(camera_t{}), 3);
  }
  LogReader log(folder / "log");
  std::vector<std::string> visited;
  const auto robots =
      IndexLog(log, {{kPose, pose_t::getHash()}, {kCamera, camera_t::getHash(), false}},
               [&](const auto& prefix, const auto&, const auto&, auto&) { visited.push_back(prefix); });
  std::vector<int64_t> frames;
  robots.at("a/").On(kPose).ForEach<pose_t>(log, [&](const pose_t& pose) { frames.push_back(pose.frame_id); });
  EXPECT_THAT(frames, testing::ElementsAre(900, 901, 902, 700));
  EXPECT_THAT(visited, testing::ElementsAre("a/"));
  EXPECT_EQ(robots.at("b/").On(kPose).size(), 0U);
  EXPECT_THAT(robots.at("b/").of_other_versions, testing::ElementsAre("POSE"));
}

TEST(LogIndex, MessagesWithoutNumbersAreAllThere) {
  const TemporaryFolder folder;
  {
    LogWriter writer(folder / "log");
    for (const int64_t t_ns : {30, 10, 20}) {
      pose_t pose = NumberedPose(9, 0);
      pose.header.t_ns = pose.frame_id = t_ns;
      writer.Write("POSE", Encoded(pose), 1);
    }
  }
  LogReader log(folder / "log");
  const auto robots = IndexLog(log, {{kPose, pose_t::getHash()}}, [](auto&&...) {});
  std::vector<int64_t> frames;
  robots.at("").On(kPose).ForEach<pose_t>(log, [&](const pose_t& pose) { frames.push_back(pose.frame_id); });
  EXPECT_THAT(frames, testing::ElementsAre(10, 20, 30));
}

TEST(StockTools, LogplayerFeedsAReader) {
  if (!test::HasProgram("lcm-logplayer")) GTEST_SKIP() << "lcm-logplayer is not installed";
  const TemporaryFolder folder;
  const std::string log = folder / "log";
  {
    LogWriter writer(log);
    for (int i = 0; i < 100; ++i) {
      writer.Write("POSE", Encoded(NumberedPose(7, i)), 1'000'000 + 2000 * i);
    }
  }
  BusOptions options;
  options.url = PrivateUrl();
  Waiter received;
  int64_t next = 700;
  RunningBus reader(options, "reader");
  reader->Subscribe<pose_t>(kPose, [&](const pose_t& pose) {
    EXPECT_EQ(pose.frame_id, next++);
    received.Add();
  });
  reader.Start();
  ASSERT_EQ(test::Shell("lcm-logplayer -l '" + options.url + "' " + log + " > /dev/null 2>&1"), 0);
  EXPECT_TRUE(received.Reaches(100)) << received.value();
}

}  // namespace
}  // namespace plslam::bus
