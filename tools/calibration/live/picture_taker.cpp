// SPDX-License-Identifier: BSD-3-Clause
#include "tools/calibration/live/picture_taker.h"

#include <algorithm>
#include <cmath>
#include <map>

#include <fmt/format.h>
#include <opencv2/calib3d.hpp>

#include "core/motion/robust.h"

namespace plslam::calibration {
namespace {

constexpr double kStill_px = 0.5;
/// For so many looks, and so long.
constexpr int kStillLooks = 3;
constexpr double kStill_s = 0.25;
constexpr size_t kMinCorners = 8;
constexpr int kEnoughPictures = 30;
/// Share of a picture's corners that lie in cells of the image without any corner so far.
constexpr double kNewShare = 0.15;
constexpr int kColumns = 12, kRows = 8;
constexpr double kSineOfTilt = 0.34;  // 20 degrees
/// Steps of the distance per octave: a step is a factor of 1.4.
constexpr double kStepsOfScale = 2.0;

/// Median motion of the corners that are in both; infinite where these are few.
double Motion_px(const BoardView& before, const BoardView& now) {
  std::map<int, Eigen::Vector2d> pixels;
  for (size_t i = 0; i < before.corners.size(); ++i) pixels[before.corners[i]] = before.pixels[i];
  std::vector<double> motions;
  for (size_t i = 0; i < now.corners.size(); ++i) {
    const auto found = pixels.find(now.corners[i]);
    if (found != pixels.end()) motions.push_back((found->second - now.pixels[i]).norm());
  }
  return motions.size() < kMinCorners ? INFINITY : Median(motions);
}

}  // namespace

bool PictureTaker::IsStill(const BoardView& left, const BoardView& right, double t_s) {
  const double motion_px = std::max(Motion_px(last_left_, left), Motion_px(last_right_, right));
  last_left_ = left;
  last_right_ = right;
  if (!(motion_px < kStill_px)) {
    still_looks_ = 0;
    still_since_s_ = t_s;
    return false;
  }
  return ++still_looks_ >= kStillLooks - 1 && t_s - still_since_s_ >= kStill_s;
}

/// From the homography of the board, as of a lens of a usual angle: it only sorts pictures.
PictureTaker::Stance PictureTaker::StanceOf(const BoardView& view) const {
  Stance stance;
  const std::vector<Eigen::Vector2d> corners = BoardCorners(board_);
  const double f = 0.8 * size_.width_px;
  const Eigen::Vector2d middle(0.5 * board_.width_m(), 0.5 * board_.height_m());
  std::vector<cv::Point2d> on_board, seen;
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();
  for (size_t i = 0; i < view.corners.size(); ++i) {
    const Eigen::Vector2d p = corners[static_cast<size_t>(view.corners[i])] - middle;
    on_board.emplace_back(p.x(), p.y());
    seen.emplace_back((view.pixels[i].x() - 0.5 * size_.width_px) / f,
                      (view.pixels[i].y() - 0.5 * size_.height_px) / f);
    centre += view.pixels[i] / static_cast<double>(view.corners.size());
  }
  stance.column = static_cast<int>(CellOf(centre, size_, 4, 1));
  stance.row = static_cast<int>(CellOf(centre, size_, 1, 3));
  const cv::Mat H = cv::findHomography(on_board, seen);
  if (H.empty()) return stance;
  const Eigen::Vector3d x(H.at<double>(0, 0), H.at<double>(1, 0), H.at<double>(2, 0));
  const Eigen::Vector3d y(H.at<double>(0, 1), H.at<double>(1, 1), H.at<double>(2, 1));
  // The last entry of H is 1, so that its columns are the axes by the distance.
  stance.scale = static_cast<int>(std::lround(kStepsOfScale * std::log2(std::sqrt(x.norm() * y.norm()))));
  Eigen::Vector3d away = x.cross(y).normalized();
  if (away.z() < 0.0) away = -away;
  stance.left = away.x() > kSineOfTilt;
  stance.right = away.x() < -kSineOfTilt;
  stance.up = away.y() > kSineOfTilt;
  stance.down = away.y() < -kSineOfTilt;
  return stance;
}

bool PictureTaker::IsNewPlace(const BoardView& view, bool is_right) const {
  const auto& cells = cells_[is_right ? 1 : 0];
  const auto n = std::ranges::count_if(
      view.pixels, [&](const Eigen::Vector2d& p) { return !cells.contains(CellOf(p, size_, kColumns, kRows)); });
  return static_cast<double>(n) >= kNewShare * static_cast<double>(view.pixels.size());
}

void PictureTaker::Count(const BoardView& view, bool is_right) {
  auto& pixels = pixels_[is_right ? 1 : 0];
  pixels.insert(pixels.end(), view.pixels.begin(), view.pixels.end());
  for (const Eigen::Vector2d& p : view.pixels) {
    cells_[is_right ? 1 : 0].insert(CellOf(p, size_, kColumns, kRows));
  }
}

bool PictureTaker::Add(const BoardView& left, const BoardView& right, double t_s) {
  if (!IsStill(left, right, t_s)) return false;
  // Noise must not turn one position of the board into several.
  if (std::max(Motion_px(taken_left_, left), Motion_px(taken_right_, right)) < kStill_px) return false;
  const Stance stance = StanceOf(left);
  if (stances_.contains(stance) && !IsNewPlace(left, false) && !IsNewPlace(right, true)) return false;
  stances_.insert(stance);
  taken_left_ = left;
  taken_right_ = right;
  Count(left, false);
  Count(right, true);
  ++pictures_;
  still_looks_ = 0;
  return true;
}

std::vector<std::string> PictureTaker::Missing() const {
  std::vector<std::string> missing;
  for (const bool is_right : {false, true}) {
    for (const std::string& region : EmptyRegions(pixels(is_right), size_)) {
      missing.push_back(fmt::format("no board near the {} of the {} image", region, is_right ? "right" : "left"));
    }
  }
  const auto any = [&](bool Stance::*turned) {
    return std::ranges::any_of(stances_, [&](const Stance& stance) { return stance.*turned; });
  };
  for (const auto& [turned, where] : {std::pair(&Stance::left, "left"), std::pair(&Stance::right, "right"),
                                      std::pair(&Stance::up, "up"), std::pair(&Stance::down, "down")}) {
    if (!any(turned)) missing.push_back(fmt::format("no board turned to the {} by 20 degrees", where));
  }
  const auto [nearest, farthest] =
      std::ranges::minmax(stances_.empty() ? std::set<Stance>{{}} : stances_, {}, &Stance::scale);
  if (nearest.scale == farthest.scale)
    missing.emplace_back("all boards are at the same distance: hold it nearer or farther");
  if (pictures_ < kEnoughPictures) {
    const int more = kEnoughPictures - pictures_;
    missing.push_back(
        fmt::format("{} more picture{}, each at another position, distance or tilt", more, more == 1 ? "" : "s"));
  }
  return missing;
}

}  // namespace plslam::calibration
