// SPDX-License-Identifier: BSD-3-Clause
#include "ros2/dds/list_topics.h"

#include <chrono>
#include <cstdlib>
#include <exception>
#include <map>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include <fmt/format.h>

#include "core/errors/standard_streams.h"
#include "ros2/dds/participant.h"
#include "ros2/topic_list.h"

namespace plslam::ros2 {
namespace {

using std::chrono::steady_clock;
constexpr std::chrono::milliseconds kDiscovery{2000};
constexpr std::chrono::milliseconds kListening{2000};
constexpr std::chrono::milliseconds kWait{50};

void Print() {
  const Domain domain = DomainOf([](const char* name) { return std::getenv(name); });
  const char* const uri = std::getenv("CYCLONEDDS_URI");
  Participant participant(domain, CycloneConfiguration(domain, uri == nullptr ? "" : uri));
  std::this_thread::sleep_for(kDiscovery);
  std::map<std::string, HeardImages> heard;
  for (const Publisher& publisher : participant.Publishers()) {
    if (!IsImageType(publisher.type) || heard.contains(publisher.topic)) continue;
    HeardImages& images = heard[publisher.topic];
    participant.ReadImages(publisher.topic, publisher.type.ends_with("CompressedImage"),
                           [&images](const robot::ForeignImage& image) {
                             ++images.n;
                             images.bytes += static_cast<int64_t>(image.bytes.size());
                             images.encoding = image.encoding;
                             images.width_px = image.width_px;
                             images.height_px = image.height_px;
                           });
  }
  const auto end = steady_clock::now() + kListening;
  while (steady_clock::now() < end) participant.Receive(kWait, [](const std::string&, const std::string&) {});
  const std::vector<Publisher> publishers = participant.Publishers();
  Symptoms none;
  none.domain = domain.id;
  if (publishers.empty()) throw std::runtime_error(WhyNoFrames(none));
  fmt::print("{}", TopicTable(publishers, heard, std::chrono::duration<double>(kListening).count(), domain.id));
}

}  // namespace

int ListTopics() {
  try {
    Print();
    return FlushOutput("plslam topics", 0);
  } catch (const std::exception& error) {
    PrintError(fmt::format("plslam: error: {}", error.what()));
    return 1;
  }
}

}  // namespace plslam::ros2
