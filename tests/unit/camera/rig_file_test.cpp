// SPDX-License-Identifier: BSD-3-Clause
#include "camera/rig_file.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <filesystem>
#include <set>

#include "camera/pipeline_text.h"
#include "core/datasets/camera_file.h"
#include "core/files/dataset_error.h"
#include "tests/support/data_folder.h"
#include "tests/support/text_file.h"

namespace plslam::camera {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::ThrowsMessage;

constexpr const char* kCamera =
    "rate_hz: 20\nbaseline_m: 0.1\nleft:\n  model: pinhole\n  resolution_px: [752, 480]\n"
    "  focal_length_px: [400, 400]\n  principal_point_px: [376, 240]\n";

std::string WriteRig(const ScratchFolder& folder, const std::string& source) {
  return folder.Write("rig.yaml", kCamera + ("source:\n  " + source + "\n"));
}

std::string Pipeline(const ScratchFolder& folder, const std::string& source) {
  return PipelineText(ReadRigFile(WriteRig(folder, source)));
}

TEST(RigFile, IsACameraFileWithASource) {
  const ScratchFolder folder;
  const std::string path = WriteRig(folder, "pair: [/dev/video0, /dev/video2]\n  max_skew_ms: 2.5\n  give_up_s: 60");
  const LiveRig live = ReadRigFile(path);
  EXPECT_EQ(live.rig.left.width_px, 752);
  EXPECT_EQ(live.rig.rate_hz, 20.0);
  EXPECT_EQ(live.source.type, SourceSpec::Type::kPair);
  EXPECT_EQ(live.source.max_skew_ms, 2.5);
  EXPECT_EQ(live.source.give_up_s, 60.0);
  EXPECT_EQ(ReadCameraFile(path, {}).baseline_m, live.rig.baseline_m) << "elsewhere it is any camera file";
  EXPECT_TRUE(NamesSource(path));
  EXPECT_FALSE(NamesSource(folder.Write("camera.yaml", kCamera)));
  EXPECT_FALSE(NamesSource(folder.Write("bad.yaml", "source: [")));
  EXPECT_FALSE(NamesSource(folder.Path("none.yaml")));
  EXPECT_FALSE(NamesSource("synthetic:room"));
}

TEST(RigFile, ErrorsNameLineKeyAndRemedy) {
  const ScratchFolder folder;
  const std::pair<const char*, const char*> cases[] = {
      {"max_skew_ms: 3", "rig.yaml:9: source defines no cameras: give one of side_by_side, pair, gige, files, rtsp"},
      {"pair: [/dev/video0]", "rig.yaml:9: pair has 1 entries: give two devices, [/dev/video0, /dev/video2]"},
      {"pair: [/dev/video0, '']", "pair has 2 entries, one of them empty: give two devices"},
      {"gige: [A, A]", "gige = 'A' is given twice: give two names as arv-tool-0.8 lists them"},
      {"side_by_side: [/dev/video0, /dev/video1]", "side_by_side has 2 entries: give one device"},
      {"pair: [a, b]\n  rtsp: [c, d]", "rtsp contradicts pair: give one of the two"},
      {"pairs: [a, b]", "rig.yaml:9: pairs is not a known key (max_skew_ms, give_up_s, side_by_side"},
      {"pair: [a, b]\n  max_skew_ms: -1", "rig.yaml:10: max_skew_ms = -1 is not from 0 to 1000"},
      {"pair: [a, b]\n  give_up_s: soon", "rig.yaml:10: give_up_s = 'soon' is not a finite number"},
  };
  for (const auto& [source, sentence] : cases) {
    const std::string path = WriteRig(folder, source);
    EXPECT_THAT([&] { ReadRigFile(path); }, ThrowsMessage<DatasetError>(HasSubstr(sentence))) << source;
  }
  const std::string none = folder.Write("camera.yaml", kCamera);
  EXPECT_THAT([&] { ReadRigFile(none); }, ThrowsMessage<DatasetError>(HasSubstr("camera.yaml:1: source is missing")));
}

TEST(RigFileForPipeline, NeedsNoCalibration) {
  const ScratchFolder folder;
  const std::string left = "left:\n  resolution_px: [640, 480]\n", source = "source:\n  side_by_side: /dev/video0\n";
  const LiveRig live = ReadRigFileForPipeline(folder.Write("rig.yaml", "rate_hz: 15\n" + left + source));
  EXPECT_THAT(PipelineText(live),
              AllOf(HasSubstr("width=1280,height=480,framerate=15/1"), HasSubstr("videocrop right=640")));
  const std::string calibrated = WriteRig(folder, "pair: [a, b]");
  EXPECT_EQ(PipelineText(ReadRigFileForPipeline(calibrated)), PipelineText(ReadRigFile(calibrated)));
}

TEST(RigFileForPipeline, ErrorsNameLineKeyAndRemedy) {
  const ScratchFolder folder;
  const std::string left = "left:\n  resolution_px: [640, 480]\n", source = "source:\n  side_by_side: /dev/video0\n";
  const std::pair<std::string, const char*> cases[] = {
      {left, "rig.yaml:1: source is missing: a map with one of side_by_side"},
      {"left: {}\n" + source, "rig.yaml:1: resolution_px is missing: the size of the images, [640, 480]"},
      {"left:\n  resolution: [640, 480]\n" + source, "rig.yaml:2: resolution is not a known key"},
      {"left:\n  resolution_px: [4, 480]\n" + source, "rig.yaml:2: resolution_px"},
      {left + "right:\n  resolution_px: [320, 240]\n" + source, "rig.yaml:6: side_by_side needs a left and a right"},
      {left + "  distortion: [0, 0, 0, 0]\n" + source, "rig.yaml:2: focal_length_px is missing"},
      {left + source + "rat_hz: 20\n", "rig.yaml:5: rat_hz is not a known key"},
  };
  for (const auto& [text, sentence] : cases) {
    const std::string path = folder.Write("rig.yaml", text);
    EXPECT_THAT([&] { ReadRigFileForPipeline(path); }, ThrowsMessage<DatasetError>(HasSubstr(sentence))) << text;
  }
}

TEST(ExampleRigs, HavePipelinesBeforeTheirCalibration) {
  const auto folder = test::SourceFolder() / "config" / "rigs";
  std::set<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    const std::string path = entry.path().string();
    const LiveRig live = ReadRigFileForPipeline(path);
    EXPECT_GT(live.rig.left.width_px, 0) << path;
    EXPECT_GT(live.rig.rate_hz, 0.0) << path;
    EXPECT_THAT(PipelineText(live), AllOf(HasSubstr("appsink name=left"), HasSubstr("appsink name=right"))) << path;
    EXPECT_TRUE(NamesSource(path)) << path;
    EXPECT_THAT(ReadText(path), HasSubstr("NOT TESTED WITH A REAL DEVICE")) << path;
    names.insert(entry.path().filename().string());
  }
  EXPECT_THAT(names, testing::ElementsAre("oak_d.yaml", "realsense_d4xx.yaml", "zed.yaml"));
}

TEST(PipelineText, TwoDevicesOfTheSizeAndRateOfTheRig) {
  const ScratchFolder folder;
  EXPECT_EQ(Pipeline(folder, "pair: [/dev/video0, /dev/video2]"),
            "v4l2src device=\"/dev/video0\" ! "
            "capsfilter caps=\"video/x-raw,width=752,height=480,framerate=20/1;"
            "image/jpeg,width=752,height=480,framerate=20/1\" ! "
            "decodebin ! videoconvert ! video/x-raw,format=GRAY8 ! appsink name=left\n"
            "v4l2src device=\"/dev/video2\" ! "
            "capsfilter caps=\"video/x-raw,width=752,height=480,framerate=20/1;"
            "image/jpeg,width=752,height=480,framerate=20/1\" ! "
            "decodebin ! videoconvert ! video/x-raw,format=GRAY8 ! appsink name=right");
}

TEST(PipelineText, OneDeviceWithBothImagesIsCutInTheMiddle) {
  const ScratchFolder folder;
  EXPECT_THAT(Pipeline(folder, "side_by_side: /dev/video0"),
              AllOf(HasSubstr("video/x-raw,width=1504,height=480,framerate=20/1"),
                    HasSubstr("both. ! queue ! videocrop right=752 ! appsink name=left\n"),
                    HasSubstr("both. ! queue ! videocrop left=752 ! appsink name=right")));
}

TEST(PipelineText, NetworkCamerasFilesAndOwnPipelines) {
  const ScratchFolder folder;
  EXPECT_THAT(Pipeline(folder, "gige: [Basler-12345, Basler-67890]"),
              AllOf(HasSubstr("aravissrc camera-name=\"Basler-12345\" do-timestamp=true ! "
                              "video/x-raw,width=752,height=480,framerate=20/1 ! "),
                    HasSubstr("aravissrc camera-name=\"Basler-67890\"")));
  EXPECT_THAT(
      Pipeline(folder, "rtsp: ['rtsp://a/1', 'rtsp://b/\"2\"']"),
      AllOf(HasSubstr("rtspsrc location=\"rtsp://a/1\" latency=0 ! application/x-rtp,media=video ! decodebin"),
            HasSubstr("location=\"rtsp://b/\\\"2\\\"\"")));
  const std::string beside = std::filesystem::path(folder.Path("left.mp4")).string();
  EXPECT_THAT(Pipeline(folder, "files: [left.mp4, /data/right.mp4]"),
              AllOf(HasSubstr("filesrc location=\"" + beside + "\" ! decodebin"),
                    HasSubstr("filesrc location=\"/data/right.mp4\"")));
  const std::string own =
      "videotestsrc ! appsink name=left videotestsrc ! " + std::string(300, ' ') + "appsink name=right";
  EXPECT_EQ(Pipeline(folder, "pipeline: '" + own + "'"), own);
}

}  // namespace
}  // namespace plslam::camera
