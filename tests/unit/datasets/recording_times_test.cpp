// SPDX-License-Identifier: BSD-3-Clause
// Recordings whose messages were logged late, in bursts, or by a clock that was reset.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <functional>
#include <limits>
#include <map>
#include <random>
#include <utility>
#include <vector>

#include "core/datasets/open_dataset.h"
#include "tests/unit/datasets/bag_file.h"
#include "tests/unit/datasets/dataset_folders.h"
#include "tests/unit/datasets/dataset_matchers.h"
#include "tests/unit/datasets/mcap_file.h"

namespace plslam {
namespace {

using test::RecordingOptions;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

constexpr int64_t kMs = 1'000'000;
constexpr int64_t kSecond = 1'000'000'000;
constexpr int kFrames = 40;

struct Format {
  const char* name;
  void (*make)(const std::filesystem::path& path, const RecordingOptions& options);
  std::vector<const char*> compressions;
};
const Format kFormats[] = {{"a.mcap", test::MakeMcapFile, {"", "lz4", "zstd"}},
                           {"a.bag", test::MakeBagFile, {"", "lz4", "bz2"}}};

class RecordingTimes : public testing::Test {
 protected:
  /// `check` sees the file of the recording in each format and compression. The last `cut_bytes` are missing.
  void ForEachFile(RecordingOptions options, const std::function<void(const std::string& path)>& check,
                   size_t cut_bytes = 0) {
    options.n_frames = kFrames;
    for (const Format& format : kFormats) {
      for (const char* compression : format.compressions) {
        options.compression = compression;
        const std::string path = (folder_.path() / format.name).string();
        format.make(path, options);
        if (cut_bytes > 0) std::filesystem::resize_file(path, std::filesystem::file_size(path) - cut_bytes);
        SCOPED_TRACE(format.name + std::string(" ") + compression);
        check(path);
      }
    }
  }

  void ForEachFormat(const RecordingOptions& options, const std::function<void(const Dataset&)>& check,
                     size_t cut_bytes = 0) {
    ForEachFile(
        options, [&](const std::string& path) { check(*OpenDataset(path, "")); }, cut_bytes);
  }

  /// All frames, with the pixels of both cameras, the stamps as times, and the poses.
  static void ExpectAllFrames(const Dataset& dataset) {
    ASSERT_EQ(dataset.size(), kFrames);
    EXPECT_NEAR(dataset.rig().rate_hz, 10.0, 1e-9);
    for (int i = 0; i < kFrames; ++i) {
      ASSERT_EQ(dataset.t_ns(i), kSecond + 100 * kMs * i);
      const StereoImages images = dataset.Read(i);
      ASSERT_EQ(images.t_ns, dataset.t_ns(i));
      ASSERT_EQ(images.left.at<uint8_t>(5, 7), test::TinyPixel(i, 0, 7, 5));
      ASSERT_EQ(images.right.at<uint8_t>(5, 7), test::TinyPixel(i, 1, 7, 5));
      ASSERT_TRUE(dataset.GroundTruth(i));
      ASSERT_EQ(dataset.GroundTruth(i)->translation(), Eigen::Vector3d(i, 0, 0));
    }
  }

  /// Expects the same dataset as from a recording that was logged at its stamps, without notes.
  void ExpectAsIfLoggedAtOnce(const RecordingOptions& options) {
    ForEachFormat(options, [](const Dataset& dataset) {
      EXPECT_TRUE(dataset.Notes().empty());
      ExpectAllFrames(dataset);
    });
  }

 private:
  test::TemporaryFolder folder_;
};

TEST_F(RecordingTimes, RightImagesLoggedLate) {
  for (const int64_t late_ms : {30, 90, 1000}) {
    SCOPED_TRACE(late_ms);
    const auto late = [&](uint16_t channel, int, int64_t t_ns) {
      return channel == test::kRight ? t_ns + late_ms * kMs : t_ns;
    };
    ExpectAsIfLoggedAtOnce({.log_time = late});
    ExpectAsIfLoggedAtOnce({.log_time = late, .by_log_time = true});
  }
}

TEST_F(RecordingTimes, DamagedTimesOfLogging) {
  test::TemporaryFolder folder;
  const std::string path = (folder.path() / "a.mcap").string();
  for (const int64_t nonsense_ns : {std::numeric_limits<int64_t>::max(), int64_t{-2}, int64_t{1} << 61}) {
    SCOPED_TRACE(nonsense_ns);
    const auto damaged = [&](uint16_t, int frame, int64_t t_ns) { return frame % 3 == 0 ? nonsense_ns : t_ns; };
    test::MakeMcapFile(path, {.n_frames = kFrames, .log_time = damaged});
    ExpectAllFrames(*OpenDataset(path, ""));
  }
}

TEST_F(RecordingTimes, JitterUpToASecond) {
  std::mt19937 random(1);
  std::map<std::pair<int, int>, int64_t> delays;
  const auto jitter = [&](uint16_t channel, int frame, int64_t t_ns) {
    const auto [delay, is_new] = delays.try_emplace({channel, frame}, 0);
    if (is_new) delay->second = static_cast<int64_t>(random() % 1000) * kMs;
    return t_ns + delay->second;
  };
  ExpectAsIfLoggedAtOnce({.log_time = jitter});
  ExpectAsIfLoggedAtOnce({.log_time = jitter, .by_log_time = true});
}

TEST_F(RecordingTimes, FilesWithoutAnIndex) {
  const auto late = [](uint16_t channel, int, int64_t t_ns) {
    return channel == test::kRight ? t_ns + 90 * kMs : t_ns;
  };
  ForEachFormat(
      {.log_time = late},
      [](const Dataset& dataset) {
        // Bags end with their index, of which the cut leaves a part.
        const Notes notes = dataset.Notes();
        EXPECT_EQ(notes.warnings.size() + notes.remarks.size(), 1U);
        EXPECT_THAT((notes.remarks.empty() ? notes.warnings : notes.remarks).at(0),
                    HasSubstr("were read to find the messages"));
        ExpectAllFrames(dataset);
      },
      20);
}

TEST_F(RecordingTimes, LogClockSetBackConstantOrInBursts) {
  ExpectAsIfLoggedAtOnce({.log_time = [](uint16_t, int frame, int64_t t_ns) {
    return frame < kFrames / 2 ? t_ns + 10 * kSecond : t_ns + 10 * kSecond - 507 * kMs;
  }});
  ExpectAsIfLoggedAtOnce({.log_time = [](uint16_t, int, int64_t) { return int64_t{7}; }});
  ExpectAsIfLoggedAtOnce(
      {.log_time = [](uint16_t, int frame, int64_t) { return kSecond + frame / 5 * 500 * kMs + frame % 5 * kMs; }});
}

TEST_F(RecordingTimes, StampsThatAreZeroOrConstant) {
  for (const int64_t stamp_ns : {int64_t{0}, 5 * kSecond}) {
    const char* reason = stamp_ns == 0 ? "are all zero" : "are all equal";
    const auto constant = [&](uint16_t, int, int64_t) { return stamp_ns; };
    ForEachFormat({.stamp = constant}, [&](const Dataset& dataset) {
      ExpectAllFrames(dataset);
      EXPECT_THAT(dataset.Notes().warnings,
                  ElementsAre(AllOf(HasSubstr("header stamps of /cam0/image_raw "), HasSubstr(reason),
                                    HasSubstr("times at which they were logged"))));
    });
    const auto right = [&](uint16_t channel, int, int64_t t_ns) { return channel == test::kRight ? stamp_ns : t_ns; };
    ForEachFormat({.stamp = right}, [&](const Dataset& dataset) {
      ExpectAllFrames(dataset);
      EXPECT_THAT(dataset.Notes().warnings,
                  ElementsAre(AllOf(HasSubstr("header stamps of /cam1/image_raw "), HasSubstr(reason))));
    });
  }
}

TEST_F(RecordingTimes, SomeStampsThatAreZero) {
  const auto first = [](uint16_t, int frame, int64_t t_ns) { return frame < 2 ? 0 : t_ns; };
  ForEachFormat({.stamp = first}, [](const Dataset& dataset) {
    ASSERT_EQ(dataset.size(), kFrames - 2);
    EXPECT_EQ(dataset.Read(0).right.at<uint8_t>(5, 7), test::TinyPixel(2, 1, 7, 5));
    EXPECT_THAT(dataset.Notes().warnings,
                ElementsAre("2 messages of /cam0/image_raw skipped: the header stamp is zero",
                            "2 messages of /cam1/image_raw skipped: the header stamp is zero",
                            "2 messages of /ground_truth skipped: the header stamp is zero"));
  });
}

TEST_F(RecordingTimes, TruthWithoutStamps) {
  const auto stamp = [](uint16_t channel, int, int64_t t_ns) { return channel == test::kTruth ? 0 : t_ns; };
  const auto log = [](uint16_t, int, int64_t t_ns) { return t_ns + 111 * kSecond; };
  ForEachFormat({.log_time = log, .stamp = stamp}, [](const Dataset& dataset) {
    ExpectAllFrames(dataset);
    EXPECT_THAT(dataset.Notes().warnings, ElementsAre(AllOf(HasSubstr("header stamps of /ground_truth are all zero"),
                                                            HasSubstr("plus the -111.000000000 s"))));
  });
}

TEST_F(RecordingTimes, StampsOfTwoClocks) {
  const auto stamp = [](uint16_t channel, int, int64_t t_ns) {
    return channel == test::kRight ? t_ns + 1000 * kSecond : t_ns;
  };
  ForEachFormat({.stamp = stamp}, [](const Dataset& dataset) {
    ExpectAllFrames(dataset);
    EXPECT_THAT(dataset.Notes().warnings,
                ElementsAre(AllOf(HasSubstr("no header stamp of /cam0/image_raw is near one of /cam1"),
                                  HasSubstr("1.000000000 s and 1001.000000000 s"))));
  });
}

TEST_F(RecordingTimes, StampsThatGoBack) {
  const auto stamp = [](uint16_t, int frame, int64_t t_ns) { return frame < 20 ? t_ns : t_ns - 550 * kMs; };
  ForEachFormat({.stamp = stamp}, [](const Dataset& dataset) {
    // Frames 20 to 24 have times of frames 14 to 19.
    ASSERT_EQ(dataset.size(), kFrames - 5);
    for (int i = 0; i < dataset.size(); ++i) {
      const int frame = i < 20 ? i : i + 5;
      ASSERT_EQ(dataset.t_ns(i), kSecond + 100 * kMs * frame - (i < 20 ? 0 : 550 * kMs));
      ASSERT_EQ(dataset.Read(i).left.at<uint8_t>(5, 7), test::TinyPixel(frame, 0, 7, 5));
      ASSERT_EQ(dataset.Read(i).right.at<uint8_t>(5, 7), test::TinyPixel(frame, 1, 7, 5));
    }
    EXPECT_THAT(dataset.Notes().warnings.at(0),
                HasSubstr("header stamps of /cam0/image_raw go back by 0.450000000 s at "
                          "2.900000000 s, since a clock was set"));
    EXPECT_EQ(dataset.Notes().warnings.at(1),
              "5 messages of /cam0/image_raw skipped: not later than the ones before");
  });
}

TEST_F(RecordingTimes, StampsThatGoBackBeforeTheBegin) {
  const auto stamp = [](uint16_t, int frame, int64_t t_ns) { return frame < 10 ? t_ns + 3600 * kSecond : t_ns; };
  ForEachFile({.stamp = stamp}, [](const std::string& path) {
    EXPECT_THAT(test::ErrorOf([&] { OpenDataset(path, ""); }),
                AllOf(HasSubstr("go back by 3599.900000000 s at 3601.900000000 s, since a clock was set"),
                      HasSubstr("10 images from 3601.000000000 s to 3601.900000000 s (part=1), 30 images from "
                                "2.000000000 s to 4.900000000 s (part=2)")));
    for (const int part : {1, 2}) {
      const auto dataset = OpenDataset(fmt::format("{}?part={}", path, part), "");
      ASSERT_EQ(dataset->size(), part == 1 ? 10 : 30);
      for (int i = 0; i < dataset->size(); ++i) {
        const int frame = part == 1 ? i : 10 + i;
        EXPECT_EQ(dataset->t_ns(i), kSecond + 100 * kMs * frame + (part == 1 ? 3600 * kSecond : 0));
        EXPECT_EQ(dataset->Read(i).left.at<uint8_t>(5, 7), test::TinyPixel(frame, 0, 7, 5));
        EXPECT_EQ(dataset->Read(i).right.at<uint8_t>(5, 7), test::TinyPixel(frame, 1, 7, 5));
        ASSERT_TRUE(dataset->GroundTruth(i));
        EXPECT_EQ(dataset->GroundTruth(i)->translation(), Eigen::Vector3d(frame, 0, 0));
      }
      EXPECT_TRUE(dataset->Notes().warnings.empty());
      EXPECT_THAT(dataset->Notes().remarks, ElementsAre(HasSubstr(fmt::format("part {} of 2 is played", part))));
    }
    EXPECT_THAT(test::ErrorOf([&] { OpenDataset(path + "?part=3", ""); }), HasSubstr("part=3: it has 2 parts"));
    EXPECT_THAT(test::ErrorOf([&] { OpenDataset(path + "?part=b", ""); }), HasSubstr("part=b: is no number from 1"));
  });
}

TEST_F(RecordingTimes, StampsThatJumpForward) {
  const auto stamp = [](uint16_t, int frame, int64_t t_ns) { return frame < 20 ? t_ns : t_ns + 3600 * kSecond; };
  ForEachFormat({.stamp = stamp}, [](const Dataset& dataset) {
    ASSERT_EQ(dataset.size(), kFrames);
    for (int i = 0; i < kFrames; ++i) {
      EXPECT_EQ(dataset.Read(i).left.at<uint8_t>(5, 7), test::TinyPixel(i, 0, 7, 5));
    }
    EXPECT_THAT(
        dataset.Notes().warnings,
        testing::Contains("header stamps of /cam0/image_raw jump forward by 3600.100000000 s at 2.900000000 s, but "
                          "the messages were logged 0.100000000 s apart: a clock was set"));
  });
}

TEST_F(RecordingTimes, PausedRecordingHasNoWarning) {
  const auto paused = [](uint16_t, int frame, int64_t t_ns) { return frame < 20 ? t_ns : t_ns + 60 * kSecond; };
  ForEachFormat({.log_time = paused, .stamp = paused}, [](const Dataset& dataset) {
    EXPECT_EQ(dataset.size(), kFrames);
    EXPECT_TRUE(dataset.Notes().warnings.empty());
    EXPECT_THAT(dataset.Notes().remarks,
                testing::Contains("/cam0/image_raw has no messages for 60.100000000 s after 2.900000000 s"));
  });
}

TEST_F(RecordingTimes, FewMessagesOfAnotherTimeAreSkipped) {
  for (const int first : {0, 7, 38}) {
    for (const int64_t off_s : {-900, 900}) {
      SCOPED_TRACE(fmt::format("frame {}, {} s", first, off_s));
      const auto stamp = [&](uint16_t, int frame, int64_t t_ns) {
        return frame == first || frame == first + 1 ? t_ns + (off_s + 1000) * kSecond : t_ns + 1000 * kSecond;
      };
      ForEachFormat({.stamp = stamp}, [&](const Dataset& dataset) {
        if (first == 7) {
          EXPECT_EQ(dataset.size(), kFrames - 2);
        }
        for (int i = 1; i < dataset.size(); ++i) EXPECT_LT(dataset.t_ns(i - 1), dataset.t_ns(i));
        EXPECT_FALSE(dataset.Notes().warnings.empty());
      });
    }
  }
}

TEST_F(RecordingTimes, MessagesWithTheStampOfAnotherOne) {
  const auto stamp = [](uint16_t, int frame, int64_t t_ns) { return frame == 8 ? t_ns - 100 * kMs : t_ns; };
  ForEachFormat({.stamp = stamp}, [](const Dataset& dataset) {
    EXPECT_EQ(dataset.size(), kFrames - 1);
    EXPECT_EQ(dataset.Notes().warnings.at(0), "1 message of /cam0/image_raw skipped: another one has the same time");
  });
}

TEST_F(RecordingTimes, RightCameraThatIsTriggeredLater) {
  const auto stamp = [](uint16_t channel, int, int64_t t_ns) {
    return channel == test::kRight ? t_ns + 40 * kMs : t_ns;
  };
  ExpectAsIfLoggedAtOnce({.stamp = stamp});
}

TEST_F(RecordingTimes, RightImagesThatAreMissing) {
  // The nearest right image of frame 8 is that of frame 9, which is more than half a frame away.
  const auto stamp = [](uint16_t channel, int frame, int64_t t_ns) {
    return channel == test::kRight && frame == 8 ? t_ns + 10'000 * kSecond : t_ns;
  };
  ForEachFormat({.stamp = stamp}, [](const Dataset& dataset) {
    EXPECT_EQ(dataset.size(), kFrames - 1);
    EXPECT_EQ(dataset.t_ns(8), kSecond + 900 * kMs);
    EXPECT_EQ(dataset.Read(8).right.at<uint8_t>(5, 7), test::TinyPixel(9, 1, 7, 5));
  });
}

// Most stamps of a large recording are read when their frame is played.
TEST_F(RecordingTimes, LargeRecordingsHaveTheSameTimes) {
  constexpr int kManyFrames = 5000;
  const auto log = [](uint16_t channel, int frame, int64_t t_ns) {
    const int64_t stall_ms = frame > 2000 && frame < 2010 ? (2010 - frame) * 100 : 0;
    return t_ns + (30 + frame * 7 % 10 + stall_ms + (channel == test::kRight ? 90 : 0)) * kMs;
  };
  for (const Format& format : kFormats) {
    test::TemporaryFolder folder;
    const std::string path = (folder.path() / format.name).string();
    format.make(path, {.n_frames = kManyFrames, .log_time = log});
    const auto dataset = OpenDataset(path, "");
    EXPECT_TRUE(dataset->Notes().empty());
    ASSERT_EQ(dataset->size(), kManyFrames);
    for (int i = 0; i < kManyFrames; ++i) {
      ASSERT_EQ(dataset->t_ns(i), kSecond + 100 * kMs * i);
      if (i % 97 != 0 && std::abs(i - 2005) > 10) continue;
      const StereoImages images = dataset->Read(i);
      ASSERT_EQ(images.t_ns, dataset->t_ns(i));
      ASSERT_EQ(images.left.at<uint8_t>(5, 7), test::TinyPixel(i, 0, 7, 5));
      ASSERT_EQ(images.right.at<uint8_t>(5, 7), test::TinyPixel(i, 1, 7, 5));
      ASSERT_EQ(dataset->GroundTruth(i)->translation(), Eigen::Vector3d(i, 0, 0));
    }
  }
}

TEST_F(RecordingTimes, RecordingsWithoutMessagesAreNotCutOff) {
  for (const Format& format : kFormats) {
    test::TemporaryFolder folder;
    const std::string path = (folder.path() / format.name).string();
    format.make(path, {.n_frames = 0});
    const std::string error = test::ErrorOf([&] { OpenDataset(path, ""); });
    EXPECT_THAT(error, AllOf(HasSubstr(path), HasSubstr("has no messages"), Not(HasSubstr("truncated")),
                             Not(HasSubstr("read to find"))));
  }
}

}  // namespace
}  // namespace plslam
