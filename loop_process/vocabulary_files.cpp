#include "loop_process/vocabulary_files.h"

#include <filesystem>

namespace plslam {

std::string FindSharedFile(const std::string& name) {
  namespace fs = std::filesystem;
  std::error_code error;
  if (fs::exists(name, error)) return name;
  const fs::path program = fs::read_symlink("/proc/self/exe", error);
  const fs::path shared = program.parent_path().parent_path() / "share" / "plslam" / name;
  return fs::exists(shared, error) ? shared.string() : name;
}

PlaceRecogniser LoadPlaces(const VocabularyOptions& files, const PlaceOptions& options) {
  return {Vocabulary::Load(FindSharedFile(files.points)), Vocabulary::Load(FindSharedFile(files.lines)), options};
}

}  // namespace plslam
