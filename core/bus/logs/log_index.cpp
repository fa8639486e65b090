// SPDX-License-Identifier: BSD-3-Clause
#include "core/bus/logs/log_index.h"

namespace plslam::bus {

void LoggedMessages::Add(const LogReader::Event& event) {
  const WireHeader header = ReadHeader(event.head);
  const auto known = std::find(sources_.begin(), sources_.end(), header.source);
  const auto rank = static_cast<size_t>(known - sources_.begin());
  if (known == sources_.end()) sources_.push_back(header.source);
  places_.try_emplace({rank, header.seq, header.t_ns}, LogPlace{event.data_offset, event.data_bytes});
}

const LoggedMessages& LoggedRobot::On(const Channel& channel) const {
  static const LoggedMessages kNone;
  const auto found = messages.find(channel.name);
  return found == messages.end() ? kNone : found->second;
}

std::map<std::string, LoggedRobot> IndexLog(LogReader& log, const std::vector<IndexedChannel>& channels,
                                            const std::function<void(const std::string& prefix, const IndexedChannel&,
                                                                     const LogReader::Event&, LoggedRobot&)>& visit) {
  std::map<std::string, LoggedRobot> robots;
  while (const auto event = log.Next()) {
    for (const IndexedChannel& indexed : channels) {
      const std::string_view name = indexed.channel.name;
      if (!event->channel.ends_with(name) || event->head.size() < kWireHeaderBytes) continue;
      const std::string prefix = event->channel.substr(0, event->channel.size() - name.size());
      LoggedRobot& robot = robots[prefix];
      if (ReadInt64(event->head.data()) != indexed.fingerprint) {
        robot.of_other_versions.insert(name);
      } else if (indexed.is_kept) {
        robot.messages[name].Add(*event);
      } else {
        robot.visited.insert(name);
        visit(prefix, indexed, *event, robot);
      }
    }
  }
  return robots;
}

}  // namespace plslam::bus
