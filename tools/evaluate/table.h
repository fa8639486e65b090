// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "tools/evaluate/accuracy.h"

namespace plslam {

/// The numbers of an evaluation as aligned lines for a terminal; "-" where there was nothing to measure.
std::string AccuracyTable(const Accuracy& accuracy);

}  // namespace plslam
