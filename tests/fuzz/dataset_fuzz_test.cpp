// SPDX-License-Identifier: BSD-3-Clause
// Mutates tiny valid datasets: a reader must read the valid rest, or throw DatasetError, within a bound of memory.
//
// PLSLAM_FUZZ_SECONDS sets the duration (default 5), PLSLAM_FUZZ_SEED the first seed (default 1). Each case depends on
// its seed only, which a failure prints.
#include <fcntl.h>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <chrono>
#include <fstream>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "core/datasets/euroc_dataset.h"
#include "core/datasets/images_dataset.h"
#include "core/datasets/kitti_dataset.h"
#include "core/datasets/recordings/recording_dataset.h"
#include "core/datasets/tum_dataset.h"
#include "core/datasets/vslamlab_dataset.h"
#include "tests/fuzz/dataset_mutator.h"
#include "tests/support/fuzzing.h"
#include "tests/unit/datasets/bag_file.h"
#include "tests/unit/datasets/dataset_folders.h"
#include "tests/unit/datasets/db3_file.h"
#include "tests/unit/datasets/mcap_file.h"

namespace plslam {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

// The tiny datasets need a few MB; the rest is room for an image that lies about its size, and for the decoders.
constexpr int64_t kMemoryBound_mb = 256;

// Limits memory to the current size of the process plus the bound: larger allocations fail visibly.
class MemoryBound {
 public:
  MemoryBound() {
    getrlimit(RLIMIT_AS, &before_);
#ifndef PLSLAM_SANITIZED  // shadow memory needs terabytes; __asan_default_options below bounds single allocations
    int64_t pages = 0;
    std::ifstream("/proc/self/statm") >> pages;
    rlimit bounded = before_;
    bounded.rlim_cur = static_cast<rlim_t>(pages * sysconf(_SC_PAGESIZE) + (kMemoryBound_mb << 20));
    setrlimit(RLIMIT_AS, &bounded);
#endif
  }
  ~MemoryBound() { setrlimit(RLIMIT_AS, &before_); }
  MemoryBound(const MemoryBound&) = delete;
  MemoryBound& operator=(const MemoryBound&) = delete;

 private:
  rlimit before_{};
};

// The decoders of PNG and JPEG complain on stderr, a thousand times here.
class QuietStderr {
 public:
  QuietStderr() : saved_(dup(STDERR_FILENO)) {
#ifndef PLSLAM_SANITIZED  // whose reports are written there too
    const int null = open("/dev/null", O_WRONLY | O_CLOEXEC);
    dup2(null, STDERR_FILENO);
    close(null);
#endif
  }
  ~QuietStderr() {
    dup2(saved_, STDERR_FILENO);
    close(saved_);
  }
  QuietStderr(const QuietStderr&) = delete;
  QuietStderr& operator=(const QuietStderr&) = delete;

 private:
  int saved_;
};

struct Reader {
  const char* name;
  void (*make)(const fs::path& folder);
  std::unique_ptr<Dataset> (*open)(const std::string& folder);
};

void MakeEurocJpeg(const fs::path& folder) { test::MakeEurocFolder(folder, ".jpg"); }
void MakeEurocPng(const fs::path& folder) { test::MakeEurocFolder(folder, ".png"); }
void MakeTum(const fs::path& folder) {
  test::MakeTumFolder(folder, test::kTinyWidth_px, test::kTinyHeight_px);
  test::WriteText(folder / "camera.yaml",
                  "kind: rgbd\ndepth_units_per_m: 1000\nbaseline_m: 0.1\n"
                  "left: {focal_length_px: [50, 50], principal_point_px: [24, 16]}\n");
}
void MakeAssociated(const fs::path& folder) {
  MakeTum(folder);
  test::WriteText(folder / "associations.txt",
                  "1305031102.175304 rgb/1305031102.175304.png 1305031102.180000 depth/0.png\n"
                  "1305031102.275304 rgb/1305031102.275304.png 1305031102.280000 depth/1.png\n");
}

std::vector<ImuSample> Samples() {
  std::vector<ImuSample> samples;
  for (int64_t i = 0; i < 20; ++i) samples.push_back({.t_ns = 990'000'000 + 10'000'000 * i});
  return samples;
}

void MakeMcap(const fs::path& folder) {
  test::MakeMcapFile(folder / "a.mcap", {.compression = "zstd", .checksums = false});
}
void MakePlainMcap(const fs::path& folder) {
  test::MakeMcapFile(folder / "a.mcap", {.checksums = false, .imus = {{"/imu0", Samples()}}, .T_camera_imu = SE3()});
}
void MakeLz4Mcap(const fs::path& folder) {
  test::MakeMcapFile(folder / "a.mcap", {.compression = "lz4", .checksums = false});
}
void MakePlainBag(const fs::path& folder) {
  test::MakeBagFile(folder / "a.bag", {.imus = {{"/imu0", Samples()}}, .T_camera_imu = SE3()});
}
void MakeBz2Bag(const fs::path& folder) { test::MakeBagFile(folder / "a.bag", {.compression = "bz2"}); }
void MakeLz4Bag(const fs::path& folder) { test::MakeBagFile(folder / "a.bag", {.compression = "lz4"}); }
void MakeDb3(const fs::path& folder) { test::MakeRos2Bag(folder, {.split = true}); }
void MakeZstdDb3(const fs::path& folder) { test::MakeRos2Bag(folder, {.zstd_messages = true}); }
void MakeZstdMcapFolder(const fs::path& folder) {
  test::MakeRos2Bag(folder, {.zstd_files = true, .extension = ".mcap"}, {.checksums = false});
}
std::unique_ptr<Dataset> OpenBag(const std::string& folder) { return OpenBagDataset(folder + "/a.bag"); }
std::unique_ptr<Dataset> OpenMcap(const std::string& folder) { return OpenMcapDataset(folder + "/a.mcap"); }

constexpr Reader kReaders[] = {{"mcap, zstd", MakeMcap, OpenMcap},
                               {"mcap", MakePlainMcap, OpenMcap},
                               {"mcap, lz4", MakeLz4Mcap, OpenMcap},
                               {"bag", MakePlainBag, OpenBag},
                               {"bag, bz2", MakeBz2Bag, OpenBag},
                               {"bag, lz4", MakeLz4Bag, OpenBag},
                               {"db3, split", MakeDb3, OpenRos2BagDataset},
                               {"db3, zstd messages", MakeZstdDb3, OpenRos2BagDataset},
                               {"mcap folder, zstd files", MakeZstdMcapFolder, OpenRos2BagDataset},
                               {"kitti", test::MakeKittiFolder, OpenKittiDataset},
                               {"euroc, png", MakeEurocPng, OpenEurocDataset},
                               {"euroc, jpg", MakeEurocJpeg, OpenEurocDataset},
                               {"tum", MakeTum, OpenTumDataset},
                               {"tum, associations", MakeAssociated, OpenTumDataset},
                               {"vslamlab", test::MakeVslamLabFolder, OpenVslamLabDataset},
                               {"images", test::MakeImagesFolder, OpenImagesDataset}};

// Checks the invariants of every dataset that opens.
void ReadEverything(const Dataset& dataset, int* n_read) {
  ASSERT_GT(dataset.size(), 0);
  for (int i = 0; i < dataset.size(); ++i) {
    ASSERT_TRUE(i == 0 || dataset.t_ns(i) > dataset.t_ns(i - 1));
    const std::optional<SE3> pose = dataset.GroundTruth(i);
    ASSERT_TRUE(!pose || pose->IsFinite());
    if (i >= 8) continue;
    try {
      const StereoImages images = dataset.Read(i);
      ASSERT_EQ(images.left.size(), cv::Size(dataset.rig().left.width_px, dataset.rig().left.height_px));
      ASSERT_EQ(images.right.size(), images.left.size());
      ASSERT_EQ(images.left.type(), CV_8UC1);
      ++*n_read;
    } catch (const DatasetError&) {
    }
  }
}

class Fuzzer {
 public:
  explicit Fuzzer(const Reader& reader) : reader_(reader), folder_(temporary_.path() / "fuzz") {
    reader.make(folder_);
    for (const auto& entry : fs::recursive_directory_iterator(folder_)) {
      if (entry.is_regular_file()) files_.emplace_back(entry.path());
    }
    std::sort(files_.begin(), files_.end());
    for (const fs::path& file : files_) contents_.push_back(test::ReadText(file));
  }

  void RunCase(uint64_t seed) {
    SCOPED_TRACE(fmt::format("{}: PLSLAM_FUZZ_SEED={}", reader_.name, seed));
    test::DatasetMutator mutator(seed);
    std::vector<size_t> changed;
    for (int n = 1 + mutator.Below(3); n > 0; --n) changed.push_back(PickFile(mutator));
    for (const size_t file : changed) Mutate(file, mutator);
    Try();
    for (const size_t file : changed) test::WriteText(files_[file], contents_[file]);
  }

  std::string Summary() const {
    return fmt::format("{}: {} cases, {} opened, {} frames read", reader_.name, n_cases_, n_opened_, n_read_);
  }

 private:
  // Lists and calibrations are fewer than images, and have more to get wrong.
  size_t PickFile(test::DatasetMutator& mutator) const {
    for (int attempt = 0;; ++attempt) {
      const auto file = static_cast<size_t>(mutator.Below(static_cast<int>(files_.size())));
      const std::string extension = files_[file].extension().string();
      const bool is_text = extension == ".txt" || extension == ".csv" || extension == ".yaml";
      if (is_text || attempt == 3) return file;
    }
  }

  void Mutate(size_t file, test::DatasetMutator& mutator) {
    if (mutator.Below(40) == 0) {
      fs::remove(files_[file]);
      return;
    }
    const auto other = static_cast<size_t>(mutator.Below(static_cast<int>(files_.size())));
    test::WriteText(files_[file], mutator.Mutate(contents_[file], contents_[other]));
  }

  void Try() {
    ++n_cases_;
    try {
      const auto dataset = reader_.open(folder_.string());
      ++n_opened_;
      ReadEverything(*dataset, &n_read_);
    } catch (const DatasetError& error) {
      EXPECT_LT(std::string(error.what()).size(), 6000U);
    } catch (const std::exception& error) {
      ADD_FAILURE() << "not a DatasetError: " << error.what();
    }
  }

  const Reader& reader_;
  test::TemporaryFolder temporary_;
  fs::path folder_;
  std::vector<fs::path> files_;
  std::vector<std::string> contents_;
  int n_cases_ = 0;
  int n_opened_ = 0;
  int n_read_ = 0;
};

class DatasetFuzz : public testing::TestWithParam<Reader> {};

TEST_P(DatasetFuzz, MutatedFolders) {
  const double seconds = test::EnvironmentNumber("PLSLAM_FUZZ_SECONDS", 5.0) / std::size(kReaders);
  const auto end = Clock::now() + std::chrono::duration<double>(seconds);
  Fuzzer fuzzer(GetParam());
  const MemoryBound bound;
  auto seed = static_cast<uint64_t>(test::EnvironmentNumber("PLSLAM_FUZZ_SEED", 1.0));
  const QuietStderr quiet;
  do {
    fuzzer.RunCase(seed++);
  } while (Clock::now() < end && !HasFailure());
  fmt::print("{}\n", fuzzer.Summary());
}

std::string NameOf(const testing::TestParamInfo<Reader>& reader) {
  std::string name = reader.param.name;
  std::erase_if(name, [](char c) { return std::isalnum(static_cast<unsigned char>(c)) == 0; });
  return name;
}

INSTANTIATE_TEST_SUITE_P(Readers, DatasetFuzz, testing::ValuesIn(kReaders), NameOf);

}  // namespace
}  // namespace plslam

#ifdef PLSLAM_SANITIZED
// A single allocation above this ends the run.
extern "C" const char* __asan_default_options() { return "max_allocation_size_mb=256:allocator_may_return_null=0"; }
#endif
