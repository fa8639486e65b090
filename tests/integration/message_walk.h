// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "core/bus/transport/wire.h"
#include "lcmtypes/message_layout.h"

namespace plslam::test {

/// Returns the first member in which an encoded message of type `layout` differs from the one in a log, with both
/// values ("T_odom_c.position_m[1] is 0.25, in the log 0.5"); empty if they are the same. Members in `ignored`
/// ("stage_t.ms"; none of a string or an array's size) may differ.
std::string FirstDifference(const MessageLayout& layout, bus::ByteView message, bus::ByteView logged,
                            const std::set<std::string>& ignored = {});

/// Replaces numbers of 64 bits wherever they are in an encoded message: the random names of processes in a log by the
/// names of those that play them.
void Rename(const MessageLayout& layout, const std::map<int64_t, int64_t>& names, std::vector<uint8_t>* message);

}  // namespace plslam::test
