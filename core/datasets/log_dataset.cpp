// SPDX-License-Identifier: BSD-3-Clause
#include "core/datasets/log_dataset.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <tuple>
#include <utility>
#include <vector>

#include "core/bus/channels.h"
#include "core/bus/logs/log_index.h"
#include "core/bus/logs/log_reader.h"
#include "core/bus/messages/convert.h"
#include "core/bus/messages/frame_assembler.h"
#include "core/bus/messages/imu_channel.h"
#include "core/bus/transport/wire.h"
#include "core/errors/error_text.h"
#include "core/ids/ids.h"
#include "plslam/camera_t.hpp"
#include "plslam/ground_truth_t.hpp"
#include "plslam/image_strip_t.hpp"
#include "plslam/imu_t.hpp"

namespace plslam::bus {
namespace {

/// Size of the head of a strip: header, `frame_id`, `camera`, `strip` and `n_strips`.
constexpr size_t kStripHeadBytes = kWireHeaderBytes + 8 + 1 + 4 + 4;

struct LogStrip {
  LogPlace place;
  int8_t camera = 0;
  int32_t number = 0;
  int32_t n_strips = 0;  // of its image, as stated in the strip
};

struct LogFrame {
  SourceId source;
  int64_t id = 0;
  int64_t t_ns = 0;
  std::vector<LogStrip> strips;

  bool Whole() const { return Whole(0) && Whole(1); }
  bool Whole(int8_t camera) const;
};

/// Decided by the heads of its strips. A strip with a damaged count does not hide the others.
bool LogFrame::Whole(int8_t camera) const {
  std::set<int32_t> numbers;
  int32_t least = std::numeric_limits<int32_t>::max();
  for (const LogStrip& strip : strips) {
    if (strip.camera != camera) continue;
    numbers.insert(strip.number);
    least = std::min(least, strip.n_strips);
  }
  return !numbers.empty() && static_cast<int64_t>(numbers.size()) >= least;
}

/// Returns the indices of a longest increasing subsequence: a value that is far too large does not discard all later
/// ones.
std::vector<size_t> MostIncreasing(const std::vector<int64_t>& values) {
  std::vector<size_t> ends;  // ends[n]: index of the last of n + 1 increasing values, the smallest possible one
  std::vector<size_t> before(values.size());
  for (size_t i = 0; i < values.size(); ++i) {
    const auto end = std::lower_bound(ends.begin(), ends.end(), values[i],
                                      [&](size_t place, int64_t value) { return values[place] < value; });
    if (end != ends.begin()) before[i] = *(end - 1);
    if (end == ends.end()) {
      ends.push_back(i);
    } else {
      *end = i;
    }
  }
  std::vector<size_t> most(ends.size());
  size_t place = ends.empty() ? 0 : ends.back();
  for (size_t n = ends.size(); n-- > 0; place = before[place]) most[n] = place;
  return most;
}

/// One publisher's frames on one channel.
using StreamKey = std::tuple<std::string, std::string, SourceId>;  // prefix, channel, source
struct LogStream {
  std::map<int64_t, LogFrame> frames;
  int64_t n_strips = 0;
  int64_t begin = 0, end = 0;  ///< places of its first and last strip in the log

  bool Overlaps(const LogStream& other) const { return begin < other.end && other.begin < end; }
  int64_t CountWhole() const {
    return std::ranges::count_if(frames, [](const auto& frame) { return frame.second.Whole(); });
  }
};
using LogStreams = std::map<StreamKey, LogStream>;

/// The rig that a publisher sent first.
struct LogRig {
  RigCalibration rig;
  std::vector<uint8_t> bytes;  ///< `RigBytes`
  bool has_changed = false;    ///< a later one differs
};

class LogDataset : public Dataset {
 public:
  LogDataset(const std::string& path, const std::optional<std::string>& prefix) : path_(path), log_(path) {
    LogStreams streams;
    std::map<std::string, LoggedRobot> robots = Index(streams);
    if (prefix) std::erase_if(streams, [&](const auto& stream) { return std::get<0>(stream.first) != *prefix; });
    const auto longest = LongestStream(streams);
    const auto& [prefix_of_longest, channel, source] = longest->first;
    NoteOtherRobots(streams, prefix_of_longest);
    robot_ = std::move(robots[prefix_of_longest]);
    const std::map<SourceId, LogRig> rigs = ReadRigs();
    UseRig(rigs, source);
    JoinStreams(streams, longest, rigs);
    ReadImuSamples();
    ReadGroundTruth();
    DropFramesWithHoles();
    DropFramesOutOfTime();
    if (frames_.empty()) Fail("has no frame with all strips of both images");
  }

  std::string name() const override { return path_; }
  const RigCalibration& rig() const override { return rig_; }
  int size() const override { return static_cast<int>(frames_.size()); }
  int64_t t_ns(int index) const override { return frames_.at(static_cast<size_t>(index)).t_ns; }
  StereoImages Read(int index) const override;
  std::optional<SE3> GroundTruth(int index) const override {
    const LogFrame& frame = frames_.at(static_cast<size_t>(index));
    const auto found = truth_.find({frame.source, frame.id});
    return found == truth_.end() ? std::nullopt : std::optional(found->second);
  }
  const std::vector<ImuSample>& ImuSamples() const override { return imu_samples_; }
  plslam::Notes Notes() const override { return notes_; }

 private:
  [[noreturn]] void Fail(const std::string& why) const { throw DatasetError(path_ + ": " + why); }

  std::map<std::string, LoggedRobot> Index(LogStreams& streams);
  void IndexStrip(const LogReader::Event& event, LogStream& stream) const;
  std::string WhyNoFrames() const;
  LogStreams::iterator LongestStream(LogStreams& streams) const;
  void NoteOtherRobots(const LogStreams& streams, const std::string& prefix);
  std::map<SourceId, LogRig> ReadRigs() const;
  void UseRig(const std::map<SourceId, LogRig>& rigs, SourceId source);
  void JoinStreams(LogStreams& streams, LogStreams::iterator longest, const std::map<SourceId, LogRig>& rigs);
  void ReadImuSamples();
  void ReadGroundTruth();
  void DropFramesWithHoles();
  void DropFramesOutOfTime();
  void KeepFrames(const std::vector<size_t>& places, const std::string& why_others_go);

  std::string path_;
  LogReader log_;
  LoggedRobot robot_;
  std::vector<ImuSample> imu_samples_;
  std::set<SourceId> sources_;
  RigCalibration rig_;
  std::vector<LogFrame> frames_;
  std::map<std::pair<SourceId, int64_t>, SE3> truth_;  // by publisher and frame id
  plslam::Notes notes_;
};

void LogDataset::IndexStrip(const LogReader::Event& event, LogStream& stream) const {
  const int64_t id = ReadInt64(event.head.data() + kWireHeaderBytes);
  LogFrame& frame = stream.frames[id];
  frame.source = ReadHeader(event.head).source;
  frame.id = id;
  if (frame.strips.empty()) frame.t_ns = ReadHeader(event.head).t_ns;
  const uint8_t* rest = event.head.data() + kWireHeaderBytes + 8;
  frame.strips.push_back({{event.data_offset, event.data_bytes},
                          static_cast<int8_t>(rest[0]),
                          ReadInt32(rest + 1),
                          ReadInt32(rest + 5)});
  if (stream.n_strips++ == 0) stream.begin = event.data_offset;
  stream.end = event.data_offset;
}

std::map<std::string, LoggedRobot> LogDataset::Index(LogStreams& streams) {
  const std::vector<IndexedChannel> channels{{kCamera, camera_t::getHash()},
                                             {kGroundTruth, ground_truth_t::getHash()},
                                             {kImu, imu_t::getHash()},
                                             {kStereoFrame, image_strip_t::getHash(), false},
                                             {kStereoFrameLive, image_strip_t::getHash(), false}};
  return IndexLog(log_, channels, [&](const auto& prefix, const auto& strips, const auto& event, LoggedRobot&) {
    if (event.head.size() < kStripHeadBytes) return;
    IndexStrip(event, streams[{prefix, std::string(strips.channel.name), ReadHeader(event.head).source}]);
  });
}

std::string LogDataset::WhyNoFrames() const {
  if (LooksLikeLcmLog(path_))
    return "is an LCM log without stereo frames (channel STEREO_FRAME or STEREO_FRAME_LIVE)";
  std::string start(8, '\0');
  std::ifstream file = OpenInput(path_);
  file.read(start.data(), static_cast<std::streamsize>(start.size()));
  start.resize(static_cast<size_t>(file.gcount()));
  if (start.empty()) return "is empty (0 bytes), not an LCM log";
  constexpr std::string_view kVideos = ".mp4 .mkv .avi .mov .webm .m4v .ts .mjpeg .h264 ";
  const std::string extension = std::filesystem::path(path_).extension().string();
  if (!extension.empty() && kVideos.find(extension + " ") != std::string_view::npos) {
    return "is a video: the process camera plays two videos listed in a rig file (source: files: [left.mp4, "
           "right.mp4]; docs/datasets.md, 'A live camera'), with `plslam run rig.yaml --pace lockstep`";
  }
  if (extension == ".yaml" || extension == ".yml") {
    return "is a YAML file without `source:`, so no rig file of live cameras (docs/datasets.md, 'A live camera')";
  }
  const char* hint = start == "PLSLAMAP" ? ": it is a map; give it as --map to the run of a dataset" : "";
  return fmt::format("is not an LCM log: it begins with '{}'{}", Shown(start), hint);
}

LogStreams::iterator LogDataset::LongestStream(LogStreams& streams) const {
  const auto longest = std::max_element(streams.begin(), streams.end(), [](const auto& a, const auto& b) {
    return a.second.n_strips < b.second.n_strips;
  });
  if (longest == streams.end()) Fail(WhyNoFrames());
  return longest;
}

void LogDataset::NoteOtherRobots(const LogStreams& streams, const std::string& prefix) {
  std::map<std::string, int64_t> n_frames;
  for (const auto& [key, stream] : streams) n_frames[std::get<0>(key)] += stream.CountWhole();
  n_frames.erase(prefix);
  for (const auto& [other, n] : n_frames) {
    if (n == 0) continue;
    notes_.Remark(fmt::format(
        "{} frames of the prefix '{}' are not played: `lcm-logplayer` plays them to processes with that --prefix", n,
        Shown(other)));
  }
}

std::map<SourceId, LogRig> LogDataset::ReadRigs() const {
  std::map<SourceId, LogRig> rigs;
  robot_.On(kCamera).ForEach<camera_t>(log_, [&](const camera_t& message) {
    std::optional<RigCalibration> rig = FromMessage(message);
    if (!rig) return;
    std::vector<uint8_t> bytes = RigBytes(message);
    const auto [first, is_first] = rigs.try_emplace(SourceId(message.header.source));
    if (is_first) {
      first->second = {*std::move(rig), std::move(bytes)};
    } else {
      first->second.has_changed |= bytes != first->second.bytes;
    }
  });
  return rigs;
}

void LogDataset::UseRig(const std::map<SourceId, LogRig>& rigs, SourceId source) {
  const auto found = rigs.find(source);
  if (found != rigs.end()) {
    rig_ = found->second.rig;
  } else if (robot_.of_other_versions.contains(kCamera.name)) {
    Fail(
        "its rig (channel CAMERA) is from another version of plslam: play the log with the version that recorded it");
  } else {
    Fail("has stereo frames, but no valid rig of their publisher (channel CAMERA)");
  }
}

/// A publisher that was restarted continues the stream: its frames follow in the log, and have the same rig.
void LogDataset::JoinStreams(LogStreams& streams, LogStreams::iterator longest,
                             const std::map<SourceId, LogRig>& rigs) {
  const LogRig& rig = rigs.at(std::get<2>(longest->first));
  std::vector<LogStreams::iterator> robot;
  for (auto stream = streams.begin(); stream != streams.end(); ++stream) {
    if (std::get<0>(stream->first) == std::get<0>(longest->first)) robot.push_back(stream);
  }
  std::ranges::sort(robot, {}, [](const auto& stream) { return stream->second.begin; });
  bool has_changed = false;
  int64_t end = -1, n_at_once = 0, n_of_other_rigs = 0;
  for (const auto& stream : robot) {
    const SourceId publisher = std::get<2>(stream->first);
    const LogStream& content = stream->second;
    const auto own = rigs.find(publisher);
    if (own == rigs.end() || own->second.bytes != rig.bytes) {
      n_of_other_rigs += content.CountWhole();
    } else if (stream != longest && (content.begin < end || content.Overlaps(longest->second))) {
      n_at_once += content.CountWhole();
    } else {
      end = content.end;
      has_changed |= own->second.has_changed;
      sources_.insert(publisher);
      for (auto& [id, frame] : stream->second.frames) frames_.push_back(std::move(frame));
    }
  }
  if (sources_.size() > 1) {
    notes_.Remark(fmt::format("frames of {} publishers, which followed one another, are played as one stream",
                              sources_.size()));
  }
  const auto warn = [this](const std::string& what) {
    notes_.Warn(what + ": `lcm-logplayer` plays the whole log to running processes");
  };
  if (has_changed) warn("the rig changes in the log, and all frames are played with the first one");
  if (n_at_once > 0) warn(fmt::format("{} frames of another publisher at the same time are not played", n_at_once));
  if (n_of_other_rigs > 0) {
    warn(fmt::format("{} frames of another publisher with another rig are not played", n_of_other_rigs));
  }
}

/// The batches of successive frames overlap, and those of frames that were sent again are repeated.
void LogDataset::ReadImuSamples() {
  if (!rig_.imu) return;
  std::map<int64_t, ImuSample> samples;
  robot_.On(kImu).ForEach<imu_t>(log_, [&](const imu_t& message) {
    const bool is_played = sources_.contains(SourceId(message.header.source));
    const auto batch = is_played ? FromMessage(message) : std::nullopt;
    if (!batch) return;
    for (const ImuSample& sample : batch->samples) samples.emplace(sample.t_ns, sample);
  });
  for (const auto& [t_ns, sample] : samples) imu_samples_.push_back(sample);
}

void LogDataset::ReadGroundTruth() {
  robot_.On(kGroundTruth).ForEach<ground_truth_t>(log_, [&](const ground_truth_t& message) {
    const SourceId source(message.header.source);
    const auto T_w_l = sources_.contains(source) ? FromMessage(message.T_w_l) : std::nullopt;
    if (T_w_l) truth_.emplace(std::pair(source, message.frame_id), *T_w_l);
  });
}

void LogDataset::DropFramesWithHoles() {
  std::vector<size_t> whole;
  for (size_t i = 0; i < frames_.size(); ++i) {
    if (frames_[i].Whole()) whole.push_back(i);
  }
  KeepFrames(whole, "because strips are missing");
}

void LogDataset::DropFramesOutOfTime() {
  std::vector<int64_t> times_ns;
  for (const LogFrame& frame : frames_) times_ns.push_back(frame.t_ns);
  KeepFrames(MostIncreasing(times_ns), "because their times would not increase");
}

/// `places` in increasing order.
void LogDataset::KeepFrames(const std::vector<size_t>& places, const std::string& why_others_go) {
  if (places.size() == frames_.size()) return;
  size_t first_gone = 0;
  while (first_gone < places.size() && places[first_gone] == first_gone) ++first_gone;
  notes_.Warn("frames skipped, " + why_others_go + ": " + std::to_string(frames_.size() - places.size()) +
              " (the first is frame " + std::to_string(frames_[first_gone].id) + ")");
  std::vector<LogFrame> kept;
  kept.reserve(places.size());
  for (const size_t place : places) kept.push_back(std::move(frames_[place]));
  frames_ = std::move(kept);
}

StereoImages LogDataset::Read(int index) const {
  const LogFrame& frame = frames_.at(static_cast<size_t>(index));
  FrameAssembler assembler;
  for (const LogStrip& in_log : frame.strips) {
    const auto strip = DecodeAt<image_strip_t>(log_, in_log.place);
    if (!strip || assembler.Add(*strip) != FrameAssembler::Outcome::kComplete) continue;
    StereoImages images = assembler.TakeFrame().images;
    const auto size_of = [](const CameraCalibration& c) { return cv::Size(c.width_px, c.height_px); };
    if (images.left.size() != size_of(rig_.left) || images.right.size() != size_of(rig_.right)) {
      Fail("frame " + std::to_string(frame.id) + " does not have the size in the rig");
    }
    images.frame_id = index;
    return images;
  }
  Fail("frame " + std::to_string(frame.id) + " is incomplete: strips are malformed (" +
       std::to_string(frame.strips.size()) + " are there)");
}

}  // namespace

std::unique_ptr<Dataset> OpenLogDataset(const std::string& path, const std::optional<std::string>& prefix) {
  try {
    return std::make_unique<LogDataset>(path, prefix);
  } catch (const DatasetError&) {
    throw;
  } catch (const std::runtime_error& error) {
    throw DatasetError(error.what());
  }
}

}  // namespace plslam::bus
