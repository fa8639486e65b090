#pragma once

#include <string>

#include "core/places/place_recogniser.h"
#include "loop_process/options.h"

namespace plslam {

/// Where a file that comes with the programs is: `name` as it stands if there is such a file, else in `share/plslam` beside
/// the folder of the running program. Returns `name` where there is neither.
std::string FindSharedFile(const std::string& name);

/// A recogniser without places. Throws std::runtime_error with one sentence where a vocabulary cannot be read.
PlaceRecogniser LoadPlaces(const VocabularyOptions& files, const PlaceOptions& options);

}  // namespace plslam
