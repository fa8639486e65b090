// SPDX-License-Identifier: BSD-3-Clause
#include "ros2/dds/participant.h"

#include <dds/dds.h>
#include <dds/ddsi/ddsi_cdrstream.h>
#include <dds/ddsi/q_protocol.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <map>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include <ros_types.h>
#include "core/errors/error_text.h"
#include "core/files/dataset_error.h"
#include "ros2/names.h"

namespace plslam::ros2 {
namespace {

constexpr int kDepth = 5;
constexpr uint32_t kTaken = 8;
/// User data of our writers, by which other processes of plslam know them.
constexpr std::string_view kOurs = "plslam=1;";

/// The generated descriptor of each type of the table.
const dds_topic_descriptor_t& DescriptorOf(std::string_view type) {
  using Row = std::pair<std::string_view, const dds_topic_descriptor_t*>;
  static const std::array kRows = {
      Row{"tf2_msgs/msg/TFMessage", &tf2_msgs_msg_dds__TFMessage__desc},
      Row{"nav_msgs/msg/Odometry", &nav_msgs_msg_dds__Odometry__desc},
      Row{"nav_msgs/msg/Path", &nav_msgs_msg_dds__Path__desc},
      Row{"nav_msgs/msg/OccupancyGrid", &nav_msgs_msg_dds__OccupancyGrid__desc},
      Row{"geometry_msgs/msg/PoseArray", &geometry_msgs_msg_dds__PoseArray__desc},
      Row{"geometry_msgs/msg/PoseWithCovarianceStamped", &geometry_msgs_msg_dds__PoseWithCovarianceStamped__desc},
      Row{"sensor_msgs/msg/CompressedImage", &sensor_msgs_msg_dds__CompressedImage__desc},
      Row{"sensor_msgs/msg/CameraInfo", &sensor_msgs_msg_dds__CameraInfo__desc},
      Row{"sensor_msgs/msg/PointCloud2", &sensor_msgs_msg_dds__PointCloud2__desc},
      Row{"visualization_msgs/msg/Marker", &visualization_msgs_msg_dds__Marker__desc},
      Row{"diagnostic_msgs/msg/DiagnosticArray", &diagnostic_msgs_msg_dds__DiagnosticArray__desc}};
  const auto* const row = std::find_if(kRows.begin(), kRows.end(), [&](const Row& r) { return r.first == type; });
  if (row == kRows.end()) throw std::logic_error(fmt::format("{} is not in ros_types.idl", type));
  return *row->second;
}

/// Returns the entity, or throws with what failed.
dds_entity_t Checked(dds_entity_t result, const std::string& what) {
  if (result >= 0) return result;
  throw std::runtime_error(fmt::format("{}: DDS reports '{}'", what, dds_strretcode(-result)));
}

struct QosDeleter {
  void operator()(dds_qos_t* qos) const { dds_delete_qos(qos); }
};
using Qos = std::unique_ptr<dds_qos_t, QosDeleter>;

Qos ReaderQos() {
  Qos qos(dds_create_qos());
  dds_qset_reliability(qos.get(), DDS_RELIABILITY_BEST_EFFORT, 0);
  dds_qset_durability(qos.get(), DDS_DURABILITY_VOLATILE);
  dds_qset_history(qos.get(), DDS_HISTORY_KEEP_LAST, kDepth);
  return qos;
}

Qos StaticFramesQos() {
  Qos qos = ReaderQos();
  dds_qset_reliability(qos.get(), DDS_RELIABILITY_RELIABLE, 0);
  dds_qset_durability(qos.get(), DDS_DURABILITY_TRANSIENT_LOCAL);
  dds_qset_history(qos.get(), DDS_HISTORY_KEEP_LAST, 100);
  return qos;
}

Qos WriterQos(RosQos kind) {
  Qos qos(dds_create_qos());
  const bool is_latched = kind == RosQos::kLatched;
  // A reliable writer does not wait for slow readers: only its last messages are kept.
  if (kind == RosQos::kImage) {
    dds_qset_reliability(qos.get(), DDS_RELIABILITY_BEST_EFFORT, 0);
  } else {
    dds_qset_reliability(qos.get(), DDS_RELIABILITY_RELIABLE, DDS_MSECS(100));
  }
  dds_qset_durability(qos.get(), is_latched ? DDS_DURABILITY_TRANSIENT_LOCAL : DDS_DURABILITY_VOLATILE);
  dds_qset_history(qos.get(), DDS_HISTORY_KEEP_LAST, is_latched ? 1 : kDepth);
  dds_qset_userdata(qos.get(), kOurs.data(), kOurs.size());
  if (is_latched) dds_qset_durability_service(qos.get(), 0, DDS_HISTORY_KEEP_LAST, 1, -1, -1, -1);
  return qos;
}

const char* PolicyName(uint32_t id) {
  switch (id) {
    case DDS_DURABILITY_QOS_POLICY_ID:
      return "durability";
    case DDS_DEADLINE_QOS_POLICY_ID:
      return "deadline";
    case DDS_OWNERSHIP_QOS_POLICY_ID:
      return "ownership";
    case DDS_LIVELINESS_QOS_POLICY_ID:
      return "liveliness";
    case DDS_RELIABILITY_QOS_POLICY_ID:
      return "reliability";
    default:
      return "another policy";
  }
}

Guid ToGuid(const dds_guid_t& guid) {
  Guid bytes{};
  std::copy_n(std::begin(guid.v), bytes.size(), bytes.begin());
  return bytes;
}

Guid GuidOf(dds_entity_t entity) {
  dds_guid_t guid{};
  Checked(dds_get_guid(entity, &guid), "an identity");
  return ToGuid(guid);
}

int64_t StampOf(const std_msgs_msg_dds__Header_& header) {
  constexpr uint32_t kSecond_ns = 1'000'000'000;
  if (header.stamp.sec < 0 || header.stamp.nanosec >= kSecond_ns) {
    throw DatasetError(fmt::format("has an invalid stamp: {} s, {} ns", header.stamp.sec, header.stamp.nanosec));
  }
  return int64_t{header.stamp.sec} * kSecond_ns + header.stamp.nanosec;
}

int ToInt(uint32_t pixels) {
  if (pixels > INT32_MAX) throw DatasetError(fmt::format("has an invalid size: {} pixels", pixels));
  return static_cast<int>(pixels);
}

/// Quaternions that others have rounded are normalised.
template <class Translation>
SE3 ToPose(const Translation& translation, const geometry_msgs_msg_dds__Quaternion_& rotation) {
  constexpr double kUnitTolerance = 1e-2;
  constexpr double kFarthest_m = 4e7;  // around the Earth
  const Eigen::Quaterniond q(rotation.w, rotation.x, rotation.y, rotation.z);
  const Eigen::Vector3d t(translation.x, translation.y, translation.z);
  // A NaN is not near 1, either.
  if (!(std::abs(q.norm() - 1.0) < kUnitTolerance) || !(t.norm() < kFarthest_m)) {
    throw DatasetError("has an invalid pose");
  }
  return {q, t};
}

std::string UserDataOf(const dds_qos_t* qos) {
  void* data = nullptr;
  size_t n_bytes = 0;
  dds_qget_userdata(qos, &data, &n_bytes);
  std::string text(static_cast<const char*>(data), n_bytes);
  dds_free(data);
  return text;
}

std::string TextOf(const char* text) { return text == nullptr ? "" : text; }

robot::ForeignImage ToImage(const sensor_msgs_msg_dds__Image_& message) {
  robot::ForeignImage image;
  image.t_ns = StampOf(message.header);
  image.width_px = message.width;
  image.height_px = message.height;
  image.step_bytes = message.step;
  image.encoding = TextOf(message.encoding);
  if (image.encoding.empty()) throw DatasetError("has no encoding");
  image.is_big_endian = message.is_bigendian != 0;
  image.bytes.assign(message.data._buffer, message.data._buffer + message.data._length);
  return image;
}

robot::ForeignImage ToImage(const sensor_msgs_msg_dds__CompressedImage_& message) {
  robot::ForeignImage image;
  image.t_ns = StampOf(message.header);
  image.format = TextOf(message.format);
  image.bytes.assign(message.data._buffer, message.data._buffer + message.data._length);
  return image;
}

RosCameraInfo ToInfo(const sensor_msgs_msg_dds__CameraInfo_& message) {
  using Rows3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
  using Rows34 = Eigen::Matrix<double, 3, 4, Eigen::RowMajor>;
  RosCameraInfo info;
  info.width_px = ToInt(message.width);
  info.height_px = ToInt(message.height);
  info.model = TextOf(message.distortion_model);
  info.distortion.assign(message.d._buffer, message.d._buffer + message.d._length);
  info.K = Eigen::Map<const Rows3>(message.k);
  info.R = Eigen::Map<const Rows3>(message.r);
  info.P = Eigen::Map<const Rows34>(message.p);
  info.binning_x = ToInt(message.binning_x);
  info.binning_y = ToInt(message.binning_y);
  info.roi = {ToInt(message.roi.x_offset), ToInt(message.roi.y_offset), ToInt(message.roi.width),
              ToInt(message.roi.height)};
  return info;
}

RosImu ToImu(const sensor_msgs_msg_dds__Imu_& message) {
  constexpr double kNotMeasured = -1.0;
  const geometry_msgs_msg_dds__Vector3_ &rate = message.angular_velocity, &force = message.linear_acceleration;
  RosImu imu;
  imu.sample = {StampOf(message.header), {rate.x, rate.y, rate.z}, {force.x, force.y, force.z}};
  imu.frame = TextOf(message.header.frame_id);
  imu.has_rate = message.angular_velocity_covariance[0] != kNotMeasured;
  imu.has_force = message.linear_acceleration_covariance[0] != kNotMeasured;
  if (!imu.sample.rate_rad_s.allFinite() || !imu.sample.force_m_s2.allFinite()) {
    throw DatasetError("has numbers that are not finite");
  }
  return imu;
}

}  // namespace

struct Participant::Impl {
  struct Reader {
    std::string topic;
    dds_entity_t entity = 0;
    std::function<void(const void* sample)> take;
    int64_t n_messages = 0;
  };
  struct Writer {
    dds_entity_t entity = 0;
    const dds_topic_descriptor_t* type = nullptr;
  };

  Impl(const Domain& of, const std::string& configuration) {
    // Fails if this process has the domain already, which then has its configuration.
    domain = dds_create_domain(static_cast<dds_domainid_t>(of.id), configuration.c_str());
    Checked(domain, fmt::format("the DDS domain {} cannot be opened", of.id));
    try {
      participant = Checked(dds_create_participant(static_cast<dds_domainid_t>(of.id), nullptr, nullptr),
                            fmt::format("the DDS domain {} cannot be joined", of.id));
      waitset = Checked(dds_create_waitset(participant), "no wait set");
      publications = Checked(dds_create_reader(participant, DDS_BUILTIN_TOPIC_DCPSPUBLICATION, nullptr, nullptr),
                             "discovery cannot be read");
    } catch (const std::exception&) {
      dds_delete(domain);
      throw;
    }
  }
  ~Impl() { dds_delete(domain); }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  dds_entity_t Topic(const std::string& topic, const dds_topic_descriptor_t& type) const {
    return Checked(dds_create_topic(participant, &type, DdsTopicName(topic).c_str(), nullptr, nullptr),
                   fmt::format("the topic {} cannot be made", topic));
  }

  size_t Read(const std::string& topic, const dds_topic_descriptor_t& type, const Qos& qos,
              std::function<void(const void* sample)> take) {
    readers.push_back({topic, 0, std::move(take)});
    Open(readers.size() - 1, type, qos);
    return readers.size() - 1;
  }

  /// Creates the entity of a reader.
  void Open(size_t number, const dds_topic_descriptor_t& type, const Qos& qos) {
    Reader& reader = readers[number];
    reader.entity = Checked(dds_create_reader(participant, Topic(reader.topic, type), qos.get(), nullptr),
                            fmt::format("{} cannot be read", reader.topic));
    const dds_entity_t condition = Checked(dds_create_readcondition(reader.entity, DDS_ANY_STATE),
                                           fmt::format("{} cannot be read", reader.topic));
    Checked(dds_waitset_attach(waitset, condition, static_cast<dds_attach_t>(number)), "no wait set");
  }

  /// Calls `use` for the samples that a take lends; they are given back in any case.
  template <class Use>
  static void TakeSamples(dds_entity_t reader, Use use) {
    std::array<void*, kTaken> samples{};
    std::array<dds_sample_info_t, kTaken> infos{};
    const dds_return_t n = dds_take(reader, samples.data(), infos.data(), kTaken, kTaken);
    if (n <= 0) return;
    struct Loan {
      dds_entity_t of;
      std::array<void*, kTaken>& lent;
      dds_return_t n_lent;
      ~Loan() { dds_return_loan(of, lent.data(), n_lent); }
    } loan{reader, samples, n};
    for (size_t i = 0; i < static_cast<size_t>(n); ++i) {
      if (infos[i].valid_data) use(samples[i]);
    }
  }

  template <class Use>
  void ForEachPublication(Use use) const;

  dds_entity_t domain = 0, participant = 0, waitset = 0, publications = 0;
  std::vector<Reader> readers;
  std::optional<size_t> static_frames;  ///< reader of /tf_static
  std::mutex mutex;                     ///< of the writers
  std::map<std::string, Writer> writers;
};

Participant::Participant(const Domain& domain, const std::string& configuration)
    : impl_(std::make_unique<Impl>(domain, configuration)) {}

Participant::~Participant() = default;

size_t Participant::ReadImages(const std::string& topic, bool is_compressed,
                               std::function<void(robot::ForeignImage)> take) {
  if (is_compressed) {
    return impl_->Read(topic, sensor_msgs_msg_dds__CompressedImage__desc, ReaderQos(),
                       [take = std::move(take)](const void* sample) {
                         take(ToImage(*static_cast<const sensor_msgs_msg_dds__CompressedImage_*>(sample)));
                       });
  }
  return impl_->Read(topic, sensor_msgs_msg_dds__Image__desc, ReaderQos(),
                     [take = std::move(take)](const void* sample) {
                       take(ToImage(*static_cast<const sensor_msgs_msg_dds__Image_*>(sample)));
                     });
}

size_t Participant::ReadInfos(const std::string& topic,
                              std::function<void(RosCameraInfo, const std::string& frame)> take) {
  return impl_->Read(topic, sensor_msgs_msg_dds__CameraInfo__desc, ReaderQos(),
                     [take = std::move(take)](const void* sample) {
                       const auto& message = *static_cast<const sensor_msgs_msg_dds__CameraInfo_*>(sample);
                       take(ToInfo(message), TextOf(message.header.frame_id));
                     });
}

void Participant::ReadStaticFrames(
    std::function<void(const std::string& parent, const std::string& child, const SE3&)> take) {
  const auto take_all = [take = std::move(take)](const void* sample) {
    const auto& message = *static_cast<const tf2_msgs_msg_dds__TFMessage_*>(sample);
    std::string complaint;
    for (uint32_t i = 0; i < message.transforms._length; ++i) {
      const auto& transform = message.transforms._buffer[i];
      const std::string child = TextOf(transform.child_frame_id);
      try {
        take(TextOf(transform.header.frame_id), child,
             ToPose(transform.transform.translation, transform.transform.rotation));
      } catch (const DatasetError&) {
        complaint = fmt::format("has an invalid transform of {}", Shown(child));
      }
    }
    if (!complaint.empty()) throw DatasetError(complaint);
  };
  impl_->static_frames = impl_->Read("/tf_static", tf2_msgs_msg_dds__TFMessage__desc, StaticFramesQos(), take_all);
}

void Participant::ReadStaticFramesAgain() {
  if (!impl_->static_frames) return;
  dds_delete(impl_->readers[*impl_->static_frames].entity);
  impl_->Open(*impl_->static_frames, tf2_msgs_msg_dds__TFMessage__desc, StaticFramesQos());
}

size_t Participant::ReadImu(const std::string& topic, std::function<void(const RosImu& message)> take) {
  const Qos qos = ReaderQos();
  dds_qset_history(qos.get(), DDS_HISTORY_KEEP_LAST, 500);  // half a second of a fast sensor
  return impl_->Read(topic, sensor_msgs_msg_dds__Imu__desc, qos, [take = std::move(take)](const void* sample) {
    take(ToImu(*static_cast<const sensor_msgs_msg_dds__Imu_*>(sample)));
  });
}

size_t Participant::ReadOdometry(const std::string& topic,
                                 std::function<void(int64_t t_ns, const SE3& T_robot_b)> take) {
  const Qos qos = ReaderQos();
  dds_qset_history(qos.get(), DDS_HISTORY_KEEP_LAST, 100);  // half a second of fast wheels
  return impl_->Read(topic, nav_msgs_msg_dds__Odometry__desc, qos, [take = std::move(take)](const void* sample) {
    const auto& message = *static_cast<const nav_msgs_msg_dds__Odometry_*>(sample);
    take(StampOf(message.header), ToPose(message.pose.pose.position, message.pose.pose.orientation));
  });
}

void Participant::Receive(
    std::chrono::milliseconds limit,
    const std::function<void(const std::string& topic, const std::string& reason)>& on_rejected) {
  std::array<dds_attach_t, kTaken> ready{};
  const dds_return_t n =
      dds_waitset_wait(impl_->waitset, ready.data(), ready.size(), DDS_MSECS(int64_t{limit.count()}));
  for (size_t i = 0; i < std::min<size_t>(n < 0 ? 0 : static_cast<size_t>(n), ready.size()); ++i) {
    Impl::Reader& reader = impl_->readers.at(static_cast<size_t>(ready[i]));
    const auto use = [&](const void* sample) {
      ++reader.n_messages;
      try {
        reader.take(sample);
      } catch (const DatasetError& error) {
        on_rejected(reader.topic, error.what());
      }
    };
    Impl::TakeSamples(reader.entity, use);
  }
}

ReaderState Participant::StateOf(size_t number) const {
  const Impl::Reader& reader = impl_->readers.at(number);
  ReaderState state;
  state.n_messages = reader.n_messages;
  dds_subscription_matched_status_t matched{};
  if (dds_get_subscription_matched_status(reader.entity, &matched) == DDS_RETCODE_OK) {
    state.n_publishers = static_cast<int>(matched.current_count);
  }
  dds_requested_incompatible_qos_status_t incompatible{};
  if (dds_get_requested_incompatible_qos_status(reader.entity, &incompatible) == DDS_RETCODE_OK &&
      incompatible.total_count > 0) {
    state.incompatible_qos = PolicyName(incompatible.last_policy_id);
  }
  return state;
}

void Participant::Write(const RosTopic& row, const std::string& topic, const std::string& cdr) {
  constexpr size_t kCdrHeadBytes = 4;
  const std::scoped_lock lock(impl_->mutex);
  Impl::Writer& writer = impl_->writers[topic];
  if (writer.type == nullptr) {
    const dds_topic_descriptor_t& type = DescriptorOf(row.type);
    const Qos qos = WriterQos(row.qos);
    writer.entity = Checked(dds_create_writer(impl_->participant, impl_->Topic(topic, type), qos.get(), nullptr),
                            fmt::format("{} cannot be published", topic));
    writer.type = &type;
  }
  // The bytes become a sample of the generated type, which DDS writes again: its interface takes no bytes.
  std::unique_ptr<void, decltype(&std::free)> sample(std::calloc(1, writer.type->m_size), std::free);
  if (!sample) throw std::bad_alloc();
  dds_istream_t stream;
  dds_istream_init(&stream, static_cast<uint32_t>(cdr.size() - kCdrHeadBytes), cdr.data() + kCdrHeadBytes,
                   CDR_ENC_VERSION_1);
  dds_stream_read(&stream, static_cast<char*>(sample.get()), writer.type->m_ops);
  const dds_return_t result = dds_write(writer.entity, sample.get());
  dds_stream_free_sample(sample.get(), writer.type->m_ops);
  if (result != DDS_RETCODE_OK && result != DDS_RETCODE_TIMEOUT) Checked(result, topic + " cannot be published");
}

std::vector<Guid> Participant::Readers() const {
  std::vector<Guid> guids;
  for (const Impl::Reader& reader : impl_->readers) guids.push_back(GuidOf(reader.entity));
  return guids;
}

std::vector<Guid> Participant::Writers() const {
  const std::scoped_lock lock(impl_->mutex);
  std::vector<Guid> guids;
  for (const auto& [topic, writer] : impl_->writers) guids.push_back(GuidOf(writer.entity));
  return guids;
}

/// Calls `use` for the endpoints that publish in the domain.
template <class Use>
void Participant::Impl::ForEachPublication(Use use) const {
  // Discovery keeps one sample for each endpoint; they are read in portions.
  std::vector<void*> samples(1024, nullptr);
  std::vector<dds_sample_info_t> infos(samples.size());
  const dds_return_t n = dds_read_mask(publications, samples.data(), infos.data(), samples.size(),
                                       static_cast<uint32_t>(samples.size()), DDS_ANY_STATE);
  for (size_t i = 0; n > 0 && i < static_cast<size_t>(n); ++i) {
    const auto& endpoint = *static_cast<const dds_builtintopic_endpoint_t*>(samples[i]);
    if (infos[i].valid_data && infos[i].instance_state == DDS_ALIVE_INSTANCE_STATE) use(endpoint);
  }
  if (n > 0) dds_return_loan(publications, samples.data(), n);
}

std::optional<size_t> Participant::GidBytes(const Guid& own) const {
  std::optional<size_t> gid_bytes;
  impl_->ForEachPublication([&](const dds_builtintopic_endpoint_t& endpoint) {
    if (TextOf(endpoint.topic_name) != kNodeInfoTopic || ToGuid(endpoint.participant_key) == own) return;
    const bool names_types = UserDataOf(endpoint.qos).find("typehash=") != std::string::npos;
    gid_bytes = names_types ? kGidBytes : kGidBytesBeforeIron;
  });
  return gid_bytes;
}

std::vector<Publisher> Participant::Publishers() const {
  std::vector<Publisher> publishers;
  const Guid own = GuidOf(impl_->participant);
  impl_->ForEachPublication([&](const dds_builtintopic_endpoint_t& endpoint) {
    if (ToGuid(endpoint.participant_key) == own) return;
    Publisher publisher{RosTopicName(TextOf(endpoint.topic_name)), RosTypeName(TextOf(endpoint.type_name))};
    if (publisher.topic.empty()) return;
    dds_reliability_kind_t reliability = DDS_RELIABILITY_BEST_EFFORT;
    dds_duration_t blocking = 0;
    dds_qget_reliability(endpoint.qos, &reliability, &blocking);
    dds_durability_kind_t durability = DDS_DURABILITY_VOLATILE;
    dds_qget_durability(endpoint.qos, &durability);
    publisher.is_reliable = reliability == DDS_RELIABILITY_RELIABLE;
    publisher.is_latched = durability != DDS_DURABILITY_VOLATILE;
    publisher.is_ours = UserDataOf(endpoint.qos) == kOurs;
    publishers.push_back(std::move(publisher));
  });
  return publishers;
}

}  // namespace plslam::ros2
