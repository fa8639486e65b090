// SPDX-License-Identifier: BSD-3-Clause
#include "tools/rectify_check/rectify_check_command.h"
#include "tools/command_line/number_checks.h"

#include <algorithm>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "core/datasets/camera_file.h"
#include "core/datasets/open_dataset.h"
#include "core/features/feature_extractor.h"
#include "core/geometry/rectifier.h"
#include "core/io/images/png_codec.h"
#include "tools/rectify_check/length_error.h"
#include "tools/rectify_check/rectify_picture.h"
#include "tools/rectify_check/row_errors.h"

namespace plslam::rectify_check {
namespace {

struct CheckOptions {
  std::string dataset;
  std::string kind;
  std::vector<std::string> topics;
  std::string mask_left;
  std::string mask_right;
  std::string out = "rectify_check.png";
  int frame = -1;
  int frames = 5;
  bool quiet = false;
  bool json = false;
};

struct Pair {
  cv::Mat left;
  cv::Mat right;
  std::vector<RowMatch> matches;
};

class PairReader {
 public:
  PairReader(const Dataset& dataset, const RigCalibration& rig)
      : dataset_(dataset),
        rectifier_(rig),
        left_mask_(rectifier_.left_mask()),
        right_mask_(rectifier_.right_mask()),
        extractor_(PointsOnly()) {}

  const Rectifier& rectifier() const { return rectifier_; }

  Pair Read(int index) {
    const StereoImages images = dataset_.Read(index);
    Pair pair{rectifier_.RectifyLeft(images.left), rectifier_.RectifyRight(images.right), {}};
    ImageFeatures left = extractor_.Extract(pair.left), right = extractor_.Extract(pair.right);
    left_mask_.RemoveOutside(left);
    right_mask_.RemoveOutside(right);
    pair.matches = MatchAcrossRows(left, right, pair.left.rows);
    return pair;
  }

 private:
  static FeatureOptions PointsOnly() {
    FeatureOptions options;
    options.features = FeatureTypes::kPoints;
    return options;
  }

  const Dataset& dataset_;
  Rectifier rectifier_;
  FeatureMask left_mask_;
  FeatureMask right_mask_;
  FeatureExtractor extractor_;
};

/// `n` of `size` frames, evenly spread.
std::vector<int> SpreadFrames(int size, int n) {
  std::vector<int> frames;
  n = std::min(n, size);
  frames.reserve(static_cast<size_t>(n));
  for (int i = 0; i < n; ++i) frames.push_back(static_cast<int>((2LL * i + 1) * size / (2LL * n)));
  return frames;
}

void Print(const CheckOptions& o, const RowErrors& e, const std::optional<LengthError>& lengths,
           const RowVerdict& verdict, const Rectifier& rectifier) {
  const StereoCamera& camera = rectifier.camera();
  if (o.json) {
    nlohmann::ordered_json json = {{"usable", verdict.usable},
                                   {"verdict", verdict.sentence},
                                   {"picture", o.out},
                                   {"matches", e.matches},
                                   {"median_px", e.median_px},
                                   {"median_abs_px", e.median_abs_px},
                                   {"p95_abs_px", e.p95_abs_px},
                                   {"offset_px", e.offset_px},
                                   {"roll_deg", e.roll_deg},
                                   {"scale_percent", e.scale_percent},
                                   {"behind", e.behind},
                                   {"rectified_already", rectifier.IsIdentity()},
                                   {"focal_length_px", camera.f_px},
                                   {"baseline_m", camera.baseline_m}};
    if (lengths && lengths->percent) json["length_error_percent"] = *lengths->percent;
    if (lengths && lengths->tracked > 0) json["length_sigma_percent"] = lengths->sigma_percent;
    fmt::print("{}\n", json.dump(2));
    return;
  }
  fmt::print("{}\n", verdict.sentence);
  if (o.quiet) return;
  fmt::print("rectified camera: {} x {} px, focal length {:.1f} px, baseline {:.4f} m{}\n", camera.width_px,
             camera.height_px, camera.f_px, camera.baseline_m,
             rectifier.IsIdentity() ? " (the pair is assumed to be rectified)" : "");
  fmt::print("row errors of {} points: median {:+.2f} px, 95 % below {:.2f} px\n", e.matches, e.median_px,
             e.p95_abs_px);
  fmt::print("fitted: offset {:+.2f} px, roll {:+.3f} deg, scale {:+.3f} %\n", e.offset_px, e.roll_deg,
             e.scale_percent);
  fmt::print("picture: {}\n", o.out);
}

int Check(const CheckOptions& o) {
  if (NamesSource(o.dataset)) {
    throw std::runtime_error(
        fmt::format("{} names cameras (source): check the pictures taken by `plslam calibrate {} --out FILE`, or a "
                    "recording (`plslam run {} --record run.lcm`, `plslam rectify-check run.lcm`)",
                    o.dataset, o.dataset, o.dataset));
  }
  const auto dataset = OpenDatasetAndWarn(WithTopics(o.dataset, o.kind, o.topics), o.kind);
  if (dataset->rig().kind == RigCalibration::Kind::kRgbd) {
    throw std::runtime_error(o.dataset + ": a depth camera has no second image whose rows could be checked");
  }
  if (dataset->size() == 0) throw std::runtime_error(o.dataset + ": has no frames");
  const int shown = o.frame >= 0 ? o.frame : dataset->size() / 2;
  if (shown >= dataset->size()) {
    throw std::runtime_error(fmt::format("--frame {}: {} has {} frames", shown, o.dataset, dataset->size()));
  }
  RigCalibration rig = dataset->rig();
  if (!o.mask_left.empty()) AddMaskImage(o.mask_left, &rig.left);
  if (!o.mask_right.empty()) AddMaskImage(o.mask_right, &rig.right);
  PairReader reader(*dataset, rig);
  std::vector<RowMatch> all;
  std::optional<Pair> read;
  for (const int frame : SpreadFrames(dataset->size(), o.frames)) {
    Pair pair = reader.Read(frame);
    all.insert(all.end(), pair.matches.begin(), pair.matches.end());
    if (frame == shown) read = std::move(pair);
  }
  const RowErrors errors = MeasureRows(all, reader.rectifier().camera());
  RowVerdict verdict = CheckRows(errors);
  std::optional<LengthError> lengths;
  if (verdict.usable) {
    lengths = MeasureLengthError(*dataset, rig);
    verdict.sentence += "; " + Sentence(*lengths);
  }
  const Pair pair = read ? *std::move(read) : reader.Read(shown);
  WritePng(o.out,
           DrawRectification({pair.left, reader.rectifier().left_mask()},
                             {pair.right, reader.rectifier().right_mask()}, pair.matches,
                             fmt::format("frame {}, {} points, rows agree to {:.2f} px (95 %: {:.2f} px)", shown,
                                         pair.matches.size(), errors.median_abs_px, errors.p95_abs_px)));
  Print(o, errors, lengths, verdict, reader.rectifier());
  return verdict.usable ? 0 : 1;
}

}  // namespace

void AddRectifyCheckCommand(CLI::App* app, std::function<int()>* command) {
  auto options = std::make_shared<CheckOptions>();
  auto* sub = app->add_subcommand("rectify-check", "measures and draws how well a stereo calibration aligns rows");
  sub->add_option("dataset", options->dataset, DatasetHelp())->required();
  sub->add_option("--kind", options->kind, fmt::format("format: {} [recognised from its files]", DatasetKindHelp()));
  sub->add_option("--topics", options->topics, "LEFT RIGHT: image topics of a ROS recording [recognised by name]")
      ->type_name("TOPIC")
      ->expected(2);
  sub->add_option("--mask-left", options->mask_left,
                  "mask image like player.mask_left: black (0) is excluded, and shaded")
      ->type_name("FILE");
  sub->add_option("--mask-right", options->mask_right, "mask of the right camera, likewise")->type_name("FILE");
  sub->add_option("--out", options->out, "picture to write (PNG)")->type_name("FILE")->capture_default_str();
  sub->add_option("--frame", options->frame, "frame of the picture [the middle one]")->check(WholeNumberFrom(0));
  sub->add_option("--frames", options->frames, "number of measured frames, evenly spread")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  sub->add_flag("--quiet", options->quiet, "only the verdict");
  sub->add_flag("--json", options->json, "print verdict and numbers as JSON");
  sub->footer(
      "Points are matched by appearance only, so that rows that disagree are visible. In the picture each line "
      "should "
      "meet the\n"
      "same thing on both sides; green points agree to a pixel, red ones are off by more than two.\n"
      "An offset of the disparities, which rows do not show, is measured by tracking up to 200 frames.\n"
      "Examples:\n"
      "  plslam rectify-check my_camera --out my_camera.png\n"
      "  plslam rectify-check /data/euroc/MH_01 --frame 300 --json\n"
      "  plslam rectify-check walk.bag --topics /left/image_raw /right/image_raw\n"
      "Exit code 0 if rows agree to a pixel; 1 if they do not, or if there are too few points to judge.");
  sub->callback([=] { *command = [options] { return Check(*options); }; });
}

}  // namespace plslam::rectify_check
