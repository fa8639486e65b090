// SPDX-License-Identifier: BSD-3-Clause
// fast_dds_caller call SERVICE [true|false]: calls a service (std_srvs/srv/SetBool with a value, otherwise Trigger) as
// rmw_fastrtps does, and prints the answer as JSON. fast_dds_caller nodes OLD: introduces itself as a node of ROS 2 (OLD
// 1: of a release before Iron), and prints what another node says of itself, with the topics of its writers.
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <functional>
#include <string>

#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <fastdds/dds/topic/TypeSupport.hpp>
#include <nlohmann/json.hpp>

#include <callerPubSubTypes.h>
#include "tests/ros2/raw_messages.h"

namespace {

namespace fast = eprosima::fastdds::dds;
namespace test = plslam::test;
namespace rtps = eprosima::fastrtps::rtps;
using nlohmann::json;

constexpr int kWaits = 2000;  // of 10 ms

bool WaitFor(const std::function<bool()>& holds) {
  for (int i = 0; i < kWaits; ++i) {
    if (holds()) return true;
    usleep(10'000);
  }
  return false;
}

struct Endpoints {
  fast::DataWriter* writer = nullptr;
  fast::DataReader* reader = nullptr;
};

fast::DomainParticipant* Participant() {
  return fast::DomainParticipantFactory::get_instance()->create_participant(0, fast::PARTICIPANT_QOS_DEFAULT);
}

template <class Request, class Response>
json Call(const std::string& service, const std::string& type, void* request) {
  fast::DomainParticipant* const participant = Participant();
  const fast::TypeSupport request_type(new Request()), response_type(new Response());
  request_type.register_type(participant, type + "_Request_");
  response_type.register_type(participant, type + "_Response_");
  fast::DataWriterQos writer_qos = fast::DATAWRITER_QOS_DEFAULT;
  writer_qos.reliability().kind = fast::RELIABLE_RELIABILITY_QOS;
  fast::DataReaderQos reader_qos = fast::DATAREADER_QOS_DEFAULT;
  reader_qos.reliability().kind = fast::RELIABLE_RELIABILITY_QOS;
  auto* const writer = participant->create_publisher(fast::PUBLISHER_QOS_DEFAULT)
                           ->create_datawriter(participant->create_topic("rq" + service + "Request",
                                                                         type + "_Request_", fast::TOPIC_QOS_DEFAULT),
                                               writer_qos);
  auto* const reader =
      participant->create_subscriber(fast::SUBSCRIBER_QOS_DEFAULT)
          ->create_datareader(
              participant->create_topic("rr" + service + "Reply", type + "_Response_", fast::TOPIC_QOS_DEFAULT),
              reader_qos);
  const auto is_matched = [&] {
    fast::PublicationMatchedStatus requests;
    fast::SubscriptionMatchedStatus replies;
    writer->get_publication_matched_status(requests);
    reader->get_subscription_matched_status(replies);
    return requests.current_count > 0 && replies.current_count > 0;
  };
  if (!WaitFor(is_matched)) return {{"failure", "the service is not available"}};
  usleep(500'000);  // until the server knows it, too
  rtps::WriteParams parameters;
  parameters.related_sample_identity().writer_guid(reader->guid());
  if (!writer->write(request, parameters)) return {{"failure", "the request cannot be sent"}};
  const rtps::SequenceNumber_t number = parameters.sample_identity().sequence_number();
  typename Response::type response;
  const auto is_answered = [&] {
    fast::SampleInfo info;
    while (reader->take_next_sample(&response, &info) == ReturnCode_t::RETCODE_OK) {
      const rtps::SampleIdentity& to = info.related_sample_identity;
      const bool is_ours = to.writer_guid() == reader->guid() || to.writer_guid() == writer->guid();
      if (info.valid_data && is_ours && to.sequence_number() == number) return true;
    }
    return false;
  };
  if (!WaitFor(is_answered)) return {{"failure", "no answer"}};
  return {{"success", response.success()}, {"message", response.message()}};
}

template <class Type>
json Nodes(const char* user_data) {
  constexpr const char* kType = "rmw_dds_common::msg::dds_::ParticipantEntitiesInfo_";
  fast::DomainParticipant* const participant = Participant();
  const fast::TypeSupport type(new Type());
  type.register_type(participant, kType);
  fast::Topic* const topic = participant->create_topic("ros_discovery_info", kType, fast::TOPIC_QOS_DEFAULT);
  fast::DataWriterQos writer_qos = fast::DATAWRITER_QOS_DEFAULT;
  writer_qos.durability().kind = fast::TRANSIENT_LOCAL_DURABILITY_QOS;
  const std::string text = user_data;
  writer_qos.user_data().setValue({text.begin(), text.end()});
  fast::DataReaderQos reader_qos = fast::DATAREADER_QOS_DEFAULT;
  reader_qos.durability().kind = fast::TRANSIENT_LOCAL_DURABILITY_QOS;
  reader_qos.reliability().kind = fast::RELIABLE_RELIABILITY_QOS;
  participant->create_publisher(fast::PUBLISHER_QOS_DEFAULT)->create_datawriter(topic, writer_qos);
  auto* const reader =
      participant->create_subscriber(fast::SUBSCRIBER_QOS_DEFAULT)->create_datareader(topic, reader_qos);
  typename Type::type message;
  test::Census census("nothing");
  bool is_heard = false;
  // A node is announced again when it has another topic.
  const auto has_topic = [&] {
    fast::SampleInfo info;
    while (reader->take_next_sample(&message, &info) == ReturnCode_t::RETCODE_OK) is_heard |= info.valid_data;
    census.Listen();
    for (const auto& node : message.node_entities_info_seq()) {
      for (const auto& gid : node.writer_gid_seq()) {
        if (census.TopicOf(test::HexOf(gid.data())).rfind("rt/", 0) == 0) return true;
      }
    }
    return false;
  };
  WaitFor(has_topic);
  if (!is_heard) return {{"failure", "no node"}};
  const auto& nodes = message.node_entities_info_seq();
  json heard{{"gid", test::HexOf(message.gid().data())}, {"nodes", json::array()}};
  for (const auto& node : nodes) {
    json one{{"name", node.node_name()}, {"namespace", node.node_namespace()}};
    for (const auto& gid : node.reader_gid_seq()) one["readers"].push_back(test::HexOf(gid.data()));
    for (const auto& gid : node.writer_gid_seq()) one["writers"].push_back(census.TopicOf(test::HexOf(gid.data())));
    heard["nodes"].push_back(one);
  }
  return heard;
}

}  // namespace

int main(int argc, char** argv) {
  namespace srv = std_srvs::srv::dds_;
  const std::string order = argv[1], argument = argv[2];
  json heard;
  if (order == "nodes" && argument == "1") {
    heard = Nodes<old::ParticipantEntitiesInfo_PubSubType>("");
  } else if (order == "nodes") {
    heard = Nodes<rmw_dds_common::msg::dds_::ParticipantEntitiesInfo_PubSubType>("typehash=RIHS01_00;");
  } else if (argc > 3) {
    srv::SetBool_Request_ request;
    request.data(std::string(argv[3]) == "true");
    heard = Call<srv::SetBool_Request_PubSubType, srv::SetBool_Response_PubSubType>(
        argument, "std_srvs::srv::dds_::SetBool", &request);
  } else {
    srv::Trigger_Request_ request;
    heard = Call<srv::Trigger_Request_PubSubType, srv::Trigger_Response_PubSubType>(
        argument, "std_srvs::srv::dds_::Trigger", &request);
  }
  std::printf("%s\n", heard.dump().c_str());
  std::fflush(stdout);
  std::_Exit(0);  // destructors of Fast DDS wait for seconds
}
