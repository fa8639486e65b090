// SPDX-License-Identifier: BSD-3-Clause
#include "core/run/run_warnings.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <span>

#include "core/run/run_counters.h"

namespace plslam {
namespace {

using Numbers = std::vector<std::pair<std::string, double>>;

constexpr double kEnoughTracked_percent = 90.0;
/// With a good calibration, the right image has 60 to 90 % of the points of the left one; with exchanged images, 0.3 to
/// 8 %.
constexpr double kFewMatched = 0.15;
constexpr double kEnoughPoints = 2000.0;
/// Share of the left points with two equally good matches from which on texture is called repetitive: 0.00 to 0.02 in
/// ordinary scenes, 0.3 and more at fences and tiles.
constexpr double kManyAmbiguous = 0.15;
constexpr double kManyDark = 0.1;
/// A session that starts somewhere in its own map is recognised within a few frames. More frames than these, or a run
/// that ends with so many, are reported.
constexpr double kManyUnanchored = 0.2;
constexpr double kManyUnanchoredFrames = 60.0;
constexpr double kManyUnanchoredAtEnd = 10.0;
constexpr double kManySkipped = 0.01;
/// At 1 m/s, 1 mm of the baseline.
constexpr double kFarSkew_ms = 1.0;
// Share of the image below which dirt is not worth a warning.
constexpr double kLeastDirt_percent = 0.1;
/// The tracker corrects rows that differ by this; a calibration that is off by it costs accuracy nevertheless.
constexpr double kFarRows_px = 4.0;
/// Harmful change of lengths at the median depth, and the number of sigmas by which it must exceed zero. Near points
/// count more in a path: without correction, 2.1 % lengthen that of KITTI 03 by 1 %, and 15 % that of KITTI 01 by 10 %.
constexpr double kHarmfulLengths_percent = 5.0;
constexpr double kSureSigmas = 3.0;
/// Two unrelated paths are, after alignment, as far from each other as each extends.
constexpr double kOtherPath = 0.3;
/// The true path of a static camera is as long as the truth's own errors.
constexpr double kLeastOtherPath_m = 0.05;
/// Good runs have a NEES of 3 to 30 against recorded truth, which has errors itself; at this one, errors are 13 times
/// their standard deviation.
constexpr double kFarNees = 1e3;
constexpr int64_t kEnoughNees = 20;

double Count(int64_t n) { return static_cast<double>(n); }

/// For a shell.
std::string Quoted(const std::string& dataset) {
  return dataset.find_first_of(" ?&'\"$*") == std::string::npos ? dataset : "'" + dataset + "'";
}

std::string MetresText(double metres) {
  return std::isfinite(metres) ? fmt::format("{:.3g} m", metres) : "more than can be computed";
}

/// No player takes part, and the source is no dataset that another command could open.
bool IsOfSensors(const RunFindings& f) { return f.is_live || f.frames_captured > 0.0; }

std::string CheckText(const RunFindings& f) {
  if (IsOfSensors(f)) return "`plslam rectify-check` on a recording of it (--record run.lcm)";
  return fmt::format("`plslam rectify-check {}`", f.dataset.empty() ? "DATASET" : Quoted(f.dataset));
}

std::string PartsText(const FrameTally& t) {
  const std::pair<int64_t, const char*> parts[] = {{t.initialising, "initialising"},
                                                   {t.lost, "lost"},
                                                   {t.skipped, "skipped"},
                                                   {t.unreadable, "unreadable"},
                                                   {t.unanswered, "unanswered"}};
  std::string text;
  for (const auto& [n, name] : parts) {
    if (n > 0) text += fmt::format("{}{} {}", text.empty() ? "" : ", ", n, name);
  }
  return text;
}

/// Usual reasons why frames are not tracked, by the largest part of these frames.
std::string UsualReasons(const FrameTally& t) {
  if (t.unanswered > std::max(t.initialising, t.lost))
    return "vo_process did not answer them; its log has the reason";
  if (t.initialising > t.lost) {
    return "too few points had a depth to begin with; usual reasons are exchanged or dark images, a covered lens and "
           "a wrong calibration";
  }
  return "usual reasons are fast turns, blurred or dark images, a covered lens and walls without texture";
}

const char* CalibrationAdvice(const RunFindings& f) {
  return f.is_live ? "calibrate the cameras again" : "if the cameras are yours, calibrate them again";
}

bool IsOutOfStep(const RunFindings& f) { return f.right_late_ms > 0.0 || f.left_late_ms > 0.0; }

/// Frames that the tracker could process: skipped and unreadable ones have warnings of their own.
FrameTally Processed(const RunFindings& f) {
  FrameTally frames = f.frames;
  frames.skipped = frames.unreadable = 0;
  return frames;
}

bool AreLengthsOff(const RunFindings& f) {
  return f.length_error_percent > kHarmfulLengths_percent &&
         f.length_error_percent > kSureSigmas * f.length_sigma_percent;
}

bool HasFewStereoMatches(const RunFindings& f) {
  return f.points_seen >= kEnoughPoints && f.points_matched < kFewMatched * f.points_seen;
}

std::string FewStereoMatchesText(const RunFindings& f) {
  return fmt::format(
      "the right images have only {:.1f} % of the points of the left ones: left and right may be exchanged, not "
      "taken "
      "at the same time, or badly calibrated (check with {}), or each image shows rain, snow or dirt of its own",
      100.0 * f.points_matched / f.points_seen, CheckText(f));
}

std::string DirtText(const char* lens, double percent, double u_px, double v_px) {
  return fmt::format(
      "dirt on the {} lens, or text burnt into its images, covers {:.2g} % of the image, most of it near pixel "
      "({:.0f}, {:.0f}): features there are ignored; clean the lens, or mask the text",
      lens, percent, u_px, v_px);
}

/// "the right images are taken 93 ms after the left ones: ..." Beyond half a frame, other pairs are nearer in time;
/// from `SyncCheck::is_far_off` on, frames remain weak in spite of the compensation.
std::string OutOfStepText(const RunFindings& f) {
  const bool right = f.right_late_ms > 0.0;
  const int offset = static_cast<int>(std::lround(right ? -f.late_frames : f.late_frames));
  std::string remedy = "this is compensated, but trigger the cameras together";
  if (f.late_frames > kLargestCompensatedDelay_frames)
    remedy = "too much to be compensated: trigger the cameras together";
  if (offset != 0 && !IsOfSensors(f)) {
    remedy = fmt::format(
        "pair them again with `--set player.right_offset_frames={}`, or trigger the cameras together", offset);
  }
  return fmt::format("the {} images are taken {:.3g} ms after the {} ones: {}", right ? "right" : "left",
                     std::max(f.right_late_ms, f.left_late_ms), right ? "left" : "right", remedy);
}

bool IsBadlyExposed(const RunFindings& f) {
  return std::max(f.frames_overexposed, f.frames_underexposed) > kManyDark * f.frames_captured;
}

struct Row {
  const char* code;
  bool (*holds)(const RunFindings& f);
  std::string (*sentence)(const RunFindings& f);
  Numbers (*numbers)(const RunFindings& f);
};

Numbers FrameNumbers(const FrameTally& frames) {
  return {{"tracked", Count(frames.tracked)},
          {"all", Count(frames.all())},
          {"percent", frames.tracked_percent().value_or(0.0)}};
}

const Row kRows[] = {
    {"nothing_tracked", [](const RunFindings& f) { return f.frames.all() > 0 && f.frames.tracked == 0; },
     [](const RunFindings& f) {
       return fmt::format("none of the {} frames was tracked ({}): {}", f.frames.all(), PartsText(f.frames),
                          UsualReasons(f.frames));
     },
     [](const RunFindings& f) { return FrameNumbers(f.frames); }},
    {"little_tracked",
     [](const RunFindings& f) {
       return f.frames.tracked > 0 && *Processed(f).tracked_percent() < kEnoughTracked_percent;
     },
     [](const RunFindings& f) {
       const FrameTally frames = Processed(f);
       return fmt::format("only {} of {} frames were tracked ({:.1f} %; {}): {}", frames.tracked, frames.all(),
                          *frames.tracked_percent(), PartsText(frames), UsualReasons(frames));
     },
     [](const RunFindings& f) { return FrameNumbers(Processed(f)); }},
    {"not_in_map",
     [](const RunFindings& f) {
       return f.frames_unanchored > std::min(kManyUnanchored * Count(f.frames.answered()), kManyUnanchoredFrames) ||
              f.unanchored_now > kManyUnanchoredAtEnd;
     },
     [](const RunFindings& f) {
       return fmt::format(
           "{:.0f} of {} frames{} were not recognised in {}: until a session is recognised its poses have a frame of "
           "their own; is this the map of this place?",
           f.frames_unanchored, f.frames.answered(),
           f.unanchored_now > 0.0 ? fmt::format(", the last {:.0f} among them,", f.unanchored_now) : "",
           f.map.empty() ? "the map" : f.map);
     },
     [](const RunFindings& f) {
       return Numbers{{"unanchored", f.frames_unanchored}, {"all", Count(f.frames.answered())}};
     }},
    {"few_stereo_matches", HasFewStereoMatches, FewStereoMatchesText,
     [](const RunFindings& f) {
       return Numbers{{"points", f.points_seen}, {"matched", f.points_matched}};
     }},
    {"repeated_texture",
     [](const RunFindings& f) {
       return f.points_seen >= kEnoughPoints && f.points_ambiguous > kManyAmbiguous * f.points_seen;
     },
     [](const RunFindings& f) {
       return fmt::format(
           "{:.0f} % of the points have several equally good matches in their row (fences, tiles, containers): they "
           "get no depth, and tracking depends on the others",
           100.0 * f.points_ambiguous / f.points_seen);
     },
     [](const RunFindings& f) {
       return Numbers{{"points", f.points_seen}, {"ambiguous", f.points_ambiguous}};
     }},
    {"cameras_out_of_step", IsOutOfStep, OutOfStepText,
     [](const RunFindings& f) {
       return Numbers{{"right_late_ms", f.right_late_ms > 0.0 ? f.right_late_ms : -f.left_late_ms},
                      {"late_frames", f.late_frames}};
     }},
    {"readout_differs", [](const RunFindings& f) { return f.unequal_readout_ms > 0.0; },
     [](const RunFindings& f) {
       return fmt::format(
           "one of the cameras takes {:.3g} ms longer than the other to read an image (rolling shutter): use global "
           "shutters or two cameras of the same type",
           f.unequal_readout_ms);
     },
     [](const RunFindings& f) {
       return Numbers{{"unequal_readout_ms", f.unequal_readout_ms}};
     }},
    {"rolling_shutter", [](const RunFindings& f) { return f.readout_ms > 0.0; },
     [](const RunFindings& f) {
       return fmt::format(
           "the rows of an image are read within {0:.1f} ms (rolling shutter), in which the camera moves up to "
           "{1:.0f} "
           "mm: this is corrected, but only after it was found: state `readout_ms: {0:.1f}` in the calibration",
           f.readout_ms, f.readout_path_mm);
     },
     [](const RunFindings& f) {
       return Numbers{{"readout_ms", f.readout_ms}, {"path_mm", f.readout_path_mm}};
     }},
    {"readout_contradicted", [](const RunFindings& f) { return f.other_readout_ms > 0.0; },
     [](const RunFindings& f) {
       return fmt::format(
           "the images show that their rows are read within {:.1f} ms, which contradicts `readout_ms` of the "
           "calibration: measure it again",
           f.other_readout_ms);
     },
     [](const RunFindings& f) {
       return Numbers{{"readout_ms", f.other_readout_ms}};
     }},
    {"dirty_lens", [](const RunFindings& f) { return f.lens_dirt_percent > kLeastDirt_percent; },
     [](const RunFindings& f) { return DirtText("left", f.lens_dirt_percent, f.lens_dirt_u_px, f.lens_dirt_v_px); },
     [](const RunFindings& f) {
       return Numbers{{"percent", f.lens_dirt_percent}, {"u_px", f.lens_dirt_u_px}, {"v_px", f.lens_dirt_v_px}};
     }},
    {"dirty_right_lens", [](const RunFindings& f) { return f.right_lens_dirt_percent > kLeastDirt_percent; },
     [](const RunFindings& f) {
       return DirtText("right", f.right_lens_dirt_percent, f.right_lens_dirt_u_px, f.right_lens_dirt_v_px);
     },
     [](const RunFindings& f) {
       return Numbers{{"percent", f.right_lens_dirt_percent},
                      {"u_px", f.right_lens_dirt_u_px},
                      {"v_px", f.right_lens_dirt_v_px}};
     }},
    // If the cameras are out of step, rows differ by the motion between the two exposures until the offset is known.
    {"rows_corrected_far", [](const RunFindings& f) { return f.corner_rows_px > kFarRows_px && !IsOutOfStep(f); },
     [](const RunFindings& f) {
       return fmt::format(
           "rows of the right images differ from those of the left ones by up to {:.1f} px in the corners: this is "
           "corrected, but {}; measure it with {}",
           f.corner_rows_px, CalibrationAdvice(f), CheckText(f));
     },
     [](const RunFindings& f) {
       return Numbers{{"corner_rows_px", f.corner_rows_px}};
     }},
    {"disparities_off", AreLengthsOff,
     [](const RunFindings& f) {
       return fmt::format(
           "disparities have an offset that would change lengths at the median depth by {:.0f} % (sigma {:.1g} %): "
           "it is corrected while there is enough motion, but {}",
           f.length_error_percent, f.length_sigma_percent, CalibrationAdvice(f));
     },
     [](const RunFindings& f) {
       return Numbers{{"length_error_percent", f.length_error_percent},
                      {"length_sigma_percent", f.length_sigma_percent}};
     }},
    {"dark_images",
     [](const RunFindings& f) {
       return !IsBadlyExposed(f) && f.dark_frames > 0.0 && f.dark_frames > kManyDark * Count(f.frames.answered());
     },
     [](const RunFindings& f) {
       return fmt::format("{:.0f} of {} frames are nearly black: check exposure, light and lens", f.dark_frames,
                          f.frames.answered());
     },
     [](const RunFindings& f) {
       return Numbers{{"dark", f.dark_frames}, {"frames", Count(f.frames.answered())}};
     }},
    {"unreadable_frames", [](const RunFindings& f) { return f.frames.unreadable > 0; },
     [](const RunFindings& f) {
       return fmt::format("{} of {} frames could not be read and were skipped; logs/player.log lists them",
                          f.frames.unreadable, f.frames.all());
     },
     [](const RunFindings& f) {
       return Numbers{{"unreadable", Count(f.frames.unreadable)}, {"all", Count(f.frames.all())}};
     }},
    {"skipped_frames",
     [](const RunFindings& f) { return Count(f.frames.skipped) > kManySkipped * Count(f.frames.all()); },
     [](const RunFindings& f) {
       return fmt::format("{} of {} frames were skipped because tracking was slower than the {}", f.frames.skipped,
                          f.frames.all(),
                          f.is_live ? "sensor: use a lower frame rate, smaller images or a faster machine"
                                    : "data: use --pace lockstep, smaller images or a faster machine");
     },
     [](const RunFindings& f) {
       return Numbers{{"skipped", Count(f.frames.skipped)}, {"all", Count(f.frames.all())}};
     }},
    // At the pace of the data single pictures may be late, and the report counts them.
    {"missing_pictures",
     [](const RunFindings& f) { return f.pictures_missing > kManySkipped * Count(f.frames.all()); },
     [](const RunFindings& f) {
       return fmt::format(
           "{:.0f} of {} frames have no picture in the report, the film or the overlays, because viewer_headless was "
           "slower than the data or was killed (logs/viewer.log): use --pace lockstep, or less load on this machine",
           f.pictures_missing, f.frames.all());
     },
     [](const RunFindings& f) {
       return Numbers{{"missing", f.pictures_missing}};
     }},
    // A truth that covers only a part of the frames is common: of a room with motion capture, say.
    {"truth_of_other_times", [](const RunFindings& f) { return f.truth_missing > 0.0 && f.truth_frames == 0.0; },
     [](const RunFindings& f) {
       return fmt::format(
           "none of {:.0f} frames has a true pose although the dataset has a ground truth: its times differ, perhaps "
           "it is from another run; logs/player.log lists both time spans",
           f.truth_missing);
     },
     [](const RunFindings& f) {
       return Numbers{{"without_truth", f.truth_missing}};
     }},
    {"truth_of_another_run",
     [](const RunFindings& f) {
       if (!f.ate_m || *f.ate_m <= kLeastOtherPath_m) return false;
       return !std::isfinite(*f.ate_m) || *f.ate_m > kOtherPath * f.true_spread_m;
     },
     [](const RunFindings& f) {
       return fmt::format(
           "the path is off by {} (ATE) while the true one extends over {}: the ground truth is from another run or "
           "another camera, or tracking failed",
           MetresText(*f.ate_m), MetresText(f.true_spread_m));
     },
     [](const RunFindings& f) {
       return Numbers{{"ate_m", *f.ate_m}, {"true_spread_m", f.true_spread_m}};
     }},
    {"covariance_not_consistent",
     [](const RunFindings& f) { return f.nees_poses >= kEnoughNees && f.nees_pose > kFarNees; },
     [](const RunFindings& f) {
       return fmt::format(
           "errors are about {:.0f} times larger than the covariances state (mean NEES {:.3g}, 6 is "
           "expected): do not rely on the covariances, or on the ground truth",
           std::sqrt(f.nees_pose / 6.0), f.nees_pose);
     },
     [](const RunFindings& f) {
       return Numbers{{"nees", f.nees_pose}, {"poses", Count(f.nees_poses)}};
     }},
    {"recording_without_index", [](const RunFindings& f) { return f.recording_scan_s > 0.0; },
     [](const RunFindings& f) {
       return fmt::format(
           "the recording has no usable index, or is truncated: it was first read completely, which took {:.1f} s, "
           "and incomplete parts are not played; logs/player.log gives details, and how to write an index",
           f.recording_scan_s);
     },
     [](const RunFindings& f) {
       return Numbers{{"scan_s", f.recording_scan_s}};
     }},
    {"recording_in_parts", [](const RunFindings& f) { return f.recordings.size() > 1; },
     [](const RunFindings& f) {
       std::string others;
       for (size_t i = 1; i < f.recordings.size(); ++i) others += (i > 1 ? ", " : "") + f.recordings[i];
       return fmt::format(
           "the recorder was restarted, so the recording of {} continues in {}; messages in between are in neither",
           f.recordings.front(), others);
     },
     [](const RunFindings& f) {
       return Numbers{{"files", static_cast<double>(f.recordings.size())}};
     }},
};

/// Of live cameras.
const Row kCameraRows[] = {
    {"cameras_skewed", [](const RunFindings& f) { return f.skew_ms > kFarSkew_ms; },
     [](const RunFindings& f) {
       return fmt::format(
           "left and right images are taken {:.1f} ms apart (median): trigger the cameras together, or one by the "
           "other",
           f.skew_ms);
     },
     [](const RunFindings& f) {
       return Numbers{{"skew_ms", f.skew_ms}};
     }},
    {"camera_frames_missing",
     [](const RunFindings& f) {
       return f.frames_missing + f.frames_dropped > kManySkipped * (f.frames_captured + f.frames_missing);
     },
     [](const RunFindings& f) {
       return fmt::format(
           "besides the {:.0f} pairs from the cameras, {:.0f} are missing, and {:.0f} images have no partner: check "
           "cables, the bandwidth of USB or network, long exposures and other load on this machine",
           f.frames_captured, f.frames_missing, f.frames_dropped);
     },
     [](const RunFindings& f) {
       return Numbers{
           {"captured", f.frames_captured}, {"missing", f.frames_missing}, {"without_partner", f.frames_dropped}};
     }},
    {"badly_exposed", IsBadlyExposed,
     [](const RunFindings& f) {
       return fmt::format(
           "of {:.0f} pairs of images, {:.0f} are mostly white and {:.0f} mostly black: set exposure and gain of the "
           "cameras",
           f.frames_captured, f.frames_overexposed, f.frames_underexposed);
     },
     [](const RunFindings& f) {
       return Numbers{
           {"captured", f.frames_captured}, {"white", f.frames_overexposed}, {"black", f.frames_underexposed}};
     }},
    {"camera_outages", [](const RunFindings& f) { return f.outages > 0.0; },
     [](const RunFindings& f) {
       return fmt::format(
           "the cameras sent no frames for a while, {:.0f} time{}: check cables and power; logs/camera.log gives "
           "details",
           f.outages, f.outages > 1.0 ? "s" : "");
     },
     [](const RunFindings& f) {
       return Numbers{{"outages", f.outages}};
     }},
};

void AddWarnings(std::span<const Row> rows, const RunFindings& findings, std::vector<RunWarning>* warnings) {
  for (const Row& row : rows) {
    if (row.holds(findings)) warnings->push_back({row.code, row.sentence(findings), row.numbers(findings)});
  }
}

}  // namespace

void RunFindings::Take(const RunCounters& counters) {
  points_seen = counters.Sum(kPointsSeen);
  points_matched = counters.Sum(kPointsMatched);
  points_ambiguous = counters.Sum(kPointsAmbiguous);
  dark_frames = counters.Sum(kFramesDark);
  corner_rows_px = counters.Largest(kCornerRows);
  right_late_ms = counters.Largest(kRightLate);
  left_late_ms = counters.Largest(kLeftLate);
  late_frames = counters.Largest(kLateFrames);
  unequal_readout_ms = counters.Largest(kUnequalReadout);
  readout_ms = counters.Largest(kReadout);
  readout_path_mm = counters.Largest(kReadoutPath);
  other_readout_ms = counters.Largest(kOtherReadout);
  lens_dirt_percent = counters.Largest(kLensDirt);
  lens_dirt_u_px = counters.Largest(kLensDirtColumn);
  lens_dirt_v_px = counters.Largest(kLensDirtRow);
  right_lens_dirt_percent = counters.Largest(kRightLensDirt);
  right_lens_dirt_u_px = counters.Largest(kRightLensDirtColumn);
  right_lens_dirt_v_px = counters.Largest(kRightLensDirtRow);
  length_error_percent = counters.Largest(kLengthError);
  length_sigma_percent = counters.Largest(kLengthSigma);
  truth_frames = counters.Sum(kTruthFrames);
  truth_missing = counters.Sum(kTruthMissing);
  pictures_missing = counters.Largest(kPicturesMissing);
  is_live = counters.Largest(kLiveSource) > 0.0;
  frames_captured = counters.Sum(kFramesCaptured);
  skew_ms = counters.Largest(kSkew);
  frames_missing = counters.Sum(kFramesMissing);
  frames_dropped = counters.Sum(kDroppedLeft) + counters.Sum(kDroppedRight);
  frames_overexposed = counters.Sum(kOverexposed);
  frames_underexposed = counters.Sum(kUnderexposed);
  outages = counters.Sum(kOutages);
  recording_scan_s = counters.Largest(kRecordingScan);
  frames_unanchored = counters.Sum(kFramesUnanchored);
  unanchored_now = counters.Largest(kUnanchoredNow);
}

nlohmann::ordered_json ToJson(const RunWarning& warning) {
  nlohmann::ordered_json numbers = nlohmann::ordered_json::object();
  for (const auto& [name, value] : warning.numbers) numbers[name] = value;
  return {{"code", warning.code}, {"sentence", warning.sentence}, {"numbers", numbers}};
}

std::vector<RunWarning> WarningsOf(const RunFindings& findings) {
  std::vector<RunWarning> warnings;
  AddWarnings(kRows, findings, &warnings);
  AddWarnings(kCameraRows, findings, &warnings);
  warnings.insert(warnings.end(), findings.published.begin(), findings.published.end());
  return warnings;
}

std::vector<RunWarning> CameraWarningsOf(const RunFindings& findings) {
  std::vector<RunWarning> warnings;
  AddWarnings(kCameraRows, findings, &warnings);
  return warnings;
}

std::vector<std::string> WarningCodes() {
  std::vector<std::string> codes;
  for (const Row& row : kRows) codes.emplace_back(row.code);
  for (const Row& row : kCameraRows) codes.emplace_back(row.code);
  return codes;
}

}  // namespace plslam
