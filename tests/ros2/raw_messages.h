// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <unistd.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <map>
#include <mutex>
#include <random>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "tests/ros2/fast_robot.h"

namespace plslam::test {

/// Messages as they are, under the name of a type.
class RawType : public fast::TopicDataType {
 public:
  explicit RawType(const std::string& name) {
    setName(name.c_str());
    m_typeSize = kMostBytes;
    auto_fill_type_object(false);
    auto_fill_type_information(false);
  }
  bool serialize(void* data, eprosima::fastrtps::rtps::SerializedPayload_t* payload) override {
    const auto& bytes = *static_cast<std::vector<uint8_t>*>(data);
    std::copy(bytes.begin(), bytes.end(), payload->data);
    payload->length = static_cast<uint32_t>(bytes.size());
    payload->encapsulation = bytes.size() > 1 ? bytes[1] : 0;
    return true;
  }
  bool deserialize(eprosima::fastrtps::rtps::SerializedPayload_t* payload, void* data) override {
    static_cast<std::vector<uint8_t>*>(data)->assign(payload->data, payload->data + payload->length);
    return true;
  }
  std::function<uint32_t()> getSerializedSizeProvider(void* data) override {
    return [data] { return static_cast<uint32_t>(static_cast<std::vector<uint8_t>*>(data)->size()); };
  }
  void* createData() override { return new std::vector<uint8_t>(); }
  void deleteData(void* data) override { delete static_cast<std::vector<uint8_t>*>(data); }
  bool getKey(void* /*data*/, eprosima::fastrtps::rtps::InstanceHandle_t* /*handle*/, bool /*md5*/) override {
    return false;
  }

  static constexpr uint32_t kMostBytes = 200'000;
};

/// Sends damaged copies of a valid message: other bytes, lengths of 4 GB, the other endianness, and shorter ones.
template <class Type>
void SendDamaged(const std::string& dds_topic, const typename Type::type& valid, int n) {
  Type type;
  eprosima::fastrtps::rtps::SerializedPayload_t payload(RawType::kMostBytes);
  auto message = valid;
  type.serialize(&message, &payload);
  auto* const participant = fast::DomainParticipantFactory::get_instance()->create_participant(
      DomainOfRobot(), fast::PARTICIPANT_QOS_DEFAULT);
  const fast::TypeSupport raw(new RawType(type.getName()));
  raw.register_type(participant);
  fast::DataWriterQos qos = fast::DATAWRITER_QOS_DEFAULT;
  qos.reliability().kind = fast::RELIABLE_RELIABILITY_QOS;
  qos.durability().kind = fast::TRANSIENT_LOCAL_DURABILITY_QOS;
  auto* const writer =
      participant->create_publisher(fast::PUBLISHER_QOS_DEFAULT)
          ->create_datawriter(participant->create_topic(dds_topic, type.getName(), fast::TOPIC_QOS_DEFAULT), qos);
  fast::PublicationMatchedStatus status;
  for (int i = 0; i < 500 && status.current_count == 0; ++i) {
    usleep(10'000);
    writer->get_publication_matched_status(status);
  }
  std::mt19937 random(11);
  for (int i = 0; i < n; ++i) {
    std::vector<uint8_t> bytes(payload.data, payload.data + payload.length);
    // Most of a message are pixels, which say nothing.
    const size_t n_head = std::min<size_t>(bytes.size(), 120);
    for (int k = 0; k < 1 + i % 4; ++k) bytes[4 + random() % (n_head - 4)] = static_cast<uint8_t>(random());
    const size_t word = 4 + 4 * (random() % (n_head / 4 - 1));
    if (i % 3 == 0) std::fill_n(bytes.begin() + static_cast<std::ptrdiff_t>(word), 4, uint8_t{0xff});
    if (i % 7 == 0) bytes[1] = 0;
    if (i % 5 == 0) bytes.resize(4 + random() % (bytes.size() - 4));
    writer->write(&bytes);
    usleep(1000);
  }
}

/// Discovers the publishers of other processes, and counts what arrives on their topics, of any type.
class Census : public fast::DomainParticipantListener {
 public:
  /// Counts the messages of topics whose names contain `part`.
  explicit Census(std::string part);

  /// Reads what has arrived.
  void Listen();
  /// By topic of DDS ("rt/plslam/odom"): its `type`, whether it is `reliable` and `latched`, the number `n` of messages,
  /// and the identities of its `writers`, in hexadecimal digits.
  const nlohmann::json& topics() const { return topics_; }
  /// The topic of the writer with whose identity these digits begin; empty if it is not known.
  std::string TopicOf(const std::string& digits) const;

 private:
  void on_publisher_discovery(fast::DomainParticipant* participant,
                              eprosima::fastrtps::rtps::WriterDiscoveryInfo&& info) override;

  const std::string part_;
  fast::DomainParticipant* participant_ = nullptr;
  fast::Subscriber* subscriber_ = nullptr;
  std::mutex mutex_;  ///< of the next one
  std::vector<eprosima::fastrtps::rtps::WriterProxyData> found_;
  std::map<std::string, fast::DataReader*> readers_;
  nlohmann::json topics_ = nlohmann::json::object();
};

/// An identity as ROS and DDS write it.
template <class Bytes>
std::string HexOf(const Bytes& bytes) {
  constexpr const char* kDigits = "0123456789abcdef";
  std::string digits;
  for (const uint8_t byte : bytes) digits.append({kDigits[byte >> 4U], kDigits[byte & 15U]});
  return digits;
}

}  // namespace plslam::test
