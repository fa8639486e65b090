// SPDX-License-Identifier: BSD-3-Clause
// cyclone_caller SERVICE true|false: calls a service (std_srvs/srv/SetBool) as rmw_cyclonedds does, and prints the answer
// as JSON.
#include <dds/dds.h>

#include <cstdio>
#include <nlohmann/json.hpp>
#include <string>

#include <caller_cyclone.h>

namespace {

using nlohmann::json;
using Request = std_srvs_srv_dds__SetBool_Request_;
using Response = std_srvs_srv_dds__SetBool_Response_;

constexpr int kWaits = 2000, kWaitsForAnswer = 700;  // of 10 ms
constexpr uint64_t kClient = 0x0123456789abcdefU;
constexpr int64_t kNumber = 77;

json Call(const std::string& service, bool value) {
  const dds_entity_t participant = dds_create_participant(DDS_DOMAIN_DEFAULT, nullptr, nullptr);
  dds_qos_t* const qos = dds_create_qos();
  dds_qset_reliability(qos, DDS_RELIABILITY_RELIABLE, DDS_SECS(1));
  const auto topic = [&](const dds_topic_descriptor_t& type, const std::string& name) {
    return dds_create_topic(participant, &type, name.c_str(), nullptr, nullptr);
  };
  const dds_entity_t writer = dds_create_writer(
      participant, topic(std_srvs_srv_dds__SetBool_Request__desc, "rq" + service + "Request"), qos, nullptr);
  const dds_entity_t reader = dds_create_reader(
      participant, topic(std_srvs_srv_dds__SetBool_Response__desc, "rr" + service + "Reply"), qos, nullptr);
  int i = 0;
  for (; i < kWaits; ++i, dds_sleepfor(DDS_MSECS(10))) {
    dds_publication_matched_status_t requests{};
    dds_subscription_matched_status_t replies{};
    dds_get_publication_matched_status(writer, &requests);
    dds_get_subscription_matched_status(reader, &replies);
    if (requests.current_count > 0 && replies.current_count > 0) break;
  }
  if (i == kWaits) return {{"failure", "the service is not available"}};
  dds_sleepfor(DDS_MSECS(500));  // until the server knows it, too
  const Request request{kClient, kNumber, value};
  for (i = 0; i < kWaits; ++i, dds_sleepfor(DDS_MSECS(10))) {
    // As a patient user: the answer to a client that was discovered just now may be lost.
    const bool is_due = i % kWaitsForAnswer == 0;
    if (is_due && dds_write(writer, &request) != DDS_RETCODE_OK) return {{"failure", "the request cannot be sent"}};
    void* sample = nullptr;
    dds_sample_info_t info;
    if (dds_take(reader, &sample, &info, 1, 1) <= 0 || !info.valid_data) continue;
    const auto& response = *static_cast<const Response*>(sample);
    if (response.client != kClient || response.number != kNumber) continue;
    return {{"success", response.success}, {"message", response.message}};
  }
  return {{"failure", "no answer"}};
}

}  // namespace

int main(int /*argc*/, char** argv) {
  std::printf("%s\n", Call(argv[1], std::string(argv[2]) == "true").dump().c_str());
  return 0;
}
