// SPDX-License-Identifier: BSD-3-Clause
// Mutates what viewers send to `plslam bridge`: it is answered, within a bound of memory, whatever it is.
#include <gtest/gtest.h>

#include <chrono>
#include <string>

#include "tests/fuzz/dataset_mutator.h"
#include "tests/support/fuzzing.h"
#include "tools/bridge/foxglove_server.h"

namespace plslam::bridge {
namespace {

const std::string kTexts[] = {
    R"({"op": "subscribe", "subscriptions": [{"id": 0, "channelId": 1}, {"id": 1, "channelId": 4}]})",
    R"({"op": "unsubscribe", "subscriptionIds": [0, 1]})",
    R"({"op": "getParameters", "parameterNames": ["vo.features.features"], "id": "a"})",
    R"({"op": "setParameters", "parameters": [{"name": "vo.size", "value": 8}], "id": "x"})",
    R"({"op": "subscribeParameterUpdates", "parameterNames": []})"};
const std::string kRequest("\2\3\0\0\0\7\0\0\0\3\0\0\0cdr\0\1\0\0\1", 21);

TEST(FoxgloveFuzz, MutatedMessagesOfViewers) {
  int n_calls = 0, n_answers = 0;
  FoxgloveServer server("1", true, "a.plmap",
                        {.on_output = [] {}, .on_call = [&](const ServiceCall&) { ++n_calls; }});
  server.SetParameters("vo", {{"vo.size", "7"}});
  server.Open(1);
  const double seconds = test::EnvironmentNumber("PLSLAM_FUZZ_SECONDS", 2.0);
  const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
  auto seed = static_cast<uint64_t>(test::EnvironmentNumber("PLSLAM_FUZZ_SEED", 1.0));
  do {
    SCOPED_TRACE(seed);
    test::DatasetMutator mutator(seed++);
    const std::string text = mutator.Mutate(kTexts[mutator.Below(std::size(kTexts))], kTexts[0]);
    const std::string request = mutator.Mutate(kRequest, kTexts[0]);
    server.TakeText(1, text);
    server.TakeBinary(1, {reinterpret_cast<const uint8_t*>(request.data()), request.size()});
    server.Write(ros_topic::kOdom, 1, "odom");
    while (server.Next(1)) ++n_answers;
  } while (std::chrono::steady_clock::now() < end);
  EXPECT_GT(n_calls, 0);
  EXPECT_GT(n_answers, 0);
}

}  // namespace
}  // namespace plslam::bridge
