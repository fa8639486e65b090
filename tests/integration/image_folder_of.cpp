// SPDX-License-Identifier: BSD-3-Clause
#include "tests/integration/image_folder_of.h"

#include <fmt/format.h>

#include <fstream>

#include "core/io/images/png_codec.h"

namespace plslam::test {
namespace {

void WriteImage(const std::filesystem::path& path, const cv::Mat& image, bool covered) {
  const cv::Mat black(image.size(), image.type(), cv::Scalar(3));
  WritePng(path.string(), covered ? black : image, 1);
}

}  // namespace

void WriteImageFolder(const Dataset& dataset, const std::vector<ChosenFrame>& frames,
                      const std::filesystem::path& folder) {
  std::filesystem::create_directories(folder / "left");
  std::filesystem::create_directories(folder / "right");
  const CameraCalibration& left = dataset.rig().left;
  std::ofstream(folder / "camera.yaml") << fmt::format(
      "baseline_m: {}\nleft:\n  model: pinhole\n  focal_length_px: [{}, {}]\n  principal_point_px: [{}, {}]\n",
      dataset.rig().baseline_m, left.fx_px, left.fy_px, left.cx_px, left.cy_px);
  std::ofstream times(folder / "times.txt");
  std::ofstream truth(folder / "groundtruth.txt");
  for (size_t i = 0; i < frames.size(); ++i) {
    const StereoImages images = dataset.Read(frames[i].index);
    const std::string name = fmt::format("{:06}.png", i);
    WriteImage(folder / "left" / name, images.left, frames[i].covered);
    WriteImage(folder / "right" / name, images.right, frames[i].covered);
    const double t_s = 0.05 * static_cast<double>(i + 1);
    times << fmt::format("{:.3f}\n", t_s);
    if (const auto T = dataset.GroundTruth(frames[i].index)) {
      const Eigen::Vector3d& p = T->translation();
      const Eigen::Quaterniond& q = T->rotation();
      truth << fmt::format("{:.3f} {:.9f} {:.9f} {:.9f} {:.12f} {:.12f} {:.12f} {:.12f}\n", t_s, p.x(), p.y(), p.z(),
                           q.x(), q.y(), q.z(), q.w());
    }
  }
}

}  // namespace plslam::test
