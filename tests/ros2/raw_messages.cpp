// SPDX-License-Identifier: BSD-3-Clause
#include "tests/ros2/raw_messages.h"

#include <iterator>
#include <utility>

namespace plslam::test {

namespace rtps = eprosima::fastrtps::rtps;

Census::Census(std::string part) : part_(std::move(part)) {
  participant_ = fast::DomainParticipantFactory::get_instance()->create_participant(
      DomainOfRobot(), fast::PARTICIPANT_QOS_DEFAULT, this, fast::StatusMask::none());
  subscriber_ = participant_->create_subscriber(fast::SUBSCRIBER_QOS_DEFAULT);
}

void Census::on_publisher_discovery(fast::DomainParticipant* participant, rtps::WriterDiscoveryInfo&& info) {
  if (info.status != rtps::WriterDiscoveryInfo::DISCOVERED_WRITER) return;
  if (info.info.guid().is_on_same_process_as(participant->guid())) return;
  const std::scoped_lock lock(mutex_);
  found_.push_back(info.info);
}

std::string Census::TopicOf(const std::string& digits) const {
  for (const auto& [name, topic] : topics_.items()) {
    for (const auto& writer : topic["writers"]) {
      if (digits.rfind(writer.get<std::string>(), 0) == 0) return name;
    }
  }
  return "";
}

void Census::Listen() {
  std::vector<rtps::WriterProxyData> found;
  {
    const std::scoped_lock lock(mutex_);
    found = std::exchange(found_, {});
  }
  for (const rtps::WriterProxyData& writer : found) {
    const std::string name = writer.topicName().to_string(), type = writer.typeName().to_string();
    nlohmann::json& topic = topics_[name];
    topic["type"] = type;
    topic["reliable"] = writer.m_qos.m_reliability.kind == fast::RELIABLE_RELIABILITY_QOS;
    topic["latched"] = writer.m_qos.m_durability.kind != fast::VOLATILE_DURABILITY_QOS;
    if (!topic.contains("n")) topic["n"] = 0;
    std::vector<uint8_t> guid(std::begin(writer.guid().guidPrefix.value), std::end(writer.guid().guidPrefix.value));
    guid.insert(guid.end(), std::begin(writer.guid().entityId.value), std::end(writer.guid().entityId.value));
    topic["writers"].push_back(HexOf(guid));
    if (name.find(part_) == std::string::npos || readers_.count(name) > 0) continue;
    const fast::TypeSupport support(new RawType(type));
    support.register_type(participant_);
    fast::DataReaderQos qos = fast::DATAREADER_QOS_DEFAULT;
    qos.history().depth = 200;
    qos.reliability().kind =
        topic["reliable"].get<bool>() ? fast::RELIABLE_RELIABILITY_QOS : fast::BEST_EFFORT_RELIABILITY_QOS;
    if (topic["latched"].get<bool>()) qos.durability().kind = fast::TRANSIENT_LOCAL_DURABILITY_QOS;
    readers_[name] =
        subscriber_->create_datareader(participant_->create_topic(name, type, fast::TOPIC_QOS_DEFAULT), qos);
  }
  for (const auto& [name, reader] : readers_) {
    std::vector<uint8_t> bytes;
    fast::SampleInfo info;
    while (reader->take_next_sample(&bytes, &info) == ReturnCode_t::RETCODE_OK) {
      if (info.valid_data) topics_[name]["n"] = topics_[name]["n"].get<int>() + 1;
    }
  }
}

}  // namespace plslam::test
