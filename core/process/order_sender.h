// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "core/bus/bus.h"

namespace plslam {
class command_answer_t;
class status_t;
}  // namespace plslam

namespace plslam::bus {

/// An order that users give, on the command line or on the live page.
struct OrderRow {
  const char* verb;                    ///< as in `command_verb`
  std::vector<std::string> processes;  ///< candidates, of which one is running
  const char* done;                    ///< sentence for success; {}: the argument
};

/// Returns the row of a verb of users ("save", "load", "reset", "localise", "pause", "resume"); nullptr: there is none.
const OrderRow* FindOrder(std::string_view verb);

/// Result of an order as a sentence for users.
struct OrderResult {
  bool done = false;
  std::string sentence;  ///< "paused", or the reason of the failure
};

/// Returns the sentence for a bus on which none of these processes ("mapping") was heard for this time.
std::string NoAnswerText(const std::vector<std::string>& processes, const BusOptions& options,
                         std::chrono::seconds waited);

/// Sends orders to running processes, one after the other, and receives their results. A process that is started after
/// an order was sent, and before it was answered, gets it again: an order may be carried out twice.
class OrderSender {
 public:
  /// Subscribes; `Bus::Run` delivers.
  explicit OrderSender(Bus& bus);

  /// Sends an order, and forgets the previous one. On the thread of the bus, or before that runs.
  void Send(const OrderRow& row, const std::string& argument);
  bool has_sent() const { return row_ != nullptr; }

  /// The answer to the order: nullopt until it arrives, empty after success, else the reason of the failure.
  const std::optional<std::string>& answer() const { return answer_; }
  /// Whether a process that acts on the order after the one that it is for has answered, too.
  bool HasAnswered(const std::string& process) const { return others_.contains(process); }
  /// Returns the answer as a sentence, or the reason why there will be none; nullopt: wait and call again. The reasons
  /// are a missing process (after 10 s), a missing key, and no answer within 120 s.
  std::optional<OrderResult> Result() const;
  /// Returns the sentence for a user who waits, from 1.5 s on while no process that could answer was heard; else empty.
  std::string Waiting() const;

 private:
  void OnStatus(const status_t& message);
  void OnAnswer(const command_answer_t& message);
  bool IsFor(const std::string& process) const;
  void Publish();
  std::string WhyMute(double passed_s) const;

  Bus& bus_;
  const OrderRow* row_ = nullptr;  ///< of the order that has been sent
  std::string argument_;
  double sent_s_ = 0.0;     ///< when, of the steady clock
  int64_t pid_ = 0;         ///< of the process that was heard last since then
  bool needs_key_ = false;  ///< it accepts messages with a key only, and this one has none
  int64_t n_sent_ = 0;      ///< commands, of all orders
  int64_t first_seq_ = 0;   ///< number of the first command of this order
  std::optional<std::string> answer_;
  std::set<std::string> others_;  ///< other processes that have answered
};

}  // namespace plslam::bus
