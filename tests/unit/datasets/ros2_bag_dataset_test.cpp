// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "core/datasets/open_dataset.h"
#include "tests/unit/datasets/dataset_folders.h"
#include "tests/unit/datasets/dataset_matchers.h"
#include "tests/unit/datasets/db3_file.h"

namespace plslam {
namespace {

namespace fs = std::filesystem;
using test::MakeDb3File;
using test::MakeRos2Bag;
using testing::AllOf;
using testing::HasSubstr;

class Ros2BagDataset : public test::RecordingFileTest {
 protected:
  Ros2BagDataset() : RecordingFileTest("walk") {}
  fs::path folder() const { return path(); }
};

class Db3Dataset : public test::RecordingFileTest {
 protected:
  Db3Dataset() : RecordingFileTest("a.db3") {}
};

TEST_F(Ros2BagDataset, EveryFormOfFolder) {
  for (const char* extension : {".db3", ".mcap"}) {
    for (const int bits : {0, 1, 2, 3, 4, 5, 6, 7}) {
      test::Ros2BagOptions form;
      form.split = (bits & 1) != 0 && std::string_view(extension) == ".db3";
      form.zstd_files = (bits & 2) != 0;
      form.metadata = (bits & 4) == 0;
      form.extension = extension;
      for (const bool zstd_messages : {false, true}) {
        form.zstd_messages = zstd_messages;
        fs::remove_all(folder());
        MakeRos2Bag(folder(), form);
        ExpectItsFrames(extension + std::to_string(bits) + (zstd_messages ? " messages" : ""));
      }
    }
  }
}

TEST_F(Db3Dataset, SingleFile) {
  for (const bool unsorted : {false, true}) {
    MakeDb3File(path(), {.unsorted = unsorted});
    ExpectItsFrames("single");
  }
  EXPECT_EQ(OpenDataset(path(), "")->rig().name, "ros2bag");
  EXPECT_EQ(OpenDataset(path(), "")->rig().baseline_m, 0.125);
  EXPECT_THAT(Error("?left=/a&right=/b"),
              HasSubstr("has no images on the topic left=/a; its image topics are /cam0"));
}

TEST_F(Ros2BagDataset, FilesAreInTheOrderOfTheirNumbers) {
  MakeRos2Bag(folder(), {.split = true, .metadata = false}, {.n_frames = 5});
  const auto dataset = OpenDataset(path(), "");
  ASSERT_EQ(dataset->size(), 5);
  EXPECT_TRUE(dataset->Notes().empty());
  for (int i = 0; i < 5; ++i) EXPECT_EQ(dataset->Read(i).left.at<uint8_t>(5, 7), test::TinyPixel(i, 0, 7, 5));
}

TEST_F(Ros2BagDataset, FilesMissingFromFolderOrMetadata) {
  MakeRos2Bag(folder(), {.split = true});
  fs::remove(folder() / "walk_10.db3");
  ExpectFrames(2, "without the last");
  EXPECT_THAT(Note(), HasSubstr("metadata.yaml names the file walk_10.db3, which is missing"));
  MakeRos2Bag(folder(), {.split = true});
  test::ReplaceText(folder() / "metadata.yaml", "    - walk_10.db3\n", "");
  ExpectFrames(3, "not listed");
  EXPECT_THAT(Note(), HasSubstr("1 files that metadata.yaml does not name are played after the others, walk_10.db3"));
  test::WriteText(folder() / "metadata.yaml", "rosbag2_bagfile_information: [");
  ExpectFrames(3, "damaged");
  EXPECT_THAT(Note(), HasSubstr("metadata.yaml cannot be read"));
  test::WriteText(folder() / "metadata.yaml",
                  "rosbag2_bagfile_information:\n  relative_file_paths: [walk/walk_8.db3]\n");
  ExpectFrames(3, "old");
  for (const char* name : {"walk_8.db3", "walk_9.db3", "walk_10.db3"}) fs::remove(folder() / name);
  EXPECT_THAT(Error(), HasSubstr(path() + ": has no .db3 or .mcap files: copy them beside metadata.yaml"));
}

TEST_F(Ros2BagDataset, DamagedFileOfSeveralIsNamed) {
  MakeRos2Bag(folder(), {.split = true});
  test::WriteText(folder() / "walk_9.db3", "text");
  EXPECT_THAT(Error(),
              HasSubstr(path() + ": walk_9.db3: is not a .db3 file of ROS 2, because it begins with 'text'"));
  fs::remove(folder() / "walk_9.db3");
  MakeRos2Bag(folder(), {.zstd_files = true});
  const std::string packed = test::ReadText(folder() / "walk_8.db3.zstd");
  test::WriteText(folder() / "walk_8.db3.zstd", packed.substr(0, packed.size() - 5));
  for (const char* name : {"walk_8.db3", "walk_10.db3"}) fs::remove(folder() / name);
  EXPECT_THAT(Error(), HasSubstr(path() + ": walk_8.db3.zstd: is truncated: its last zstd frame has no end"));
}

TEST_F(Ros2BagDataset, FolderWithImagesIsNoBagForItsMcap) {
  test::MakeImagesFolder(folder());
  test::WriteText(folder() / "run.mcap", "an export");
  EXPECT_EQ(OpenDataset(path(), "")->rig().name, "tiny");
}

TEST_F(Db3Dataset, OtherSqliteFilesAreExplained) {
  test::ExecuteSql(path(), "CREATE TABLE places(name TEXT);");
  EXPECT_THAT(Error(), HasSubstr(path() + ": is an SQLite file without the tables 'topics' and 'messages'"));
  fs::remove(path());
  test::ExecuteSql(path(),
                   "CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT); CREATE TABLE messages(id INTEGER);");
  EXPECT_THAT(Error(), HasSubstr("SQLite reports 'no such column: type'"));
  test::WriteText(path(), "");
  EXPECT_THAT(Error(), HasSubstr(path() + ": is empty (0 bytes), not a ROS 2 bag"));
}

// A hostile file: nothing that its schema defines is executed.
TEST_F(Db3Dataset, ViewsAreNoTables) {
  test::ExecuteSql(
      path(),
      "CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT, type TEXT, serialization_format TEXT);"
      "CREATE VIEW messages AS WITH RECURSIVE n(id) AS (SELECT 1 UNION ALL SELECT id + 1 FROM n) SELECT id, "
      "1 AS topic_id, 1 AS timestamp, x'00' AS data FROM n;");
  EXPECT_THAT(Error(), HasSubstr("without the tables 'topics' and 'messages'"));
}

TEST_F(Db3Dataset, TruncatedFilePlaysWhatIsLeft) {
  MakeDb3File(path(), {.n_frames = 20});
  fs::resize_file(path(), fs::file_size(path()) / 2);
  const auto dataset = OpenDataset(path(), "");
  EXPECT_GE(dataset->size(), 5);
  EXPECT_LT(dataset->size(), 20);
  for (int i = 0; i < dataset->size(); ++i) dataset->Read(i);
  EXPECT_THAT(Note(), AllOf(HasSubstr("is "), HasSubstr("only the messages that can be read are played"),
                            HasSubstr(".recover")));
}

// A killed recorder leaves its newest messages in the log of changes.
TEST_F(Db3Dataset, MessagesInAWriteAheadLog) {
  test::MakeDb3FileWithLog(path());
  const std::string before = test::ReadText(path()), log = test::ReadText(path() + "-wal");
  ASSERT_GT(log.size(), 10'000U);
  ExpectItsFrames("with its log");
  EXPECT_EQ(test::ReadText(path()), before);
  EXPECT_EQ(test::ReadText(path() + "-wal"), log);
  fs::remove(path() + "-wal");
  EXPECT_EQ(OpenDataset(path(), "")->size(), 2);
}

}  // namespace
}  // namespace plslam
