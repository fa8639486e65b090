// SPDX-License-Identifier: BSD-3-Clause
#include "tests/unit/datasets/dataset_folders.h"

#include <fmt/format.h>
#include <stdlib.h>
#include <unistd.h>

#include <fstream>
#include <iterator>
#include <opencv2/core.hpp>
#include <stdexcept>

#include "core/io/images/png_codec.h"

namespace plslam::test {
namespace {

namespace fs = std::filesystem;

constexpr int kFrames = 3;

void WriteImage(const fs::path& path, int frame, int camera) {
  fs::create_directories(path.parent_path());
  cv::Mat image(kTinyHeight_px, kTinyWidth_px, CV_8UC1);
  for (int y = 0; y < image.rows; ++y) {
    for (int x = 0; x < image.cols; ++x)
      image.at<uint8_t>(y, x) = static_cast<uint8_t>(TinyPixel(frame, camera, x, y));
  }
  WritePng(path.string(), image);
}

void WriteDepth(const fs::path& path, cv::Size size, int frame) {
  fs::create_directories(path.parent_path());
  const cv::Mat depth(size, CV_16UC1, cv::Scalar(5000 + 100 * frame));
  WritePng(path.string(), depth);
}

std::string SensorYaml(double x_m) {
  return fmt::format(R"(# General sensor definitions.
sensor_type: camera
T_BS:
  cols: 4
  rows: 4
  data: [0.0, -1.0, 0.0, 0.0,
         1.0, 0.0, 0.0, {},
         0.0, 0.0, 1.0, 0.5,
         0.0, 0.0, 0.0, 1.0]
rate_hz: 20
resolution: [{}, {}]
camera_model: pinhole
intrinsics: [40.0, 41.0, 24.0, 16.0] #fu, fv, cu, cv
distortion_model: radial-tangential
distortion_coefficients: [-0.28, 0.07, 0.0002, 1.8e-05]
)",
                     x_m, kTinyWidth_px, kTinyHeight_px);
}

}  // namespace

// In memory if there is such a folder: a fuzzer writes thousands of files.
TemporaryFolder::TemporaryFolder() {
  const fs::path memory = "/dev/shm";
  const bool has_memory = access(memory.c_str(), W_OK) == 0;
  std::string name = ((has_memory ? memory : fs::temp_directory_path()) / "plslam_test_XXXXXX").string();
  if (mkdtemp(name.data()) == nullptr) throw std::runtime_error("no temporary folder " + name);
  path_ = name;
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code ignored;
  fs::remove_all(path_, ignored);
}

int TinyPixel(int frame, int camera, int x, int y) { return (7 * x + 5 * y + 31 * frame + 64 * camera) % 256; }

void WriteText(const fs::path& path, std::string_view text) {
  fs::create_directories(path.parent_path());
  std::ofstream(path, std::ios::binary) << text;
}

std::string ReadText(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

void ReplaceText(const fs::path& path, std::string_view from, std::string_view to) {
  std::string text = ReadText(path);
  const size_t at = text.find(from);
  if (at == std::string::npos) throw std::runtime_error(fmt::format("no '{}' in {}", from, path.string()));
  WriteText(path, text.replace(at, from.size(), to));
}

void MakeKittiFolder(const fs::path& folder) {
  WriteText(folder / "calib.txt",
            "P0: 40 0 24 0 0 40 16 0 0 0 1 0\n"
            "P1: 40 0 24 -20 0 40 16 0 0 0 1 0\n"
            "Tr: 1 0 0 0 0 1 0 0 0 0 1 0\n");
  WriteText(folder / "times.txt", "0.0\n1.0e-01\n0.2\n");
  WriteText(folder / "poses.txt", "1 0 0 0 0 1 0 0 0 0 1 0\n1 0 0 0 0 1 0 0 0 0 1 0.5\n1 0 0 0 0 1 0 0 0 0 1 1.5\n");
  for (int i = 0; i < kFrames; ++i) {
    for (int camera = 0; camera < 2; ++camera) {
      WriteImage(folder / fmt::format("image_{}", camera) / fmt::format("{:06}.png", i), i, camera);
    }
  }
}

void MakeEurocFolder(const fs::path& folder, std::string_view image_extension) {
  for (int camera = 0; camera < 2; ++camera) {
    const fs::path cam = folder / "mav0" / fmt::format("cam{}", camera);
    WriteText(cam / "sensor.yaml", SensorYaml(0.1 * camera));
    std::string list = "#timestamp [ns],filename\n";
    for (int i = 0; i < kFrames; ++i) {
      const int64_t t_ns = 1403636584763555584 + i * 100'000'000LL;
      list += fmt::format("{},{}{}\n", t_ns, t_ns, image_extension);
      WriteImage(cam / "data" / fmt::format("{}{}", t_ns, image_extension), i, camera);
    }
    WriteText(cam / "data.csv", list);
  }
  std::string truth =
      "#timestamp [ns],p_RS_R_x [m],p_RS_R_y [m],p_RS_R_z [m],q_RS_w [],q_RS_x [],q_RS_y [],q_RS_z []\n";
  for (int i = 0; i < 5; ++i) {
    truth += fmt::format("{},{},0,1,1,0,0,0\n", 1403636584713555584 + i * 50'000'000LL, 0.1 * i);
  }
  WriteText(folder / "mav0" / "state_groundtruth_estimate0" / "data.csv", truth);
}

void MakeVslamLabFolder(const fs::path& folder) {
  std::string cameras = "%YAML 1.2\n---\ncameras:\n";
  for (int camera = 0; camera < 2; ++camera) {
    cameras += fmt::format(
        "- {{cam_name: rgb_{}, cam_type: gray, cam_model: pinhole, distortion_type: radtan4,\n"
        "   focal_length: [40.0, 41.0], principal_point: [24.0, 16.0],\n"
        "   distortion_coefficients: [-0.28, 0.07, 0.0002, 1.8e-05], image_dimension: [{}, {}], fps: 10.0,\n"
        "   T_BS: [0, -1, 0, 0, 1, 0, 0, {}, 0, 0, 1, 0.5, 0, 0, 0, 1]}}\n",
        camera, kTinyWidth_px, kTinyHeight_px, 0.1 * camera);
  }
  WriteText(folder / "calibration.yaml", cameras);
  std::string table = "ts_rgb_0 (ns),path_rgb_0,ts_rgb_1 (ns),path_rgb_1\n";
  std::string truth = "ts (ns),tx (m),ty (m),tz (m),qx,qy,qz,qw\n";
  for (int i = 0; i < kFrames; ++i) {
    const int64_t t_ns = 1403636584763555584 + i * 100'000'000LL;
    table += fmt::format("{},rgb_0/{}.png,{},rgb_1/{}.png\n", t_ns, i, t_ns + 20, i);
    truth += fmt::format("{},{},1,1,0,0,0,1\n", t_ns, i);
    for (int camera = 0; camera < 2; ++camera) {
      WriteImage(folder / fmt::format("rgb_{}", camera) / fmt::format("{}.png", i), i, camera);
    }
  }
  WriteText(folder / "rgb.csv", table);
  WriteText(folder / "groundtruth.csv", truth);
}

void MakeTumFolder(const fs::path& folder, int width_px, int height_px) {
  const cv::Size size(width_px, height_px);
  std::string colour = "# color images\n";
  std::string depth = "# depth maps\n";
  std::string truth = "# timestamp tx ty tz qx qy qz qw\n";
  for (int i = 0; i < kFrames; ++i) {
    const std::string name = fmt::format("1305031102.{}75304", i + 1);
    colour += fmt::format("{} rgb/{}.png\n", name, name);
    depth += fmt::format("1305031102.{}80000 depth/{}.png\n", i + 1, i);
    truth += fmt::format("1305031102.{}75304 {} 0 0 0 0 0 1\n", i + 1, i);
    fs::create_directories(folder / "rgb");
    WritePng((folder / "rgb" / (name + ".png")).string(), cv::Mat(size, CV_8UC3, cv::Scalar(10, 100, 200)));
    WriteDepth(folder / "depth" / fmt::format("{}.png", i), size, i);
  }
  WriteText(folder / "rgb.txt", colour);
  WriteText(folder / "depth.txt", depth);
  WriteText(folder / "groundtruth.txt", truth);
}

void MakeImagesFolder(const fs::path& folder) {
  WriteText(folder / "camera.yaml", R"(name: tiny
rate_hz: 10
baseline_m: 0.25
left:
  model: radtan
  focal_length_px: [40.0, 41.0]
  principal_point_px: [24.0, 16.0]
  distortion: [-0.1, 0.01, 0.0, 0.0]
)");
  for (int i = 0; i < kFrames; ++i) {
    WriteImage(folder / "left" / fmt::format("left_{}.png", 9 + i), i, 0);
    WriteImage(folder / "right" / fmt::format("right_{:04}.pgm", 9 + i), i, 1);
  }
  WriteText(folder / "times.txt", "0.5\n0.6\n0.75\n");
  WriteText(folder / "groundtruth.txt", "0.5 0 0 0 0 0 0 1\n0.6 1 0 0 0 0 0 1\n0.7 2 0 0 0 0 0 1\n");
}

}  // namespace plslam::test
