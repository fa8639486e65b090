// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <map>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

#include "core/datasets/camera_file.h"
#include "core/datasets/check_rig.h"
#include "core/files/atomic_file.h"
#include "core/files/dataset_error.h"
#include "core/geometry/distortion.h"
#include "core/geometry/rectification.h"
#include "core/io/images/image_folder.h"
#include "tools/calibration/board.h"
#include "tools/calibration/board_faults.h"
#include "tools/calibration/board_sheet.h"
#include "tools/calibration/calibration_command.h"
#include "tools/calibration/coverage.h"
#include "tools/calibration/live/live_rig.h"
#include "tools/calibration/node/live_pictures.h"
#include "tools/calibration/rig_estimate.h"
#include "tools/command_line/number_checks.h"
#include "tools/rectify_check/row_errors.h"

namespace plslam::calibration {
namespace {

namespace fs = std::filesystem;

/// More pictures cost time and hardly make the result better.
constexpr int kMaxPairs = 80;
/// Flat views leave focal length and distance of the board open.
constexpr double kGoodTilt_deg = 20.0;

struct CalibrateOptions {
  std::string folder;
  std::string board;
  std::string model = lens_model::kRadtan;
  std::string out;
  std::string print_board;
  double seconds = 0.0;
};

struct Seen {
  std::vector<BoardPair> pairs;
  ImageSize size;
  int n_pictures = 0;
};

Seen FindBoards(const std::string& folder, const Board& board) {
  const auto left = ListImages((fs::path(folder) / "left").string());
  const auto right = ListImages((fs::path(folder) / "right").string());
  Seen seen;
  BoardFaults faults(board);
  cv::Mat first;
  for (const auto& [key, left_path] : left) {
    const auto partner = right.find(key);
    if (partner == right.end()) continue;
    const cv::Mat image = ReadGreyImage(left_path);
    if (first.empty()) first = image;
    seen.size = {first.cols, first.rows};
    if (image.size() != first.size())
      throw DatasetError(left_path + ": its size differs from that of the previous picture");
    BoardPair pair{fs::path(left_path).filename().string(), FindBoard(board, image),
                   FindBoard(board, ReadGreyImage(partner->second, seen.size))};
    seen.n_pictures += 2;
    faults.Count(pair.left);
    faults.Count(pair.right);
    if (!pair.left.corners.empty() || !pair.right.corners.empty()) seen.pairs.push_back(std::move(pair));
  }
  if (seen.n_pictures == 0)
    throw DatasetError(folder + ": no picture in left has a picture with the same number in right");
  for (const std::string& fault : {faults.Contradiction(), faults.UnseenEdge()}) {
    if (!fault.empty()) throw DatasetError(fmt::format("{}: {}", folder, fault));
  }
  if (seen.pairs.empty()) {
    throw DatasetError(fmt::format("{}: the board {} is not seen in any of {} pictures{}", folder, BoardText(board),
                                   seen.n_pictures, OtherSizeSeen(board, first)));
  }
  return seen;
}

void PrintParameters(const RigEstimate& e) {
  std::vector<std::string> names{"fx", "fy", "cx", "cy"};
  // "k1 k2 p1 p2 [k3]": all that the model can have are estimated.
  std::istringstream coefficients{std::string(FindLensModel(e.rig.left.model)->coefficients)};
  for (std::string name; coefficients >> name;) {
    std::erase_if(name, [](char c) { return c == '[' || c == ']'; });
    names.push_back(name);
  }
  const std::vector<double> left = LensParameters(e.rig.left), right = LensParameters(e.rig.right);
  const Eigen::VectorXd left_sigma = e.left_covariance.diagonal().cwiseSqrt();
  const Eigen::VectorXd right_sigma = e.right_covariance.diagonal().cwiseSqrt();
  fmt::print("{:<9} {:>12} {:>10}   {:>12} {:>10}\n", "", "left", "sigma", "right", "sigma");
  for (size_t i = 0; i < names.size(); ++i) {
    const int digits = i < 4 ? 3 : 6;
    fmt::print("{:<9} {:>12.{}f} {:>10.{}f}   {:>12.{}f} {:>10.{}f}\n", i < 4 ? names[i] + " px" : names[i], left[i],
               digits, left_sigma[static_cast<Eigen::Index>(i)], digits, right[i], digits,
               right_sigma[static_cast<Eigen::Index>(i)], digits);
  }
  if (FocalInCentre_px(e.rig.left) != e.rig.left.fx_px) {
    fmt::print("{:<9} {:>12.3f} {:>10.3f}   {:>12.3f} {:>10.3f}\n", "centre px", FocalInCentre_px(e.rig.left),
               FocalInCentreSigma_px(e.rig.left, e.left_covariance), FocalInCentre_px(e.rig.right),
               FocalInCentreSigma_px(e.rig.right, e.right_covariance));
  }
  fmt::print("largest sigma of a predicted pixel: left {:.3f}, right {:.3f}\n",
             PixelSigma_px(e.rig.left, e.left_covariance), PixelSigma_px(e.rig.right, e.right_covariance));
  const Eigen::Vector3d t = 1e3 * e.rig.right.T_b_cam.translation();
  const Vector6d turn = e.rig.right.T_b_cam.Log() / kRadPerDeg;
  const auto& s = e.T_left_right_sigma;
  const Eigen::Vector3d s_t = 1e3 * e.right_in_left_sigma_m;
  fmt::print("right camera relative to the left one: x {:.3f} y {:.3f} z {:.3f} mm (sigma {:.3f} {:.3f} {:.3f})\n",
             t.x(), t.y(), t.z(), s_t.x(), s_t.y(), s_t.z());
  fmt::print("turned by x {:.4f} y {:.4f} z {:.4f} deg (sigma {:.4f} {:.4f} {:.4f})\n", turn[3], turn[4], turn[5],
             s[3] / kRadPerDeg, s[4] / kRadPerDeg, s[5] / kRadPerDeg);
  fmt::print("baseline {:.3f} mm, sigma {:.3f} mm\n", 1e3 * e.rig.baseline_m, 1e3 * e.baseline_sigma_m);
}

void PrintCoverage(const RigEstimate& e, const Seen& seen) {
  std::vector<Eigen::Vector2d> left, right;
  for (const int i : e.used_pairs) {
    const BoardPair& pair = seen.pairs[static_cast<size_t>(i)];
    left.insert(left.end(), pair.left.pixels.begin(), pair.left.pixels.end());
    right.insert(right.end(), pair.right.pixels.begin(), pair.right.pixels.end());
  }
  const auto left_picture = CoveragePicture(left, seen.size), right_picture = CoveragePicture(right, seen.size);
  fmt::print("where corners were seen (left, right):\n");
  for (size_t i = 0; i < left_picture.size(); ++i) fmt::print("|{}| |{}|\n", left_picture[i], right_picture[i]);
  bool complete = true;
  for (const bool is_right : {false, true}) {
    for (const std::string& region : EmptyRegions(is_right ? right : left, seen.size)) {
      fmt::print("missing: no board near the {} of the {} image\n", region, is_right ? "right" : "left");
      complete = false;
    }
  }
  if (e.max_tilt_deg < kGoodTilt_deg) {
    fmt::print("missing: no board tilted by more than {:.0f} degrees (largest tilt: {:.0f})\n", kGoodTilt_deg,
               e.max_tilt_deg);
    complete = false;
  }
  if (complete) fmt::print("no view is missing\n");
}

/// Prints the measurements of `plslam rectify-check` on the corners that both cameras see.
void PrintRows(const RigEstimate& e, const Board& board, const Seen& seen) {
  const Rectification rectification = Rectify(e.rig);
  const StereoCamera& camera = rectification.camera;
  const Eigen::Vector2d centre(camera.cx_px, camera.cy_px);
  std::vector<rectify_check::RowMatch> matches;
  for (const int i : e.used_pairs) {
    const BoardPair& pair = seen.pairs[static_cast<size_t>(i)];
    const BoardView right = NumberedLike(board, pair.left, pair.right);
    for (size_t k = 0; k < pair.left.corners.size(); ++k) {
      const auto found = std::ranges::find(right.corners, pair.left.corners[k]);
      if (found == right.corners.end()) continue;
      const auto p = rectification.left.RectifiedPoint(pair.left.pixels[k]);
      const auto q =
          rectification.right.RectifiedPoint(right.pixels[static_cast<size_t>(found - right.corners.begin())]);
      if (p && q) matches.push_back({camera.f_px * *p + centre, camera.f_px * *q + centre});
    }
  }
  const rectify_check::RowErrors rows = rectify_check::MeasureRows(matches, camera);
  fmt::print("rectified rows of {} corners of these pictures agree to {:.3f} px (95 % to {:.3f} px): {}\n",
             rows.matches, rows.median_abs_px, rows.p95_abs_px, rectify_check::CheckRows(rows).sentence);
}

/// "camera" of "out/camera.yaml" is put in front.
std::string BesideOutput(const CalibrateOptions& o, const std::string& name) {
  const fs::path out(o.out);
  return (out.parent_path() / (out.stem().string() + name)).string();
}

bool IsRigFile(const std::string& path) {
  const std::string extension = fs::path(path).extension().string();
  return (extension == ".yaml" || extension == ".yml") && !fs::is_directory(path);
}

/// Returns whether two paths name one file, which need not exist yet.
bool IsSameFile(const fs::path& a, const fs::path& b) {
  return fs::weakly_canonical(fs::absolute(a)) == fs::weakly_canonical(fs::absolute(b));
}

void CheckOut(const CalibrateOptions& o, const fs::path& rig) {
  if (o.out.empty() || !IsSameFile(o.out, rig)) return;
  throw std::runtime_error(fmt::format("--out {} is the rig file itself: give another name", o.out));
}

int CalibrateFolder(const CalibrateOptions& o, const Board& board, const LiveRigFile* live);

int CalibrateLive(const CalibrateOptions& o, const Board& board) {
  const LiveRigFile live = ReadLiveRigFile(o.folder);
  if (o.out.empty()) throw std::runtime_error(o.folder + " names cameras (source): add --out camera.yaml");
  CheckOut(o, o.folder);
  CalibrateOptions of_folder = o;
  of_folder.folder = BesideOutput(o, "_pictures");
  TakeLivePictures(board, live, {of_folder.folder, BesideOutput(o, "_coverage.html"), o.seconds});
  return CalibrateFolder(of_folder, board, &live);
}

/// Calibrates from a folder of pictures, possibly of live pictures.
int CalibratePictures(const CalibrateOptions& o, const Board& board) {
  if (o.seconds > 0.0) throw std::runtime_error(o.folder + " is a folder: --seconds is for a rig file only");
  const fs::path rig = fs::path(o.folder) / kRigOfPictures;
  if (!fs::exists(rig)) return CalibrateFolder(o, board, nullptr);
  CheckOut(o, rig);
  const LiveRigFile live = ReadLiveRigFile(rig.string());
  return CalibrateFolder(o, board, &live);
}

int Calibrate(const CalibrateOptions& o) {
  const Board board = ParseBoard(o.board);
  if (!o.print_board.empty()) {
    WriteFileAtomically(o.print_board, BoardPdf(board));
    fmt::print(
        "{}: {} by {} {}; print at 100 % (no fit to page) on {}, measure a row and give the true size in --board\n",
        o.print_board, board.SquareColumns(), board.SquareRows(), BoardMeasure(board), PaperText(SheetFor(board)));
  }
  if (o.folder.empty()) {
    if (o.print_board.empty()) throw std::runtime_error("give a folder of pictures, or --print-board FILE");
    return 0;
  }
  return IsRigFile(o.folder) ? CalibrateLive(o, board) : CalibratePictures(o, board);
}

void WriteResult(const CalibrateOptions& o, RigCalibration rig, const LiveRigFile* live) {
  if (live != nullptr) {
    rig.name = live->name;
    rig.rate_hz = live->rate_hz;
    rig.left.T_b_cam = live->T_b_left;
    rig.right.T_b_cam = live->T_b_left * rig.right.T_b_cam;
  }
  WriteFileAtomically(o.out, CameraFileText(rig) + (live != nullptr ? live->source : ""));
  fmt::print("written: {}\n", o.out);
  const fs::path of_pictures = fs::path(o.folder) / "camera.yaml";
  if (live == nullptr || IsSameFile(o.out, of_pictures)) return;
  // So that the folder of pictures is a dataset, for rectify-check.
  if (!(rig.rate_hz > 0.0)) rig.rate_hz = 1.0;
  WriteFileAtomically(of_pictures.string(), CameraFileText(rig));
}

int CalibrateFolder(const CalibrateOptions& o, const Board& board, const LiveRigFile* live) {
  Seen seen = FindBoards(o.folder, board);
  if (static_cast<int>(seen.pairs.size()) > kMaxPairs) {
    std::vector<BoardPair> chosen;
    for (const int i : ChoosePairs(seen.pairs, seen.size, kMaxPairs)) {
      chosen.push_back(std::move(seen.pairs[static_cast<size_t>(i)]));
    }
    fmt::print("{} of {} pairs with a board are used, chosen for coverage\n", chosen.size(), seen.pairs.size());
    seen.pairs = std::move(chosen);
  }
  RigEstimate estimate = EstimateRig(board, seen.pairs, seen.size, o.model);
  estimate.rig.name = fs::path(o.folder).lexically_normal().filename().string();
  if (estimate.rig.name.empty()) estimate.rig.name = "camera";
  const std::string complaint = RigComplaint(estimate.rig);
  if (!complaint.empty())
    throw std::runtime_error(fmt::format("{}: the result cannot be used: {}", o.folder, complaint));
  fmt::print("{}: {} of {} pairs, {} corners ({} rejected), {} x {} px, model {}\n", BoardText(board),
             estimate.used_pairs.size(), seen.n_pictures / 2, estimate.used_corners, estimate.left_out_corners,
             seen.size.width_px, seen.size.height_px, o.model);
  if (!estimate.left_out_pairs.empty()) {
    fmt::print("rejected, because left and right were not taken at the same time: {}\n",
               fmt::join(estimate.left_out_pairs, ", "));
  }
  fmt::print("reprojection error {:.3f} px (root mean square of a coordinate)\n", estimate.noise_px);
  PrintParameters(estimate);
  PrintCoverage(estimate, seen);
  PrintRows(estimate, board, seen);
  if (!o.out.empty()) WriteResult(o, std::move(estimate.rig), live);
  return 0;
}

}  // namespace

void AddCalibrateCommand(CLI::App* app, std::function<int()>* command) {
  auto options = std::make_shared<CalibrateOptions>();
  auto* sub = app->add_subcommand("calibrate", "calibrates a stereo camera from pictures of a board");
  sub->add_option("folder", options->folder,
                  "folder with pictures in left and right, paired by their numbers; or a rig file with a source: "
                  "pictures are taken live and stored in a folder beside --out");
  sub->add_option("--seconds", options->seconds, "live: ends after this time [when no view is missing]")
      ->check(PositiveNumber());
  sub->add_option(
         "--board", options->board,
         "chess:COLUMNSxROWS:SQUARE (inner corners, metres), charuco:COLUMNSxROWS:SQUARE:MARKER (squares) or "
         "aprilgrid:COLUMNSxROWS:TAG:SPACING (tags; spacing in tags)")
      ->required();
  sub->add_option("--model", options->model, "lens model of both cameras")
      ->check(CLI::IsMember(
          {lens_model::kRadtan, lens_model::kRational, lens_model::kEquidistant, lens_model::kDoubleSphere}))
      ->capture_default_str();
  sub->add_option("--out", options->out, "camera.yaml to write [the result is only printed]")->type_name("FILE");
  sub->add_option("--print-board", options->print_board, "write the board as a PDF in the size to print")
      ->type_name("FILE");
  sub->footer(
      "Hold the board still, near and far, tilted, and into every corner of both images; 30 to 60 pairs are good.\n"
      "Examples:\n"
      "  plslam calibrate --board charuco:11x8:0.023:0.017 --print-board board.pdf\n"
      "  plslam calibrate rig.yaml --board charuco:11x8:0.023:0.017 --out camera.yaml\n"
      "  plslam calibrate pictures --board charuco:11x8:0.023:0.017 --out my_camera/camera.yaml\n"
      "  plslam calibrate pictures --board chess:9x6:0.025 --model equidistant --out my_camera/camera.yaml\n"
      "Exit code 0 if there is a result; plslam rectify-check then checks it on other pictures.");
  sub->callback([=] { *command = [options] { return Calibrate(*options); }; });
}

}  // namespace plslam::calibration
