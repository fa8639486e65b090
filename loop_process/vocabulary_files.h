// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "core/places/place_recogniser.h"
#include "loop_process/options.h"

namespace plslam {

/// A recogniser without places; `FindSharedFile` finds its vocabularies. Throws std::runtime_error with one sentence
/// where one cannot be read.
PlaceRecogniser LoadPlaces(const VocabularyOptions& files, const PlaceOptions& options);

}  // namespace plslam
