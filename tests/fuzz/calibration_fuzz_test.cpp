// SPDX-License-Identifier: BSD-3-Clause
// Mutates the calibrations of other programs: a reader gives a rig that can be used, or throws DatasetError.
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <string>
#include <vector>

#include "core/datasets/calibrations/foreign_calibration.h"
#include "core/datasets/check_rig.h"
#include "core/files/dataset_error.h"
#include "core/geometry/rectification.h"
#include "tests/fuzz/dataset_mutator.h"
#include "tests/support/fuzzing.h"
#include "tests/unit/datasets/dataset_folders.h"
#include "tests/unit/datasets/foreign_files.h"

namespace plslam {
namespace {

using Clock = std::chrono::steady_clock;

/// Returns whether the files were read. A rig that was read must be valid for rectification, which may still reject it
/// with a sentence.
bool Reads(const std::vector<std::string>& paths) {
  try {
    const RigCalibration rig = ReadForeignCalibration(paths, {672, 376}).rig;
    EXPECT_EQ(RigComplaint(rig), "");
    try {
      EXPECT_TRUE(std::isfinite(Rectify(rig).camera.f_px));
    } catch (const std::runtime_error&) {
    }
    return true;
  } catch (const DatasetError& error) {
    EXPECT_LT(std::string(error.what()).size(), 6000U);
    return false;
  } catch (const std::exception& error) {
    ADD_FAILURE() << "not a DatasetError: " << error.what();
    return false;
  }
}

TEST(CalibrationFuzz, MutatedFiles) {
  const double seconds = test::EnvironmentNumber("PLSLAM_FUZZ_SECONDS", 3.0);
  const auto& rigs = test::ForeignRigs();
  test::TemporaryFolder folder;
  std::vector<int> n_read(rigs.size(), 0);
  auto seed = static_cast<uint64_t>(test::EnvironmentNumber("PLSLAM_FUZZ_SEED", 1.0));
  int n_cases = 0;
  const auto end = Clock::now() + std::chrono::duration<double>(seconds);
  do {
    SCOPED_TRACE("PLSLAM_FUZZ_SEED=" + std::to_string(seed));
    test::DatasetMutator mutator(seed++);
    for (size_t i = 0; i < rigs.size(); ++i) {
      std::vector<std::string> paths;
      std::vector<test::ForeignFile> files = rigs[i].files;
      files.insert(files.end(), rigs[i].beside.begin(), rigs[i].beside.end());
      const auto changed = static_cast<size_t>(mutator.Below(static_cast<int>(files.size())));
      for (size_t file = 0; file < files.size(); ++file) {
        const auto& [name, text] = files[file];
        const std::string& other = rigs[(i + 1) % rigs.size()].files.front().text;
        const std::string path = (folder.path() / name).string();
        test::WriteText(path, file == changed ? mutator.Mutate(text, other) : text);
        if (file < rigs[i].files.size()) paths.push_back(path);
      }
      n_read[i] += Reads(paths) ? 1 : 0;
      ++n_cases;
    }
  } while (Clock::now() < end && !HasFailure());
  for (size_t i = 0; i < rigs.size(); ++i) {
    printf("%s: %d of %d read\n", rigs[i].files.front().name.c_str(), n_read[i],
           n_cases / static_cast<int>(rigs.size()));
  }
}

}  // namespace
}  // namespace plslam
