// SPDX-License-Identifier: BSD-3-Clause
// Pastes a moving body with the right stereo geometry into a recorded sequence, and writes the rectified pair as a
// KITTI folder.
//
//   paste_bodies data/kitti_03 out/k03_truck --body lead --share 0.45 --seed 1
//   paste_bodies data/kitti_03 out/k03_bus --stand --from 40 --frames 80 --body bus --share 0.6
//   paste_bodies data/kitti_03 out/k03_hood --hood 0.28
//   paste_bodies data/kitti_03 out/k03_stand --stand --from 40 --frames 80     (the same without a body)
//
// Beside images, calibration, times and truth (of the camera) the folder has mask_0 (255 at a body or the bonnet in the
// left image) and bodies.txt: for each frame the pasted share of the left image, the outline's bounds there, and T_c_b.

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <filesystem>
#include <opencv2/core.hpp>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/datasets/open_dataset.h"
#include "core/datasets/synthetic/exact_math.h"
#include "core/files/atomic_file.h"
#include "core/geometry/rectifier.h"
#include "core/io/images/png_codec.h"
#include "core/io/trajectories/trajectory.h"
#include "tests/tools/body_motion.h"
#include "tests/tools/body_picture.h"
#include "tests/tools/body_texture.h"
#include "tools/command_line/run_command_line.h"

namespace {

using plslam::Dataset;
using plslam::Rectifier;
using plslam::SE3;
using plslam::StereoCamera;
using plslam::synthetic::Texture;
using plslam::test::Body;
using plslam::test::BodyPicture;

constexpr double kNoise = 1.5;  // grey values, of bodies and of repeated frames
constexpr int kHoodTiles = 4;   // side by side, of one texture each
constexpr uint64_t kRight = 1;

struct Request {
  std::string sequence;
  std::string out;
  plslam::test::BodyRequest body;
  double hood = 0.0;
  int from = 0;
  int to = -1;
  bool stand = false;
  int frames = 60;
  std::string trajectory;
  std::string pictures;
};

struct Frame {
  int index = 0;  // in the sequence
  int64_t t_ns = 0;
  std::optional<SE3> T_w_c;  // of the rectified left camera
};

std::vector<Frame> ChooseFrames(const Request& request, const Dataset& dataset, const SE3& T_l_c) {
  const int to = request.to < 0 ? dataset.size() - 1 : request.to;
  if (request.from < 0 || to >= dataset.size() || request.from > to) {
    throw std::runtime_error(fmt::format("--from {} --to {}: {} has frames 0 to {}", request.from, to,
                                         request.sequence, dataset.size() - 1));
  }
  plslam::Trajectory trajectory;
  if (!request.trajectory.empty()) trajectory = plslam::ReadTrajectory(request.trajectory);
  const auto frame_of = [&](int index) {
    const int64_t t_ns = dataset.t_ns(index);
    if (!request.trajectory.empty()) {
      return Frame{index, t_ns, plslam::InterpolatePose(trajectory, t_ns, 10 * plslam::kMaxTruthGap_ns)};
    }
    std::optional<SE3> T_w_c = dataset.GroundTruth(index);
    if (T_w_c) T_w_c = *T_w_c * T_l_c;
    return Frame{index, t_ns, T_w_c};
  };
  std::vector<Frame> frames;
  if (request.stand) {
    const int next = std::min(request.from + 1, dataset.size() - 1);
    const int64_t step_ns = next > request.from ? dataset.t_ns(next) - dataset.t_ns(request.from) : 100'000'000;
    Frame frame = frame_of(request.from);
    for (int i = 0; i < request.frames; ++i) {
      frames.push_back(frame);
      frame.t_ns += step_ns;
    }
    return frames;
  }
  for (int i = request.from; i <= to; ++i) frames.push_back(frame_of(i));
  return frames;
}

// Returns the camera's path, or identities if it is not known everywhere: bodies then move relative to the camera.
std::vector<SE3> PathOf(const std::vector<Frame>& frames, bool* known) {
  std::vector<SE3> path;
  *known = true;
  for (const Frame& frame : frames) {
    *known = *known && frame.T_w_c.has_value();
    path.push_back(frame.T_w_c.value_or(SE3()));
  }
  if (!*known) path.assign(frames.size(), SE3());
  return path;
}

// A bonnet over the lower `share` of both images: a plane that falls away from the camera's lower border.
Body MakeHood(const StereoCamera& camera, double share, const std::vector<Texture>& textures) {
  const double far_m = camera.Depth(0.07 * camera.width_px);
  const double near_m = 0.7 * far_m;
  const auto at_row = [&](double row, double depth_m) { return (row - camera.cy_px) * depth_m / camera.f_px; };
  const double tile_m = 1.2 * camera.width_px * far_m / camera.f_px / kHoodTiles;
  const double far_y = at_row((1.0 - share) * camera.height_px, far_m);
  const double near_y = at_row(1.05 * camera.height_px, near_m);
  Body hood{{}, textures};
  for (int i = 0; i < kHoodTiles; ++i) {
    const Eigen::Vector3d corner((i - 0.5 * kHoodTiles) * tile_m, far_y, far_m);
    hood.faces.push_back(
        {corner, {tile_m, 0.0, 0.0}, {0.0, near_y - far_y, near_m - far_m}, static_cast<size_t>(i), 1.0});
  }
  return hood;
}

std::string ProjectionRow(const char* name, const StereoCamera& camera, double shift) {
  return fmt::format("{}: {:.12e} 0 {:.12e} {:.12e} 0 {:.12e} {:.12e} 0 0 0 1 0\n", name, camera.f_px, camera.cx_px,
                     shift, camera.f_px, camera.cy_px);
}

class Writer {
 public:
  Writer(const Request& request, const Dataset& dataset)
      : request_(request), dataset_(dataset), rectifier_(dataset.rig()), camera_(rectifier_.camera()) {
    frames_ = ChooseFrames(request, dataset, SE3(rectifier_.q_l_c(), Eigen::Vector3d::Zero()));
    path_ = PathOf(frames_, &path_known_);
    std::vector<Texture> textures;
    for (uint64_t i = 0; i < 5; ++i) {
      const uint64_t seed = request.body.seed * 16 + i;
      textures.push_back(request.pictures.empty() ? plslam::test::PaintVehicle(seed)
                                                  : plslam::test::PictureOf(request.pictures, seed));
    }
    if (!request.body.kind.empty()) {
      box_ = plslam::test::MoveBody(request.body, camera_, path_);
      body_ = plslam::test::MakeBox(box_.size_m, textures);
    }
    if (request.hood > 0.0) hood_ = MakeHood(camera_, request.hood, textures);
  }

  void Write() {
    for (const char* folder : {"image_0", "image_1", "mask_0"}) plslam::MakeFolder(Path(folder));
    std::string bodies =
        "# frame, share of the left image, its bounds there (x0 y0 x1 y1), T_c_b (x y z qx qy qz qw)\n";
    for (size_t i = 0; i < frames_.size(); ++i) bodies += WriteFrame(i);
    plslam::WriteFileAtomically(Path("bodies.txt"), bodies);
    const double shift = -camera_.FocalBaseline();
    plslam::WriteFileAtomically(Path("calib.txt"),
                                ProjectionRow("P0", camera_, 0.0) + ProjectionRow("P1", camera_, shift));
    WriteTimesAndPoses();
  }

  std::string Summary() const {
    return fmt::format("{}: {} frames of {}x{}, up to {:.0f} % covered, {}", request_.out, frames_.size(),
                       camera_.width_px, camera_.height_px, 100.0 * most_,
                       path_known_ ? "with truth" : "no truth: the body moves relative to the camera");
  }

 private:
  std::string Path(const std::string& name) const { return (std::filesystem::path(request_.out) / name).string(); }

  void WriteTimesAndPoses() const {
    std::string times;
    plslam::Trajectory poses;
    for (size_t i = 0; i < frames_.size(); ++i) {
      times += plslam::SecondsText(frames_[i].t_ns) + "\n";
      poses.push_back({frames_[i].t_ns, path_[0].Inverse() * path_[i]});
    }
    plslam::WriteFileAtomically(Path("times.txt"), times);
    if (path_known_) plslam::WriteTrajectory(Path("poses.txt"), plslam::TrajectoryFormat::kKitti, poses);
  }

  // The pictures of one camera, which sits at `T_c_cam` on the left one.
  std::vector<BodyPicture> Pictures(size_t i, const SE3& T_c_cam) const {
    std::vector<BodyPicture> pictures;
    if (!body_.faces.empty()) {
      const SE3 T_b_c = box_.T_w_b[i].Inverse() * path_[i];
      pictures.push_back(plslam::test::PictureOfBody(body_, camera_, T_b_c * T_c_cam));
    }
    if (!hood_.faces.empty()) pictures.push_back(plslam::test::PictureOfBody(hood_, camera_, T_c_cam));
    return pictures;
  }

  cv::Mat Changed(size_t i, uint64_t side, const cv::Mat& rectified, const std::vector<BodyPicture>& pictures) const {
    cv::Mat image = rectified.clone();
    const uint64_t seed = plslam::synthetic::Hash(request_.body.seed, 2 * i + side, 1);
    if (request_.stand) plslam::test::AddNoise(kNoise, seed, &image);
    for (const BodyPicture& picture : pictures) plslam::test::Paste(picture, kNoise, seed + 1, &image);
    return image;
  }

  std::string WriteFrame(size_t i) {
    if (i == 0 || frames_[i].index != frames_[i - 1].index) {
      const plslam::StereoImages read = dataset_.Read(frames_[i].index);
      left_ = rectifier_.RectifyLeft(read.left);
      right_ = rectifier_.RectifyRight(read.right);
    }
    const std::string name = fmt::format("{:06}.png", i);
    const SE3 T_c_r(Eigen::Quaterniond::Identity(), {camera_.baseline_m, 0.0, 0.0});
    const std::vector<BodyPicture> pictures = Pictures(i, SE3());
    plslam::WritePng(Path("image_0/" + name), Changed(i, 0, left_, pictures), 1);
    plslam::WritePng(Path("image_1/" + name), Changed(i, kRight, right_, Pictures(i, T_c_r)), 1);
    cv::Mat mask = cv::Mat::zeros(left_.size(), CV_8U);
    for (const BodyPicture& picture : pictures) mask.setTo(255, picture.coverage >= 0.5);
    plslam::WritePng(Path("mask_0/" + name), mask, 1);
    return RowOf(i, mask);
  }

  std::string RowOf(size_t i, const cv::Mat& mask) {
    const double share = static_cast<double>(cv::countNonZero(mask)) / static_cast<double>(mask.total());
    most_ = std::max(most_, share);
    std::vector<cv::Point> pixels;
    if (share > 0.0) cv::findNonZero(mask, pixels);
    cv::Point low(0, 0);
    cv::Point high(-1, -1);
    if (!pixels.empty()) low = high = pixels.front();
    for (const cv::Point& px : pixels) {
      low = {std::min(low.x, px.x), std::min(low.y, px.y)};
      high = {std::max(high.x, px.x), std::max(high.y, px.y)};
    }
    const SE3 T_c_b = body_.faces.empty() ? SE3() : path_[i].Inverse() * box_.T_w_b[i];
    const Eigen::Vector3d& t = T_c_b.translation();
    const Eigen::Quaterniond& q = T_c_b.rotation();
    return fmt::format("{} {:.4f} {} {} {} {} {:.6f} {:.6f} {:.6f} {:.8f} {:.8f} {:.8f} {:.8f}\n", i, share, low.x,
                       low.y, high.x, high.y, t.x(), t.y(), t.z(), q.x(), q.y(), q.z(), q.w());
  }

  const Request& request_;
  const Dataset& dataset_;
  Rectifier rectifier_;
  StereoCamera camera_;
  std::vector<Frame> frames_;
  std::vector<SE3> path_;
  bool path_known_ = false;
  plslam::test::MovingBox box_;
  Body body_;
  Body hood_;
  cv::Mat left_;
  cv::Mat right_;
  double most_ = 0.0;
};

int Run(const Request& request) {
  const auto dataset = plslam::OpenDataset(request.sequence, "");
  if (dataset->rig().kind != plslam::RigCalibration::Kind::kStereo) {
    throw std::runtime_error(request.sequence + ": is RGB-D; only stereo pairs can be pasted into");
  }
  Writer writer(request, *dataset);
  writer.Write();
  fmt::print("{}\n", writer.Summary());
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  Request request;
  CLI::App app("Pastes a moving body into a recorded sequence", "paste_bodies");
  app.add_option("sequence", request.sequence, "a dataset of stereo pairs")->required();
  app.add_option("out", request.out, "folder of the new sequence (KITTI layout)")->required();
  app.add_option("--body", request.body.kind, "what moves")->check(CLI::IsMember(plslam::test::BodyKindNames()));
  app.add_option("--share", request.body.share,
                 "of the image's width that the body covers (overtake, oncoming: about)")
      ->check(CLI::Range(0.05, 1.0));
  app.add_option("--depth", request.body.depth_m, "metres; without it, a disparity of 4.5 % of the image's width")
      ->check(CLI::PositiveNumber);
  app.add_option("--seed", request.body.seed, "of textures, noise and the details of the motion");
  app.add_option("--hood", request.hood, "share of the image's height that a bonnet covers")
      ->check(CLI::Range(0.0, 0.8));
  app.add_option("--from", request.from, "first frame");
  app.add_option("--to", request.to, "last frame");
  CLI::Option* stand =
      app.add_flag("--stand", request.stand, "the camera stands: frame --from, with noise, again and again");
  app.add_option("--frames", request.frames, "how often")->needs(stand)->check(CLI::Range(2, 100000));
  app.add_option("--trajectory", request.trajectory, "poses of the rectified left camera, in place of the truth");
  app.add_option("--pictures", request.pictures, "folder of images for textures, in place of painted ones");
  return plslam::RunCommandLine(app, argc, argv, [&] { return Run(request); });
}
