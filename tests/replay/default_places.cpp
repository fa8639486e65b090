#include "tests/replay/default_places.h"

#include "tests/support/data_folder.h"

namespace plslam::test {

PlaceRecogniser DefaultPlaces() {
  const auto config = SourceFolder() / "config";
  return {Vocabulary::Load((config / "orb.vocabulary").string()),
          Vocabulary::Load((config / "lbd.vocabulary").string()), PlaceOptions()};
}

}  // namespace plslam::test
