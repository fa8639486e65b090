#include "core/bus/log_dataset.h"

#include <algorithm>
#include <map>
#include <tuple>
#include <utility>
#include <vector>

#include "core/bus/channels.h"
#include "core/bus/convert.h"
#include "core/bus/frame_assembler.h"
#include "core/bus/log_reader.h"
#include "core/bus/wire.h"
#include "plslam/camera_t.hpp"
#include "plslam/ground_truth_t.hpp"
#include "plslam/image_strip_t.hpp"

namespace plslam::bus {
namespace {

struct Place {
  int64_t offset = 0;
  int64_t bytes = 0;
};

/// Prefix of `name` where it is `channel` behind a prefix.
std::optional<std::string> PrefixOf(const std::string& name, const Channel& channel) {
  if (!name.ends_with(channel.name)) return std::nullopt;
  return name.substr(0, name.size() - channel.name.size());
}

struct LogFrame {
  int64_t id = 0;
  int64_t t_ns = 0;
  std::vector<Place> strips;
};

/// One publisher's frames on one channel.
using StreamKey = std::tuple<std::string, std::string, int64_t>;  // prefix, channel, source
struct LogStream {
  std::map<int64_t, LogFrame> frames;
  int64_t n_strips = 0;
};

/// Decoded message at a place of the log; nullopt where it is malformed.
template <class T>
std::optional<T> Decode(const LogReader& log, const Place& place) {
  const auto data = log.Data(place.offset, std::min<int64_t>(place.bytes, kMaxMessageBytes));
  const MessageLayout* layout = FindMessageLayout(T::getTypeName());
  T message;
  if (!data || !MessageLength(*layout, *data)) return std::nullopt;
  if (message.decode(data->data(), 0, static_cast<int>(data->size())) < 0) return std::nullopt;
  return message;
}

class LogDataset : public Dataset {
 public:
  explicit LogDataset(const std::string& path) : path_(path), log_(path) {
    std::map<StreamKey, LogStream> streams;
    Index(streams);
    ChooseStream(streams);
    ReadRig();
    ReadGroundTruth();
    CheckTimes();
  }

  std::string name() const override { return path_; }
  const RigCalibration& rig() const override { return rig_; }
  int size() const override { return static_cast<int>(frames_.size()); }
  int64_t t_ns(int index) const override { return frames_.at(static_cast<size_t>(index)).t_ns; }
  StereoImages Read(int index) const override;
  std::optional<SE3> GroundTruth(int index) const override {
    const auto found = truth_.find(frames_.at(static_cast<size_t>(index)).id);
    return found == truth_.end() ? std::nullopt : std::optional(found->second);
  }

 private:
  [[noreturn]] void Fail(const std::string& why) const { throw DatasetError(path_ + ": " + why); }

  void Index(std::map<StreamKey, LogStream>& streams);
  void IndexStrip(const LogReader::Event& event, LogStream& stream) const;
  void ChooseStream(std::map<StreamKey, LogStream>& streams);
  void ReadRig();
  void ReadGroundTruth();
  void CheckTimes() const;

  std::string path_;
  LogReader log_;
  std::vector<std::pair<std::string, Place>> cameras_;  // with their prefixes
  std::vector<std::pair<std::string, Place>> truths_;
  std::string prefix_;
  int64_t source_ = 0;
  RigCalibration rig_;
  std::vector<LogFrame> frames_;
  std::map<int64_t, SE3> truth_;  // by frame id
};

void LogDataset::IndexStrip(const LogReader::Event& event, LogStream& stream) const {
  const int64_t id = ReadInt64(event.head.data() + kWireHeaderBytes);
  LogFrame& frame = stream.frames[id];
  frame.id = id;
  if (frame.strips.empty()) frame.t_ns = ReadHeader(event.head).t_ns;
  frame.strips.push_back({event.data_offset, event.data_bytes});
  ++stream.n_strips;
}

void LogDataset::Index(std::map<StreamKey, LogStream>& streams) {
  while (const auto event = log_.Next()) {
    const Place place{event->data_offset, event->data_bytes};
    if (const auto prefix = PrefixOf(event->channel, kCamera)) cameras_.emplace_back(*prefix, place);
    if (const auto prefix = PrefixOf(event->channel, kGroundTruth)) truths_.emplace_back(*prefix, place);
    for (const Channel& channel : {kStereoFrame, kStereoFrameLive}) {
      const auto prefix = PrefixOf(event->channel, channel);
      const bool is_strip = prefix && event->head.size() >= kWireHeaderBytes + 8 &&
                            ReadInt64(event->head.data()) == image_strip_t::getHash();
      if (!is_strip) continue;
      IndexStrip(*event, streams[{*prefix, std::string(channel.name), ReadHeader(event->head).source}]);
    }
  }
}

void LogDataset::ChooseStream(std::map<StreamKey, LogStream>& streams) {
  const auto most = std::max_element(streams.begin(), streams.end(), [](const auto& a, const auto& b) {
    return a.second.n_strips < b.second.n_strips;
  });
  if (most == streams.end()) Fail("is no LCM log with stereo frames (channel STEREO_FRAME or STEREO_FRAME_LIVE)");
  prefix_ = std::get<0>(most->first);
  source_ = std::get<2>(most->first);
  for (auto& [id, frame] : most->second.frames) frames_.push_back(std::move(frame));
}

void LogDataset::ReadRig() {
  for (const auto& [prefix, place] : cameras_) {
    if (prefix != prefix_) continue;
    const auto message = Decode<camera_t>(log_, place);
    if (!message || message->header.source != source_) continue;
    const auto rig = FromMessage(*message);
    if (!rig) continue;
    rig_ = *rig;
    return;
  }
  Fail("has stereo frames, but no valid rig of their publisher (channel CAMERA)");
}

void LogDataset::ReadGroundTruth() {
  for (const auto& [prefix, place] : truths_) {
    if (prefix != prefix_) continue;
    const auto message = Decode<ground_truth_t>(log_, place);
    if (!message || message->header.source != source_) continue;
    if (const auto T_w_l = FromMessage(message->T_w_l)) truth_.emplace(message->frame_id, *T_w_l);
  }
}

void LogDataset::CheckTimes() const {
  for (size_t i = 1; i < frames_.size(); ++i) {
    if (frames_[i].t_ns > frames_[i - 1].t_ns) continue;
    Fail("time " + std::to_string(frames_[i].t_ns) + " ns of frame " + std::to_string(frames_[i].id) +
         " is not after that of frame " + std::to_string(frames_[i - 1].id));
  }
}

StereoImages LogDataset::Read(int index) const {
  const LogFrame& frame = frames_.at(static_cast<size_t>(index));
  FrameAssembler assembler;
  for (const Place& place : frame.strips) {
    const auto strip = Decode<image_strip_t>(log_, place);
    if (!strip || assembler.Add(*strip) != FrameAssembler::Outcome::kComplete) continue;
    StereoImages images = assembler.TakeFrame().images;
    const auto size_of = [](const CameraCalibration& c) { return cv::Size(c.width_px, c.height_px); };
    if (images.left.size() != size_of(rig_.left) || images.right.size() != size_of(rig_.right)) {
      Fail("frame " + std::to_string(frame.id) + " does not have the size that the rig says");
    }
    images.frame_id = index;
    return images;
  }
  Fail("frame " + std::to_string(frame.id) + " is not whole: strips are missing or malformed (" +
       std::to_string(frame.strips.size()) + " are there)");
}

}  // namespace

std::unique_ptr<Dataset> OpenLogDataset(const std::string& path) {
  try {
    return std::make_unique<LogDataset>(path);
  } catch (const DatasetError&) {
    throw;
  } catch (const std::runtime_error& error) {
    throw DatasetError(error.what());
  }
}

}  // namespace plslam::bus
