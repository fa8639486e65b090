// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <cstdlib>
#include <string>

#include <fastcdr/Cdr.h>
#include <fastcdr/FastBuffer.h>
#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/domain/DomainParticipantListener.hpp>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <fastdds/dds/topic/TypeSupport.hpp>

namespace plslam::test {

namespace fast = eprosima::fastdds::dds;

/// A generated type (`Generated` of fastddsgen) that is written in big-endian order, as by a robot with such a processor.
template <class Generated>
class BigEndian : public Generated {
 public:
  bool serialize(void* data, eprosima::fastrtps::rtps::SerializedPayload_t* payload) override {
    using eprosima::fastcdr::Cdr;
    eprosima::fastcdr::FastBuffer buffer(reinterpret_cast<char*>(payload->data), payload->max_size);
    Cdr cdr(buffer, Cdr::BIG_ENDIANNESS, Cdr::DDS_CDR);
    payload->encapsulation = CDR_BE;
    cdr.serialize_encapsulation();
    static_cast<typename Generated::type*>(data)->serialize(cdr);
    payload->length = static_cast<uint32_t>(cdr.getSerializedDataLength());
    return true;
  }
};

/// The domain of the environment.
inline uint32_t DomainOfRobot() {
  const char* const domain = std::getenv("ROS_DOMAIN_ID");
  return domain == nullptr ? 0 : static_cast<uint32_t>(std::atoi(domain));
}

/// A participant with its writers and readers, by names of ROS.
class Robot {
 public:
  Robot() {
    participant_ = fast::DomainParticipantFactory::get_instance()->create_participant(DomainOfRobot(),
                                                                                      fast::PARTICIPANT_QOS_DEFAULT);
    publisher_ = participant_->create_publisher(fast::PUBLISHER_QOS_DEFAULT);
    subscriber_ = participant_->create_subscriber(fast::SUBSCRIBER_QOS_DEFAULT);
  }

  template <class Type>
  fast::Topic* Topic(const std::string& name) {
    fast::TypeSupport type(new Type());
    type.register_type(participant_);
    // A topic may have a reader and a writer.
    auto* const known = dynamic_cast<fast::Topic*>(participant_->lookup_topicdescription("rt" + name));
    if (known != nullptr) return known;
    return participant_->create_topic("rt" + name, type.get_type_name(), fast::TOPIC_QOS_DEFAULT);
  }
  bool is_synchronous = false;

  template <class Type>
  fast::DataWriter* Writer(const std::string& name, bool is_reliable) {
    fast::DataWriterQos qos = fast::DATAWRITER_QOS_DEFAULT;
    qos.reliability().kind = is_reliable ? fast::RELIABLE_RELIABILITY_QOS : fast::BEST_EFFORT_RELIABILITY_QOS;
    qos.history().depth = 5;
    qos.publish_mode().kind = is_synchronous ? fast::SYNCHRONOUS_PUBLISH_MODE : fast::ASYNCHRONOUS_PUBLISH_MODE;
    return publisher_->create_datawriter(Topic<Type>(name), qos);
  }
  /// Returns a writer of samples that come in bursts.
  template <class Type>
  fast::DataWriter* FastWriter(const std::string& name) {
    fast::DataWriterQos qos = fast::DATAWRITER_QOS_DEFAULT;
    qos.reliability().kind = fast::RELIABLE_RELIABILITY_QOS;
    qos.history().depth = 500;
    qos.publish_mode().kind = fast::SYNCHRONOUS_PUBLISH_MODE;
    return publisher_->create_datawriter(Topic<Type>(name), qos);
  }
  template <class Type>
  fast::DataWriter* LatchedWriter(const std::string& name) {
    fast::DataWriterQos qos = fast::DATAWRITER_QOS_DEFAULT;
    qos.reliability().kind = fast::RELIABLE_RELIABILITY_QOS;
    qos.durability().kind = fast::TRANSIENT_LOCAL_DURABILITY_QOS;
    return publisher_->create_datawriter(Topic<Type>(name), qos);
  }
  template <class Type>
  fast::DataReader* Reader(const std::string& name, bool is_latched) {
    fast::DataReaderQos qos = fast::DATAREADER_QOS_DEFAULT;
    qos.reliability().kind = fast::RELIABLE_RELIABILITY_QOS;
    qos.history().depth = 200;
    if (is_latched) qos.durability().kind = fast::TRANSIENT_LOCAL_DURABILITY_QOS;
    return subscriber_->create_datareader(Topic<Type>(name), qos);
  }

 private:
  fast::DomainParticipant* participant_ = nullptr;
  fast::Publisher* publisher_ = nullptr;
  fast::Subscriber* subscriber_ = nullptr;
};

}  // namespace plslam::test
