// SPDX-License-Identifier: BSD-3-Clause
#include "core/datasets/recordings/recording_dataset.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "core/datasets/camera_file.h"
#include "core/datasets/check_rig.h"
#include "core/datasets/imu_files.h"
#include "core/datasets/imu_topics.h"
#include "core/datasets/recordings/bag_reader.h"
#include "core/datasets/recordings/depth_images.h"
#include "core/datasets/recordings/image_pairs.h"
#include "core/datasets/recordings/mcap_reader.h"
#include "core/datasets/recordings/message_times.h"
#include "core/datasets/recordings/pixel_encodings.h"
#include "core/datasets/recordings/recorded_imu.h"
#include "core/datasets/recordings/ros2_bag.h"
#include "core/datasets/recordings/ros_messages.h"
#include "core/datasets/recordings/topic_names.h"
#include "core/datasets/white_level.h"
#include "core/errors/error_text.h"
#include "core/io/trajectories/trajectory.h"

namespace plslam {
namespace {

/// Name of no sensor: "FILE?imu=none".
constexpr std::string_view kNoImu = "none";
constexpr auto kTruthNames = std::to_array<std::string_view>({"truth", "/gt", "mocap", "vicon"});

/// A location taken apart: "FILE?key=value&...".
struct Location {
  std::string file;
  std::map<std::string, std::string> options;
};

Location TakeApart(const std::string& location) {
  Location parts{FileOfLocation(location), {}};
  if (parts.file == location) return parts;
  for (std::string_view rest = std::string_view(location).substr(parts.file.size() + 1); !rest.empty();) {
    const std::string_view option = rest.substr(0, rest.find('&'));
    rest.remove_prefix(std::min(rest.size(), option.size() + 1));
    const std::string key(option.substr(0, option.find('=')));
    static const std::set<std::string> kKnown{"left", "right", "truth", "camera", "part", "imu"};
    if (!kKnown.contains(key) || key.size() == option.size()) {
      throw DatasetError(
          fmt::format("{}: '{}' is not one of left=TOPIC, right=TOPIC, truth=TOPIC, imu=TOPIC, camera=FILE, "
                      "part=NUMBER",
                      parts.file, Shown(option)));
    }
    parts.options[key] = option.substr(key.size() + 1);
  }
  return parts;
}

bool IsImage(const RecordedChannel& channel) {
  return RosEncodingOf(channel.encoding) && (channel.type == kRosImage || channel.type == kRosCompressedImage);
}

/// Returns the encoding of a channel that has one.
RosEncoding EncodingOf(const RecordedChannel& channel) { return RosEncodingOf(channel.encoding).value(); }

bool IsPose(const RecordedChannel& channel) {
  return RosEncodingOf(channel.encoding) && (channel.type == kRosOdometry || channel.type == kRosPose);
}

std::string ListOf(const std::set<std::string>& names) {
  constexpr size_t kMostShown = 12;
  std::vector<std::string> shown;
  for (const std::string& name : names) {
    if (shown.size() < kMostShown) shown.push_back(Shown(name));
  }
  if (names.size() > shown.size()) shown.push_back(fmt::format("and {} more", names.size() - shown.size()));
  return fmt::format("{}", fmt::join(shown, ", "));
}

class RecordingDataset : public Dataset {
 public:
  RecordingDataset(const std::string& location, const Location& parts, std::string_view kind,
                   std::unique_ptr<Recording> reader)
      : name_(location),
        file_(parts.file),
        options_(parts.options),
        reader_(std::move(reader)),
        notes_(reader_->Notes()) {
    ChooseTopics();
    images_ = PairImages(*reader_, left_.topic, right_.topic, Part(), &notes_);
    CheckEncodings();
    ReadRig(kind);
    ReadImu();
    ChooseTruth();
    white_ = WhiteLevelOf(
        size(), [this](int index) { return BrightValuesOf(index); }, &notes_);
    clipped_.emplace(white_);
  }

  std::string name() const override { return name_; }
  const RigCalibration& rig() const override { return rig_; }
  int size() const override { return static_cast<int>(images_.pairs.size()); }
  int64_t t_ns(int index) const override { return TimeOf(*reader_, images_, static_cast<size_t>(index)); }
  plslam::Notes Notes() const override { return notes_; }
  plslam::Notes NotesOfReading() const override { return clipped_->Report(); }
  double scan_s() const override { return reader_->scan_s(); }
  bool HasRecordedTruth() const override { return !truth_.empty(); }
  const std::vector<ImuSample>& ImuSamples() const override { return imu_samples_; }

  StereoImages Read(int index) const override {
    try {
      const auto& [left, right] = Pair(index);
      double clipped_left = 0.0, clipped_right = 0.0;
      StereoImages images{index, t_ns(index), ReadImage(left_, left, rig_.left, &clipped_left),
                          is_rgbd() ? ReadDepths(right) : ReadImage(right_, right, rig_.right, &clipped_right)};
      clipped_->Add(index, clipped_left, clipped_right);
      return images;
    } catch (const std::runtime_error& error) {
      throw DatasetError(fmt::format("{}: frame {}: {}", name_, index, error.what()));
    }
  }

  std::optional<SE3> GroundTruth(int index) const override;

 private:
  const std::pair<RecordedMessage, RecordedMessage>& Pair(int index) const {
    return images_.pairs.at(static_cast<size_t>(index));
  }

  cv::Mat ReadImage(const RecordedChannel& channel, const RecordedMessage& message, const CameraCalibration& camera,
                    double* clipped) const {
    try {
      return ParseImage(channel.type, reader_->Read(message), EncodingOf(channel),
                        {camera.width_px, camera.height_px}, white_, clipped);
    } catch (const std::runtime_error& error) {
      throw DatasetError(fmt::format("{}: {}", channel.topic, error.what()));
    }
  }

  /// Whether the right images are depth maps.
  bool is_rgbd() const { return NamesDepth(left_.topic, right_.topic); }

  cv::Mat ReadDepths(const RecordedMessage& message) const {
    try {
      return ParseDepths(right_.type, reader_->Read(message), EncodingOf(right_),
                         {rig_.left.width_px, rig_.left.height_px}, rig_.depth_units_per_m);
    } catch (const std::runtime_error& error) {
      throw DatasetError(fmt::format("{}: {}", right_.topic, error.what()));
    }
  }

  BrightValues BrightValuesOf(int index) const {
    const auto bright = [&](const RecordedChannel& channel, const RecordedMessage& message) {
      return BrightWideValue(channel.type, reader_->Read(message), EncodingOf(channel),
                             {rig_.left.width_px, rig_.left.height_px});
    };
    const auto left = bright(left_, Pair(index).first);
    return {left, is_rgbd() ? left : bright(right_, Pair(index).second)};
  }

  const RecordedChannel* Find(const std::string& topic, bool (*fits)(const RecordedChannel&)) const {
    for (const RecordedChannel& channel : reader_->channels()) {
      if (channel.topic == topic && fits(channel)) return &channel;
    }
    return nullptr;
  }

  /// Returns a list of the topics in the recording, for the error about missing image topics.
  std::string TopicsThatAreThere() const {
    std::set<std::string> images, other_images, others;
    for (const RecordedChannel& channel : reader_->channels()) {
      if (IsImage(channel)) {
        images.insert(channel.topic);
        continue;
      }
      const bool is_image = channel.type.find("Image") != std::string::npos;
      (is_image ? other_images : others)
          .insert(fmt::format("{} ({} in {})", channel.topic, channel.type, channel.encoding));
    }
    if (!images.empty()) return "its image topics are " + ListOf(images);
    const std::string none = "it has no ROS images (sensor_msgs/Image or CompressedImage)";
    if (!other_images.empty()) return none + ", but " + ListOf(other_images);
    if (others.empty() && reader_->Notes().empty()) return "it has no messages";
    return others.empty() ? "it has no topics at all" : none + "; its topics are " + ListOf(others);
  }

  RecordedChannel Given(const std::string& key, bool (*fits)(const RecordedChannel&), const char* what) const {
    const RecordedChannel* const found = Find(options_.at(key), fits);
    if (found != nullptr) return *found;
    throw DatasetError(
        fmt::format("has no {} on the topic {}={}; {}", what, key, Shown(options_.at(key)), TopicsThatAreThere()));
  }

  void ChooseTopics() {
    if (options_.contains("left") != options_.contains("right")) {
      throw DatasetError("left=TOPIC and right=TOPIC must be given together");
    }
    if (options_.contains("left")) {
      left_ = Given("left", IsImage, "images");
      right_ = Given("right", IsImage, "images");
      return;
    }
    std::set<std::string> images;
    for (const RecordedChannel& channel : reader_->channels()) {
      if (IsImage(channel)) images.insert(channel.topic);
    }
    if (images.empty()) throw DatasetError("has nothing to play: " + TopicsThatAreThere());
    auto pairs = StereoTopics(images);
    if (pairs.empty()) pairs = RgbdTopics(images);
    if (pairs.empty()) {
      throw DatasetError(fmt::format(
          "no two image topics are named left and right, cam0 and cam1, infra1 and infra2, or image_0 and image_1, "
          "and "
          "none color or rgb beside depth; {}: give two of them, --topics LEFT RIGHT (or FILE?left=LEFT&right=RIGHT)",
          TopicsThatAreThere()));
    }
    std::vector<std::pair<RecordedChannel, RecordedChannel>> found;
    found.reserve(pairs.size());
    for (const auto& [left, right] : pairs) found.emplace_back(*Find(left, IsImage), *Find(right, IsImage));
    // Prefer images without lossy compression.
    std::stable_sort(found.begin(), found.end(), [](const auto& a, const auto& b) {
      return std::pair(a.first.type != kRosImage, a.first.topic) <
             std::pair(b.first.type != kRosImage, b.first.topic);
    });
    std::tie(left_, right_) = found.front();
    if (found.back().first.topic != left_.topic) {
      notes_.Remark(fmt::format("of several pairs of image topics {} and {} are played", left_.topic, right_.topic));
    }
  }

  /// The part of the file that is played, from 1; 0: all.
  size_t Part() const {
    const auto given = options_.find("part");
    if (given == options_.end()) return 0;
    const std::string& text = given->second;
    constexpr size_t kMostDigits = 6;
    if (text.empty() || text.size() > kMostDigits || text.find_first_not_of("0123456789") != text.npos ||
        std::stoul(text) == 0) {
      throw DatasetError(fmt::format("part={}: is no number from 1", Shown(text)));
    }
    return std::stoul(text);
  }

  /// Rejects unknown encodings of raw images before a run begins.
  void CheckEncodings() const {
    for (const auto& [channel, message] :
         {std::pair(&left_, images_.pairs.front().first), std::pair(&right_, images_.pairs.front().second)}) {
      if (channel->type != kRosImage) continue;  // JPEG and PNG contain their encoding
      std::string encoding;
      try {
        encoding = ImageEncoding(channel->type, reader_->Read(message), EncodingOf(*channel));
      } catch (const DatasetError&) {
        continue;  // a damaged message is an error when it is played
      }
      const bool is_depth = channel == &right_ && is_rgbd();
      const std::string complaint = is_depth ? DepthEncodingComplaint(encoding) : PixelEncodingComplaint(encoding);
      if (!complaint.empty()) throw DatasetError(fmt::format("{}: {}", channel->topic, complaint));
    }
  }

  /// Returns the first calibrated one of these messages: a driver may send zeros before it has read its calibration.
  RosCameraInfo FirstInfo(const RecordedChannel& channel, const std::vector<RecordedMessage>& messages) {
    const auto read = [&](const RecordedMessage& m) {
      return ParseCameraInfo(reader_->Read(m), EncodingOf(channel));
    };
    const auto is_calibrated = [](const RosCameraInfo& info) { return !info.K.isZero(0.0) || !info.P.isZero(0.0); };
    RosCameraInfo info = read(messages.front());
    std::optional<RosCameraInfo> last;
    try {
      last = read(messages.back());
    } catch (const std::runtime_error&) {  // the end of a recording may be damaged
    }
    if (!last || !is_calibrated(*last)) return info;
    for (size_t i = 1; i < messages.size() && !is_calibrated(info); ++i) info = read(messages[i]);
    if (info != *last) {
      notes_.Warn(
          fmt::format("{} changes, and all frames are played with the first one: where another one is right, "
                      "name a camera file (docs/datasets.md), FILE?camera=camera.yaml",
                      channel.topic));
    }
    return info;
  }

  /// Returns the camera info of the nearest namespace: "/a/left/image_raw" has "/a/left/camera_info".
  RosCameraInfo CameraInfoOf(const std::string& image_topic) {
    std::string space = image_topic;
    for (size_t slash = space.rfind('/'); slash != std::string::npos; slash = space.rfind('/')) {
      space.resize(slash);
      const auto fits = [](const RecordedChannel& c) {
        return RosEncodingOf(c.encoding) && c.type == kRosCameraInfo;
      };
      const RecordedChannel* const channel = Find(space + "/camera_info", fits);
      if (channel == nullptr) continue;
      const std::vector<RecordedMessage> messages = reader_->Messages(channel->topic);
      if (!messages.empty()) return FirstInfo(*channel, messages);
    }
    throw DatasetError(fmt::format("has no camera_info for {}", image_topic));
  }

  /// Returns the sizes of the left and right images by the first pair that can be read; 0 x 0 if there is none.
  std::pair<ImageSize, ImageSize> ImageSizes() const {
    constexpr size_t kTried = 10;
    for (size_t i = 0; i < std::min(kTried, images_.pairs.size()); ++i) {
      try {
        const auto& [left, right] = images_.pairs[i];
        return {SizeOfImage(left_.type, reader_->Read(left), EncodingOf(left_)),
                is_rgbd() ? ImageSize() : SizeOfImage(right_.type, reader_->Read(right), EncodingOf(right_))};
      } catch (const std::runtime_error&) {  // reported when the frame is read
      }
    }
    return {};
  }

  RigCalibration RecordedRig() {
    constexpr const char* kRemedy = "give a camera file (docs/datasets.md), FILE?camera=camera.yaml";
    try {
      const RosCameraInfo left = CameraInfoOf(left_.topic);
      const auto [left_size, right_size] = ImageSizes();
      WarnOfUnusedDistortion(left_.topic, left, kRemedy, &notes_);
      if (is_rgbd()) {
        return MakeRgbdRig(CameraFromRos(InPixelsOfImages(left, left_size), NamesRectified(left_.topic)),
                           kVirtualBaseline_m, kRosDepthUnits_per_m);
      }
      const RosCameraInfo right = CameraInfoOf(right_.topic);
      return RigFromRos(InPixelsOfImages(left, left_size), InPixelsOfImages(right, right_size),
                        NamesRectified(left_.topic));
    } catch (const DatasetError& error) {
      throw DatasetError(fmt::format("{}: {}", error.what(), kRemedy));
    }
  }

  void ReadRig(std::string_view kind) {
    if (const auto given = options_.find("camera"); given != options_.end()) {
      const ImageSize size = ImageSizes().first;
      rig_ = ReadCameraFile(given->second, size, &notes_);
      if ((rig_.kind == RigCalibration::Kind::kRgbd) != is_rgbd()) {
        throw DatasetError(fmt::format("{} is for {}, but {} has {}", given->second,
                                       is_rgbd() ? "a stereo camera" : "an RGB-D camera", right_.topic,
                                       is_rgbd() ? "depths by its name (kind: rgbd)" : "no depths by its name"));
      }
      if (size != ImageSize{} && size != ImageSize{rig_.left.width_px, rig_.left.height_px}) {
        throw DatasetError(fmt::format("{} is for {} x {} pixels, but the images of {} have {} x {}", given->second,
                                       rig_.left.width_px, rig_.left.height_px, left_.topic, size.width_px,
                                       size.height_px));
      }
    } else {
      rig_ = RecordedRig();
      WarnOfLongBaseline("camera_info", rig_,
                         "P[3] is in metres times pixels; where it is not, name a camera file (docs/datasets.md), "
                         "FILE?camera=camera.yaml",
                         &notes_);
    }
    WarnOfOtherScale(options_.contains("camera") ? options_.at("camera") : "K of camera_info", rig_, &notes_);
    rig_.name = kind;
    rig_.rate_hz = 1e9 / static_cast<double>(images_.step_ns);
    const std::string complaint = RigComplaint(rig_);
    if (!complaint.empty()) throw DatasetError(fmt::format("camera of {}: {}", left_.topic, complaint));
  }

  /// Returns the sensor that the location names, or else the nearest one to the left images; nullopt if there is none.
  std::optional<ImuTopics> ChooseImu() {
    const std::vector<ImuTopics> sensors = ImuTopicsOf(*reader_);
    if (const auto given = options_.find("imu"); given != options_.end()) {
      if (given->second == kNoImu) return std::nullopt;
      const ImuTopics named = plslam::ImuTopicsOf(given->second);
      if (std::ranges::find(sensors, named) != sensors.end()) return named;
      std::set<std::string> names;
      for (const ImuTopics& sensor : sensors) names.insert(sensor.rates);
      throw DatasetError(fmt::format("has no samples (sensor_msgs/Imu) on the topic imu={}; {}", Shown(given->second),
                                     names.empty() ? "it has none at all" : "they are on " + ListOf(names)));
    }
    if (sensors.empty()) return std::nullopt;
    const ImuTopics chosen = NearestImu(sensors, left_.topic);
    if (sensors.size() > 1) {
      notes_.Remark(fmt::format("of {} inertial sensors that of {} is used (FILE?imu=TOPIC names another one)",
                                sensors.size(), chosen.rates));
    }
    return chosen;
  }

  /// Finds the calibration of a sensor; without a mounting a warning says what to write.
  std::optional<ImuCalibration> CalibrationOfImu(const ImuTopics& topics, const std::string& frame) {
    const std::filesystem::path file(file_);
    const std::string beside =
        ((std::filesystem::is_directory(file) ? file : file.parent_path()) / "imu.yaml").string();
    const bool has_camera_file = options_.contains("camera");
    ImuSources sources{.files = {beside}, .has_camera_file = has_camera_file};
    if (has_camera_file) sources.files.insert(sources.files.begin(), options_.at("camera"));
    const std::string left_frame = FrameOfLeftImages();
    sources.T_c_imu = RecordedTransform(*reader_, left_frame, frame);
    std::optional<ImuCalibration> imu = FindImuCalibration(topics.rates, rig_, sources, &notes_);
    if (!imu) {
      WarnOfUnusedImu(topics.rates,
                      fmt::format("its pose is not known, since /tf_static does not connect its frame '{}' with '{}' "
                                  "of the left images: write T_c_imu (docs/imu.md) to {}",
                                  Shown(frame), Shown(left_frame), beside));
    }
    return imu;
  }

  std::string FrameOfLeftImages() const {
    try {
      return FrameOf(reader_->Read(images_.pairs.front().first), EncodingOf(left_));
    } catch (const DatasetError&) {
      return "";  // a damaged message is an error when it is played
    }
  }

  /// Reads the samples of a calibrated sensor; without any that can be used, a warning says why.
  void ReadImu() {
    const std::optional<ImuTopics> topics = ChooseImu();
    std::optional<ImuCalibration> calibration;
    if (topics && images_.clock == MessageClock::kLog) {
      WarnOfUnusedImu(topics->rates, "images are played by the times at which they were logged");
    } else if (topics) {
      calibration = CalibrationOfImu(*topics, FrameOfImu(*reader_, *topics));
    }
    rig_.imu = calibration;
    if (!rig_.imu) return;
    try {
      imu_samples_ = ReadRecordedImu(*reader_, *topics, images_.range, &notes_);
      CheckTimesOfImu();
    } catch (const DatasetError& error) {
      if (options_.contains("imu")) throw;
      WarnOfUnusedImu(topics->rates, error.what());
      imu_samples_.clear();
      rig_.imu.reset();
    }
  }

  void WarnOfUnusedImu(const std::string& topic, const std::string& reason) {
    notes_.Warn(fmt::format("{}: the inertial sensor is not used: {}", topic, reason));
  }

  /// Fails if no sample is of the time of the images. Sets an unknown rate.
  void CheckTimesOfImu() {
    const std::string complaint = OtherTimesComplaint(imu_samples_, *rig_.imu, t_ns(0), t_ns(size() - 1));
    if (!complaint.empty()) throw DatasetError(complaint);
    const int64_t first_ns = imu_samples_.front().t_ns, last_ns = imu_samples_.back().t_ns;
    const auto n_steps = static_cast<double>(imu_samples_.size() - 1);
    if (rig_.imu->rate_hz == 0.0 && last_ns > first_ns) {
      rig_.imu->rate_hz = 1e9 * n_steps / static_cast<double>(last_ns - first_ns);
    }
  }

  void ChooseTruth() {
    RecordedChannel chosen;
    if (options_.contains("truth")) {
      chosen = Given("truth", IsPose, "Odometry or PoseStamped");
    } else {
      for (const RecordedChannel& channel : reader_->channels()) {
        const bool is_named = std::any_of(kTruthNames.begin(), kTruthNames.end(), [&](std::string_view name) {
          return channel.topic.find(name) != std::string::npos;
        });
        if (is_named && IsPose(channel) && chosen.topic.empty()) chosen = channel;
      }
    }
    if (chosen.topic.empty()) return;
    truth_channel_ = chosen;
    std::vector<RecordedMessage> messages = reader_->Messages(chosen.topic);
    std::erase_if(messages, [&](const RecordedMessage& message) { return !images_.range.Contains(message); });
    if (images_.clock == MessageClock::kStamp)
      ReadStamps(*reader_, {&messages}, images_.step_ns / kDelayToleranceShare);
    const std::string complaint = images_.clock == MessageClock::kStamp ? StampComplaint(messages) : "";
    if (!complaint.empty()) {
      notes_.Warn(
          fmt::format("header stamps of {} {}: its poses have the times at which they were logged, plus "
                      "the {} s by which stamps of {} differ from those",
                      chosen.topic, complaint, SecondsText(images_.stamp_offset_ns), left_.topic));
      for (RecordedMessage& message : messages) message.stamp_ns = RecordedMessage::kNotRead;
      StampByLogTime(images_.stamp_offset_ns, &messages);
    }
    truth_ = InOrderOfTime(std::move(messages), images_.clock, chosen.topic, &notes_);
    truth_is_estimated_ = std::any_of(truth_.begin(), truth_.end(), [](const auto& m) { return m.is_estimated; });
  }

  std::string name_;
  std::string file_;
  std::map<std::string, std::string> options_;
  std::unique_ptr<Recording> reader_;
  RecordedChannel left_, right_;
  ImagePairs images_;
  int white_ = kWhiteOf16Bits;
  mutable std::optional<ClippedFrames> clipped_;
  RigCalibration rig_;
  std::vector<ImuSample> imu_samples_;
  RecordedChannel truth_channel_;
  std::vector<RecordedMessage> truth_;
  bool truth_is_estimated_ = false;  ///< some of its stamps
  plslam::Notes notes_;
};

std::optional<SE3> RecordingDataset::GroundTruth(int index) const {
  const int64_t t = t_ns(index), reach_ns = truth_is_estimated_ ? images_.step_ns : 0;
  const auto first_from = [&](int64_t from_ns) {
    return std::lower_bound(truth_.begin(), truth_.end(), from_ns,
                            [](const RecordedMessage& message, int64_t time) { return message.t_ns < time; });
  };
  auto at = first_from(t - reach_ns);
  const auto last = first_from(t + reach_ns);
  if (at != truth_.begin()) --at;
  std::map<int64_t, SE3> poses;
  for (; at != truth_.end() && at <= last; ++at) {
    try {
      const std::vector<uint8_t> message = reader_->Read(*at);
      const int64_t pose_ns = at->is_estimated ? StampOf(message) : at->t_ns;
      poses.emplace(pose_ns, ParsePose(truth_channel_.type, message, EncodingOf(truth_channel_)));
    } catch (const std::runtime_error&) {
      return std::nullopt;  // a damaged pose is no truth
    }
  }
  Trajectory neighbours;
  for (const auto& [pose_ns, pose] : poses) neighbours.push_back({pose_ns, pose});
  return neighbours.empty() ? std::nullopt : InterpolatePose(neighbours, t, kMaxTruthGap_ns);
}

template <class Reader>
std::unique_ptr<Dataset> Open(const std::string& location, std::string_view kind) {
  const Location parts = TakeApart(location);
  Notes notes;
  const auto open = [&](const std::string& why_scan) {
    auto reader = std::make_unique<Reader>(parts.file, why_scan);
    notes = reader->Notes();
    return std::make_unique<RecordingDataset>(location, parts, kind, std::move(reader));
  };
  try {
    try {
      return open("");
    } catch (const Recording::DamagedIndex& damage) {
      return open(damage.what());
    }
  } catch (const std::runtime_error& error) {
    const std::string note =
        notes.empty() ? "" : fmt::format(" ({})", (notes.warnings.empty() ? notes.remarks : notes.warnings).front());
    throw DatasetError(fmt::format("{}: {}{}", parts.file, error.what(), note));
  }
}

/// The location, with or without options, is a file that begins so, or that has the name of such a file.
bool IsFile(const std::string& location, bool (*looks_like)(const std::string& path), const char* extension) {
  const auto fits = [&](const std::string& path) {
    return looks_like(path) ||
           (std::filesystem::path(path).extension() == extension && std::filesystem::is_regular_file(path));
  };
  return fits(FileOfLocation(location));
}

}  // namespace

std::unique_ptr<Dataset> OpenMcapDataset(const std::string& location) { return Open<McapReader>(location, "mcap"); }

std::unique_ptr<Dataset> OpenBagDataset(const std::string& location) { return Open<BagReader>(location, "bag"); }

std::unique_ptr<Dataset> OpenRos2BagDataset(const std::string& location) {
  return Open<Ros2Bag>(location, "ros2bag");
}

bool LooksLikeMcap(const std::string& location) { return IsFile(location, LooksLikeMcapFile, ".mcap"); }

bool LooksLikeBag(const std::string& location) { return IsFile(location, LooksLikeBagFile, ".bag"); }

bool LooksLikeRos2Bag(const std::string& location) { return LooksLikeRos2BagPath(FileOfLocation(location)); }

std::string FileOfLocation(const std::string& location) {
  std::error_code no_such_file;
  return std::filesystem::exists(location, no_such_file) ? location : location.substr(0, location.rfind('?'));
}

}  // namespace plslam
