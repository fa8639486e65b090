#pragma once

#include "core/places/place_recogniser.h"

namespace plslam::test {

/// Nothing seen yet, the vocabularies that come with the programs.
PlaceRecogniser DefaultPlaces();

}  // namespace plslam::test
