// SPDX-License-Identifier: BSD-3-Clause
#include "core/process/order_sender.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "core/bus/run_loop.h"
#include "core/bus/transport/transport.h"
#include "core/process/order.h"
#include "core/run/process_names.h"
#include "plslam/command_answer_t.hpp"
#include "plslam/command_t.hpp"
#include "plslam/status_t.hpp"

namespace plslam::bus {
namespace {

constexpr std::chrono::seconds kHearLimit(10);
constexpr std::chrono::seconds kAnswerLimit(120);
/// Statuses come once a second: then none of ours was heard, and messages of others were rejected, or there are none.
constexpr double kStatusLimit_s = 1.5;

/// Whether bus.key_file is set in a process's configuration. Without a key, its messages are read unchecked.
bool HasKey(const std::string& configuration) {
  static const std::string kKey = "\n  key_file: ";
  const size_t at = configuration.find(kKey);
  return at != std::string::npos && configuration.compare(at + kKey.size(), 2, "\"\"") != 0;
}

}  // namespace

const OrderRow* FindOrder(std::string_view verb) {
  static const std::vector<OrderRow> kRows = {
      {command_verb::kSave, {process_name::kMapping}, "the map is saved in {}"},
      {command_verb::kLoad, {process_name::kMapping}, "the map of {} is loaded"},
      {command_verb::kReset, {process_name::kMapping}, "a new map was started"},
      {command_verb::kLocalise, {process_name::kMapping}, "localisation-only mode is {}"},
      {command_verb::kPause, {process_name::kPlayer, process_name::kCamera}, "paused"},
      {command_verb::kResume, {process_name::kPlayer, process_name::kCamera}, "resumed"},
  };
  const auto row = std::ranges::find_if(kRows, [verb](const OrderRow& r) { return r.verb == verb; });
  return row == kRows.end() ? nullptr : &*row;
}

std::string NoAnswerText(const std::vector<std::string>& processes, const BusOptions& options,
                         std::chrono::seconds waited) {
  return fmt::format(
      "no process '{}' was found on {} with prefix '{}' within {} s; give the --url and --prefix of the running one "
      "(without --url, plslam run uses a private bus), or start one",
      fmt::join(processes, "' or '"), EffectiveUrl(options.url), options.prefix, waited.count());
}

OrderSender::OrderSender(Bus& bus) : bus_(bus) {
  bus_.Subscribe<command_answer_t>(kCommandAnswer, [this](const command_answer_t& m) { OnAnswer(m); });
  bus_.Subscribe<status_t>(kStatus, [this](const status_t& m) { OnStatus(m); });
}

/// Whether the order is for this process.
bool OrderSender::IsFor(const std::string& process) const {
  return std::ranges::find(row_->processes, process) != row_->processes.end();
}

void OrderSender::OnStatus(const status_t& message) {
  if (row_ == nullptr || !IsFor(message.process)) return;
  if (bus_.options().key_file.empty() && HasKey(message.configuration)) needs_key_ = true;
  if (message.pid == pid_) return;
  pid_ = message.pid;
  if (message.uptime_s < NowS() - sent_s_) Publish();
}

void OrderSender::Send(const OrderRow& row, const std::string& argument) {
  row_ = &row;
  argument_ = argument;
  pid_ = 0;
  needs_key_ = false;
  answer_.reset();
  others_.clear();
  first_seq_ = n_sent_;
  Publish();
}

void OrderSender::Publish() {
  sent_s_ = NowS();
  command_t command{};
  command.target = row_->processes.size() == 1 ? row_->processes.front() : "*";
  command.verb = row_->verb;
  command.argument = argument_;
  bus_.Publish(kCommand, command);
  ++n_sent_;
}

void OrderSender::OnAnswer(const command_answer_t& message) {
  // Accepts an answer to any command of this order: one that was carried out by a process that has exited since was
  // carried out all the same.
  const bool ours = message.command_source == bus_.source().value && message.command_seq >= first_seq_ &&
                    message.command_seq < n_sent_;
  if (!ours) return;
  if (!IsFor(message.process)) {
    others_.insert(message.process);
  } else if (!answer_) {
    answer_ = message.failure;
  }
}

std::optional<OrderResult> OrderSender::Result() const {
  if (row_ == nullptr) return std::nullopt;
  if (answer_ && answer_->empty()) {
    return OrderResult{true, fmt::format(fmt::runtime(row_->done), ToSaveRequest(argument_).file)};
  }
  if (answer_) return OrderResult{false, *answer_};
  const std::string mute = WhyMute(NowS() - sent_s_);
  return mute.empty() ? std::nullopt : std::optional(OrderResult{false, mute});
}

std::string OrderSender::Waiting() const {
  if (row_ == nullptr || pid_ != 0 || answer_ || NowS() - sent_s_ < kStatusLimit_s) return "";
  return fmt::format(
      "waiting up to {} s for a process '{}' on {} with prefix '{}'; if it runs elsewhere, give its --url and "
      "--prefix",
      kHearLimit.count(), fmt::join(row_->processes, "' or '"), EffectiveUrl(bus_.options().url),
      bus_.options().prefix);
}

/// Returns the reason why no answer is expected any more; empty: it may still arrive.
std::string OrderSender::WhyMute(double passed_s) const {
  static constexpr const char* kGiveKey =
      "this system uses {}bus.key_file: give the same file (--set bus.key_file=FILE)";
  const bool heard = pid_ != 0;
  if (needs_key_) return fmt::format(kGiveKey, "");
  if (heard) {
    return passed_s < static_cast<double>(kAnswerLimit.count())
               ? ""
               : fmt::format("no answer was received within {} s", kAnswerLimit.count());
  }
  const std::string problems = bus_.Problems();
  const bool is_rejected = passed_s > kStatusLimit_s && !problems.empty();
  if (!is_rejected && passed_s < static_cast<double>(kHearLimit.count())) return "";
  if (bus_.hears_other_key()) return fmt::format(kGiveKey, "another ");
  const std::string mute =
      NoAnswerText(row_->processes, bus_.options(), std::chrono::seconds(static_cast<int64_t>(passed_s)));
  return problems.empty() ? mute : fmt::format("{} ({})", mute, problems);
}

}  // namespace plslam::bus
