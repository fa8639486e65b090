// SPDX-License-Identifier: BSD-3-Clause
#include "ros2/graph/ros_node.h"

#include <algorithm>
#include <chrono>
#include <cstring>
#include <deque>
#include <iterator>
#include <map>
#include <mutex>
#include <stdexcept>
#include <string_view>
#include <utility>

#include <fastdds/rtps/transport/UDPv4TransportDescriptor.h>
#include <fmt/format.h>
#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/DataWriterListener.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/DataReaderListener.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <fastdds/dds/topic/TopicDataType.hpp>
#include <fastdds/dds/topic/TypeSupport.hpp>

#include "ros2/graph/service_message.h"
#include "ros2/names.h"

namespace plslam::ros2 {
namespace {

namespace dds = eprosima::fastdds::dds;
namespace rtps = eprosima::fastrtps::rtps;
using Clock = std::chrono::steady_clock;

/// Calls and answers that wait, as services of ROS have by default.
constexpr size_t kDepth = 10;
/// Answers wait for so long after the discovery of the client's reader: readers of Cyclone DDS ignore what a writer sends
/// before its first heartbeat, and ask for one only once in a while.
constexpr std::chrono::milliseconds kSettling{1000};
/// Larger messages are not accepted: the encoding, the numbers of rmw_cyclonedds, and the content.
constexpr uint32_t kMostRequestBytes = 64, kMostReplyBytes = 64 + kLongestSentence;

constexpr const char* kInfoType = "rmw_dds_common::msg::dds_::ParticipantEntitiesInfo_";
constexpr uint32_t kMostInfoBytes = 4096;

/// Messages in CDR as they are, as a std::string.
class CdrType : public dds::TopicDataType {
 public:
  CdrType(const std::string& name, uint32_t most_bytes) {
    setName(name.c_str());
    m_typeSize = most_bytes;
    m_isGetKeyDefined = false;
    auto_fill_type_object(false);
    auto_fill_type_information(false);
  }
  bool serialize(void* data, rtps::SerializedPayload_t* payload) override {
    const std::string& cdr = *static_cast<std::string*>(data);
    if (cdr.size() > payload->max_size) return false;
    std::memcpy(payload->data, cdr.data(), cdr.size());
    payload->length = static_cast<uint32_t>(cdr.size());
    payload->encapsulation = CDR_LE;
    return true;
  }
  bool deserialize(rtps::SerializedPayload_t* payload, void* data) override {
    static_cast<std::string*>(data)->assign(reinterpret_cast<const char*>(payload->data), payload->length);
    return true;
  }
  std::function<uint32_t()> getSerializedSizeProvider(void* data) override {
    return [data] { return static_cast<uint32_t>(static_cast<std::string*>(data)->size()); };
  }
  void* createData() override { return new std::string(); }
  void deleteData(void* data) override { delete static_cast<std::string*>(data); }
  bool getKey(void* /*data*/, rtps::InstanceHandle_t* /*handle*/, bool /*force_md5*/) override { return false; }
};

/// Returns the entity, or throws with what failed.
template <class Entity>
Entity* Checked(Entity* entity, const std::string& what) {
  if (entity == nullptr) throw std::runtime_error(fmt::format("{} cannot be made by Fast DDS", what));
  return entity;
}

template <class Qos>
Qos Reliable(Qos qos) {
  qos.reliability().kind = dds::RELIABLE_RELIABILITY_QOS;
  qos.durability().kind = dds::VOLATILE_DURABILITY_QOS;
  qos.history().kind = dds::KEEP_LAST_HISTORY_QOS;
  qos.history().depth = static_cast<int32_t>(kDepth);
  qos.data_sharing().off();
  return qos;
}

/// Over UDP alone: shared memory fails between users and containers, and requests are small.
dds::DomainParticipantQos ParticipantQos(const Domain& domain) {
  dds::DomainParticipantQos qos = dds::PARTICIPANT_QOS_DEFAULT;
  qos.name("plslam_ros2");
  constexpr std::string_view kEnclave = "enclave=/;";
  qos.user_data().setValue({kEnclave.begin(), kEnclave.end()});
  qos.transport().use_builtin_transports = false;
  const auto udp = std::make_shared<eprosima::fastdds::rtps::UDPv4TransportDescriptor>();
  if (domain.loopback_only) udp->interfaceWhiteList.emplace_back("127.0.0.1");
  qos.transport().user_transports.push_back(udp);
  return qos;
}

Guid ToGuid(const rtps::GUID_t& guid) {
  Guid bytes{};
  std::copy_n(guid.guidPrefix.value, rtps::GuidPrefix_t::size, bytes.begin());
  std::copy_n(guid.entityId.value, rtps::EntityId_t::size, bytes.begin() + rtps::GuidPrefix_t::size);
  return bytes;
}

}  // namespace

struct RosNode::Impl {
  /// The two endpoints of a service.
  struct Endpoints : dds::DataReaderListener, dds::DataWriterListener {
    struct Reply {
      rtps::SampleIdentity client;
      std::string cdr;
    };

    Endpoints(const Impl& of, size_t of_index, std::string of_name)
        : impl(of), index(of_index), name(std::move(of_name)) {}

    void on_data_available(dds::DataReader* from) override {
      std::string cdr;
      dds::SampleInfo info;
      while (from->take_next_sample(&cdr, &info) == ReturnCode_t::RETCODE_OK) {
        if (info.valid_data) Take(cdr, info);
      }
    }

    void Take(const std::string& cdr, const dds::SampleInfo& info) {
      ServiceRequest request;
      try {
        request = ParseServiceRequest({reinterpret_cast<const uint8_t*>(cdr.data()), cdr.size()});
      } catch (const std::runtime_error& error) {
        return impl.listener.on_rejected(name, error.what());
      }
      // Clients of rmw_fastrtps name the reader of their answers; otherwise, the writer of the request is its client.
      rtps::SampleIdentity client = info.sample_identity;
      const rtps::GUID_t& named = info.related_sample_identity.writer_guid();
      if (named != rtps::GUID_t::unknown()) client.writer_guid(named);
      impl.listener.on_call(index, request.body, [this, client, request](bool done, const std::string& sentence) {
        Keep({client, ServiceReply(request, done, sentence)});
      });
    }

    void Keep(Reply reply) {
      const std::scoped_lock lock(mutex);
      if (waiting.size() >= kDepth) waiting.pop_front();
      waiting.push_back(std::move(reply));
    }

    /// Sends the answers to clients whose reader was discovered `kSettling` ago.
    void SendAnswers() {
      std::deque<Reply> due;
      {
        const std::scoped_lock lock(mutex);
        const auto is_due = [&, now = Clock::now()](const Reply& reply) {
          const auto found = matched.find(reply.client.writer_guid().guidPrefix);
          return found != matched.end() && now - found->second >= kSettling;
        };
        std::copy_if(waiting.begin(), waiting.end(), std::back_inserter(due), is_due);
        std::erase_if(waiting, is_due);
      }
      for (Reply& reply : due) Write(reply);
    }

    void on_publication_matched(dds::DataWriter* /*writer*/, const dds::PublicationMatchedStatus& status) override {
      const rtps::GuidPrefix_t client = iHandle2GUID(status.last_subscription_handle).guidPrefix;
      const std::scoped_lock lock(mutex);
      if (status.current_count_change > 0) {
        matched.emplace(client, Clock::now());
      } else {
        matched.erase(client);
      }
    }

    void Write(Reply& reply) const {
      rtps::WriteParams parameters;
      parameters.related_sample_identity(reply.client);
      writer->write(&reply.cdr, parameters);
    }

    const Impl& impl;
    const size_t index;
    const std::string name;
    dds::DataWriter* writer = nullptr;
    dds::DataReader* reader = nullptr;
    std::mutex mutex;
    std::map<rtps::GuidPrefix_t, Clock::time_point> matched;  ///< when readers of answers were discovered, by client
    std::deque<Reply> waiting;
  };

  explicit Impl(Listener of) : listener(std::move(of)) {}
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;
  ~Impl() {
    if (participant == nullptr) return;
    participant->delete_contained_entities();
    dds::DomainParticipantFactory::get_instance()->delete_participant(participant);
  }

  dds::Topic* Topic(const std::string& name, const std::string& type, uint32_t most_bytes) const {
    const dds::TypeSupport support(new CdrType(type, most_bytes));
    support.register_type(participant);
    return Checked(participant->create_topic(name, type, dds::TOPIC_QOS_DEFAULT), name);
  }

  const Listener listener;
  dds::DomainParticipant* participant = nullptr;
  std::vector<std::unique_ptr<Endpoints>> services;
  dds::DataWriter* info_writer = nullptr;
  std::string announced;
};

RosNode::RosNode(const Domain& domain, const std::vector<Service>& services, Listener listener)
    : impl_(std::make_unique<Impl>(std::move(listener))) {
  impl_->participant = Checked(dds::DomainParticipantFactory::get_instance()->create_participant(
                                   static_cast<uint32_t>(domain.id), ParticipantQos(domain)),
                               fmt::format("the participant of services in the domain {}", domain.id));
  dds::Publisher* const publisher =
      Checked(impl_->participant->create_publisher(dds::PUBLISHER_QOS_DEFAULT), "a publisher");
  dds::Subscriber* const subscriber =
      Checked(impl_->participant->create_subscriber(dds::SUBSCRIBER_QOS_DEFAULT), "a subscriber");
  dds::DataWriterQos latched = Reliable(dds::DATAWRITER_QOS_DEFAULT);
  latched.durability().kind = dds::TRANSIENT_LOCAL_DURABILITY_QOS;
  latched.history().depth = 1;
  impl_->info_writer = Checked(
      publisher->create_datawriter(impl_->Topic(kNodeInfoTopic, kInfoType, kMostInfoBytes), latched), kNodeInfoTopic);
  for (const Service& service : services) {
    auto& one = *impl_->services.emplace_back(
        std::make_unique<Impl::Endpoints>(*impl_, impl_->services.size(), service.name));
    const ServiceNames names = DdsServiceNames(service.name, service.type);
    one.writer = Checked(publisher->create_datawriter(impl_->Topic(names.reply, names.reply_type, kMostReplyBytes),
                                                      Reliable(dds::DATAWRITER_QOS_DEFAULT), &one,
                                                      dds::StatusMask::publication_matched()),
                         names.reply);
    one.reader = Checked(
        subscriber->create_datareader(impl_->Topic(names.request, names.request_type, kMostRequestBytes),
                                      Reliable(dds::DATAREADER_QOS_DEFAULT), &one, dds::StatusMask::data_available()),
        names.request);
  }
}

RosNode::~RosNode() = default;

Guid RosNode::id() const { return ToGuid(impl_->participant->guid()); }

void RosNode::SendAnswers() {
  for (const auto& one : impl_->services) one->SendAnswers();
}

void RosNode::Announce(NodeInfo node, size_t gid_bytes) {
  node.participant = id();
  for (const auto& one : impl_->services) {
    node.readers.push_back(ToGuid(one->reader->guid()));
    node.writers.push_back(ToGuid(one->writer->guid()));
  }
  std::string message = NodeInfoMessage(node, gid_bytes);
  if (message == impl_->announced) return;
  impl_->info_writer->write(&message);
  impl_->announced = std::move(message);
}

}  // namespace plslam::ros2
