// SPDX-License-Identifier: BSD-3-Clause
#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdio>
#include <stdexcept>
#include <string>
#include <thread>

#include "core/process/process.h"
#include "plslam/command_t.hpp"

namespace {

struct TestOptions {
  int answer = 42;
};

template <class Visitor>
void VisitFields(Visitor& visit, TestOptions& o) {
  visit("answer", o.answer, plslam::Bounds{0, 100}, "a number");
}

void Say(const char* line) {
  std::puts(line);
  std::fflush(stdout);
}

/// Runs the mode on its command line; the process tests start it.
struct TestNode {
  TestNode(plslam::bus::Process& process, const plslam::Config& config, const std::string& mode) {
    TestOptions options;
    config.Read("player", options);
    process.SetConfiguration(plslam::ToYaml("player", options));
    process.SetCounter("answer", options.answer);
    if (mode == "throw-at-start") throw std::runtime_error("cannot start\nat all");
    if (mode == "finish") process.Finish(0);
    if (mode == "finish-7") process.Finish(7);
    if (mode == "hang")
      process.bus().Post([] {
        Say("hangs");
        for (volatile bool forever = true; forever;) continue;
      });
    if (mode == "throw-in-handler") process.bus().Post([] { throw std::runtime_error("a handler failed"); });
    if (mode == "throw-a-number") process.bus().Post([] { throw 5; });
    if (mode == "own-state") process.SetState("running", "because");
    slow_end = mode == "slow-end";
    process.bus().Post([] { Say("runs"); });
  }
  ~TestNode() {
    // Longer than the time between two consecutive signals.
    if (slow_end) std::this_thread::sleep_for(std::chrono::milliseconds(500));
    std::puts("node is gone");
  }
  TestNode(const TestNode&) = delete;
  TestNode& operator=(const TestNode&) = delete;

  bool slow_end = false;
};

}  // namespace

int main(int argc, char** argv) {
  std::string mode;
  plslam::bus::ProcessSpec spec;
  spec.name = "player";
  spec.description = "A process for tests.";
  spec.add_options = [&](CLI::App* app) { app->add_option("mode", mode, "what to do"); };
  spec.make_node = [&](plslam::bus::Process& process, const plslam::Config& config) {
    return std::make_shared<TestNode>(process, config, mode);
  };
  spec.waits_for = "an order";
  spec.results = {{"answer", "answers"}};
  return plslam::bus::RunProcess(argc, argv, spec);
}
