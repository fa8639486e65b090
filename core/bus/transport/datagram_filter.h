// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <set>
#include <string>

namespace plslam::bus {

/// Larger datagrams (bytes, with UDP header and LCM's head) are filtered by their channel: strips of images, pages of
/// keyframes and maps.
inline constexpr size_t kUnfilteredBytes = 16'384;

/// Has the kernel drop large LCM packets of channels other than `names` before they take room in the buffer of the
/// UDP socket `fd` and wake its reader (classic BPF, which needs no privileges: socket(7), SO_ATTACH_FILTER). Images
/// that only the tracker reads then cost the other processes nothing. Parts of longer messages, and what is no LCM
/// packet, come as before. Takes the place of the filter before; where the kernel refuses, everything comes.
void FilterLargeDatagrams(int fd, const std::set<std::string, std::less<>>& names);

/// Everything comes again.
void RemoveDatagramFilter(int fd);

}  // namespace plslam::bus
