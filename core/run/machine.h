// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace plslam {

/// "2 cores of AMD EPYC": the machine of this process, so that a reader can compare its times with others. Without a
/// model in /proc/cpuinfo (ARM): "4 cores".
std::string MachineText();

}  // namespace plslam
