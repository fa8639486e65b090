// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <gmock/gmock.h>

#include "tests/support/data_folder.h"
#include "tests/support/text_file.h"
#include "tests/unit/camera/gst_elements.h"

namespace plslam::camera {
namespace {

using testing::HasSubstr;

struct Result {
  int exit_code = 0;
  std::string text;
};

Result Camera(const ScratchFolder& folder, const std::string& arguments) {
  const std::string out = folder.Path("out.txt");
  const std::string command =
      fmt::format("'{}/camera' --url memq:// {} > '{}' 2>&1", test::BinaryFolder().string(), arguments, out);
  const int status = std::system(command.c_str());
  return {WEXITSTATUS(status), ReadText(out)};
}

std::string WriteRig(const ScratchFolder& folder, const std::string& source) {
  return folder.Write(
      "rig.yaml",
      "baseline_m: 0.1\nleft:\n  model: pinhole\n  resolution_px: [64, 48]\n  focal_length_px: [40, 40]\n"
      "  principal_point_px: [32, 24]\nsource:\n  " +
          source + "\n");
}

TEST(CameraProgram, PrintsItsPipeline) {
  const ScratchFolder folder;
  const Result result = Camera(folder, WriteRig(folder, "pipeline: 'a ! b'") + " --print-pipeline");
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_EQ(result.text, "a ! b\n");
}

TEST(CameraProgram, PrintsThePipelineBeforeACalibration) {
  const ScratchFolder folder;
  const std::string size = "left:\n  resolution_px: [640, 480]\n";
  const std::string rig = folder.Write("rig.yaml", size + "source:\n  pair: [/dev/video0, /dev/video2]\n");
  const Result result = Camera(folder, rig + " --print-pipeline");
  EXPECT_EQ(result.exit_code, 0) << result.text;
  EXPECT_THAT(result.text, HasSubstr("video/x-raw,width=640,height=480"));
  EXPECT_THAT(Camera(folder, rig).text, HasSubstr("focal_length_px is missing")) << "a run needs the calibration";
}

TEST(CameraProgram, ErrorsAreOneSentence) {
  const ScratchFolder folder;
  EXPECT_THAT(Camera(folder, "").text, HasSubstr("camera: error: no rig file is given"));
  EXPECT_THAT(Camera(folder, "--print-pipeline").text, HasSubstr("RIG is required"));
  const Result bad = Camera(folder, WriteRig(folder, "pair: [a]"));
  EXPECT_EQ(bad.exit_code, 1);
  EXPECT_THAT(bad.text, HasSubstr("rig.yaml:8: pair has 1 entries"));
}

TEST(CameraProgram, LiveCamerasRejectLockstep) {
  PLSLAM_REQUIRE_ELEMENTS("videotestsrc");
  const ScratchFolder folder;
  const std::string rig = WriteRig(folder,
                                   "pipeline: 'videotestsrc is-live=true ! tee name=t t. ! queue ! appsink "
                                   "name=left t. ! queue ! appsink name=right'");
  EXPECT_THAT(Camera(folder, rig + " --pace lockstep").text,
              HasSubstr("camera.pace = lockstep: live cameras cannot wait; use realtime"));
}

}  // namespace
}  // namespace plslam::camera
