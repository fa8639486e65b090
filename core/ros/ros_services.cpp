// SPDX-License-Identifier: BSD-3-Clause
#include "core/ros/ros_services.h"

#include <array>
#include <stdexcept>

#include <fmt/format.h>

#include "core/run/process_names.h"

namespace plslam {

std::span<const RosService> RosServices() {
  static constexpr auto kServices = std::to_array<RosService>({
      {"save", command_verb::kSave, nullptr, true},
      {"load", command_verb::kLoad, nullptr, true},
      {"reset", command_verb::kReset, nullptr},
      {"pause", command_verb::kPause, command_verb::kResume},
      {"localise_only", command_verb::kLocalise, command_verb::kLocalise, false, true},
  });
  return kServices;
}

ServiceOrder OrderOf(const RosService& service, std::span<const uint8_t> request, const std::string& map_file,
                     std::string_view process) {
  ServiceOrder order{service.verb, ""};
  if (service.is_switch()) {
    if (request.empty()) throw std::runtime_error("the request has no data");
    const bool is_on = request[0] != 0;
    if (!is_on) order.verb = service.verb_of_off;
    if (service.has_on_off) order.argument = is_on ? localise_mode::kOn : localise_mode::kOff;
  }
  if (service.has_file) {
    if (map_file.empty()) {
      throw std::runtime_error(fmt::format("{} has no file: start {} with --map-file FILE", service.name, process));
    }
    order.argument = map_file;
  }
  return order;
}

}  // namespace plslam
