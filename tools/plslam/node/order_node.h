// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/bus/bus.h"

namespace plslam {
class command_answer_t;
class status_t;
}  // namespace plslam

namespace plslam::launcher {

/// Returns the sentence for a bus on which none of these processes ("mapping") was heard for this time.
std::string NoAnswerText(const std::vector<std::string>& processes, const bus::BusOptions& options,
                         std::chrono::seconds waited);

/// Sends an order to a running process, and receives the result. A process that is started after the order was sent,
/// and before it was answered, gets it again: an order may be carried out twice.
class OrderNode {
 public:
  /// Subscribes; `Bus::Run` delivers. `processes`: names, of which one is running; `verb` as in `command_verb`.
  OrderNode(bus::Bus& bus, std::vector<std::string> processes, std::string verb);

  /// The order, the first time that it is called. On the thread of the bus, or before that runs.
  void Send(const std::string& argument);

  bool heard() const { return pid_ != 0; }
  /// Whether the process that was heard accepts messages with a key only, and this one has none.
  bool needs_key() const { return needs_key_; }
  /// nullopt: no answer yet; empty: done; else the reason of the failure.
  const std::optional<std::string>& answer() const { return answer_; }

 private:
  void OnStatus(const status_t& message);
  void OnAnswer(const command_answer_t& message);
  void Publish();

  bus::Bus& bus_;
  const std::vector<std::string> processes_;
  const std::string verb_;
  std::optional<std::string> argument_;  ///< it has been sent
  double sent_s_ = 0.0;                  ///< when, of the steady clock
  int64_t pid_ = 0;                      ///< of the process that was heard last
  bool needs_key_ = false;
  int64_t n_sent_ = 0;  ///< times it was sent
  std::optional<std::string> answer_;
};

}  // namespace plslam::launcher
