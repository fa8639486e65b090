// SPDX-License-Identifier: BSD-3-Clause
#include "ros2/graph/node_info.h"

#include <utility>

#include "core/ros/cdr_writer.h"

namespace plslam::ros2 {

std::string NodeInfoMessage(const NodeInfo& info, size_t gid_bytes) {
  CdrWriter cdr;
  const auto put = [&](const Guid& guid) {
    for (size_t i = 0; i < gid_bytes; ++i) cdr.Put(i < guid.size() ? guid[i] : uint8_t{0});
  };
  const auto put_all = [&](const std::vector<Guid>& guids) {
    cdr.PutCount(guids.size());
    for (const Guid& guid : guids) put(guid);
  };
  put(info.participant);
  cdr.PutCount(1);
  cdr.Put(std::string_view(info.space));
  cdr.Put(std::string_view(info.name));
  put_all(info.readers);
  put_all(info.writers);
  return std::move(cdr).Take();
}

}  // namespace plslam::ros2
