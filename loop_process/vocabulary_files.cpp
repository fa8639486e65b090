// SPDX-License-Identifier: BSD-3-Clause
#include "loop_process/vocabulary_files.h"

#include "core/io/files/shared_file.h"

namespace plslam {

PlaceRecogniser LoadPlaces(const VocabularyOptions& files, const PlaceOptions& options) {
  return {Vocabulary::Load(FindSharedFile(files.points)), Vocabulary::Load(FindSharedFile(files.lines)), options};
}

}  // namespace plslam
