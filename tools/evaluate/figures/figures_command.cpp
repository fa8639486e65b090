// SPDX-License-Identifier: BSD-3-Clause
#include "tools/evaluate/evaluate_commands.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <stdexcept>

#include "core/datasets/open_dataset.h"
#include "core/files/shared_file.h"
#include "core/io/maps/map_camera.h"
#include "core/run/result_files.h"
#include "core/run/run.h"
#include "tools/command_line/run_command_line.h"
#include "tools/evaluate/accuracy.h"
#include "tools/evaluate/figures/pair_figure.h"
#include "tools/evaluate/figures/runtime_figure.h"
#include "tools/evaluate/figures/top_view.h"
#include "tools/evaluate/places/similarity_figure.h"
#include "tools/export/keyframe_images.h"

namespace plslam::evaluate {
namespace {

namespace fs = std::filesystem;

struct Arguments {
  std::string run;
  std::string map;
  std::string dataset;
  std::string out;
  std::string title;
  std::vector<int64_t> pair;
  std::string points = "orb.vocabulary";
  std::string lines = "lbd.vocabulary";
};

/// A run with the attributes of its figures.
struct Material {
  Run run;
  std::string dataset;
  std::string title;
  std::string out;

  bool HasMap() const { return run.map && !run.map->map.keyframes().empty(); }
};

void AddOptions(CLI::App& app, Arguments& a) {
  app.add_option("run", a.run, "folder of a run")->required();
  app.add_option("--map", a.map, "map of the run [the .plmap in its folder]")->type_name("FILE");
  app.add_option("--dataset", a.dataset, "dataset with the images [the dataset in the run's summary]");
  app.add_option("--out", a.out, "folder for the figures [RUN/figures]")->type_name("DIR");
  app.add_option("--title", a.title, "title of all figures [the dataset's name]");
  app.add_option("--pair", a.pair, "two keyframes of the map to show [those of a loop, else neighbours]")
      ->expected(2);
  app.add_option("--points", a.points,
                 "vocabulary of points, for the similarities: a path, or a file installed with the programs")
      ->capture_default_str();
  app.add_option("--lines", a.lines, "vocabulary of lines, likewise")->capture_default_str();
}

/// "kitti_03" of a folder, "street" of a built-in world.
std::string LastPart(const std::string& location) {
  const std::string world = "synthetic:";
  if (location.starts_with(world)) return location.substr(world.size(), location.find('?') - world.size());
  const fs::path path = fs::path(location).lexically_normal();
  return path.filename().empty() ? path.parent_path().filename().string() : path.filename().string();
}

Material Collect(const Arguments& a) {
  if (!fs::is_directory(a.run)) throw std::runtime_error(a.run + ": is not the folder of a run");
  constexpr unsigned kContent =
      run_content::kSummary | run_content::kTrajectory | run_content::kTruth | run_content::kMap;
  Material m{ReadRun(a.run, kContent, a.map), a.dataset, a.title, a.out};
  if (m.dataset.empty() && m.run.summary) m.dataset = m.run.summary->value("dataset", "");
  if (m.title.empty()) m.title = LastPart(m.dataset.empty() ? a.run : m.dataset);
  if (m.out.empty()) m.out = (fs::path(a.run) / "figures").string();
  fs::create_directories(m.out);
  return m;
}

void Write(const Drawing& drawing, const std::string& name, const Material& m) {
  for (const char* ending : {".svg", ".pdf", ".png"}) WriteDrawing(m.out + "/" + name + ending, drawing);
  fmt::print("{}/{}.svg, .pdf, .png\n", m.out, name);
}

void Skip(const std::string& name, const std::string& why) { fmt::print("{}: skipped: {}\n", name, why); }

void DrawTopView(const Material& m) {
  if (!m.run.has_poses()) return Skip("top_view", fmt::format("the run has no {}", result_file::kTrajectory.tum));
  const Trajectory& estimate = *m.run.trajectory;
  const Trajectory truth = m.run.truth.value_or(Trajectory());
  const Accuracy accuracy = EvaluateTrajectory(estimate, truth, EvaluateOptions{});
  std::vector<NamedPath> paths;
  std::string title = m.title;
  if (!accuracy.pairs.empty()) {
    const SE3 T_w_truth = accuracy.alignment.T_a_b.Inverse();
    paths.push_back({"truth", PositionsOf(truth, T_w_truth), {{214, 39, 40}, 1.6, false}});
    title += fmt::format(": ATE {:.3g} m", accuracy.ate_m.rmse);
  }
  paths.push_back({"estimate (o start)", PositionsOf(estimate), {{31, 80, 180}, 0.9, false}});
  Write(TopView(title, paths, m.HasMap() ? &m.run.map->map : nullptr), "top_view", m);
}

void DrawCovisibility(const Material& m) {
  if (!m.HasMap()) return Skip("covisibility", "the run has no map (plslam run --save-map)");
  const MapTotals totals = m.run.map->map.Totals();
  const std::string title = fmt::format("{}: {} keyframes, {} loops", m.title, totals.keyframes, totals.loops);
  Write(CovisibilityFigure(title, m.run.map->map), "covisibility", m);
}

void DrawSimilarity(const Material& m, const Arguments& a) {
  if (!m.HasMap()) return Skip("similarity", "the run has no map (plslam run --save-map)");
  const std::string points = FindSharedFile(a.points), lines = FindSharedFile(a.lines);
  if (!fs::exists(points) || !fs::exists(lines)) {
    return Skip("similarity", fmt::format("the vocabularies {} and {} are missing", a.points, a.lines));
  }
  const std::string title = m.title + ": similarity of keyframes";
  const PlaceRecogniser recogniser(Vocabulary::Load(points), Vocabulary::Load(lines), PlaceOptions{});
  Write(SimilarityFigure(title, KeyframeSimilarities(*m.run.map, recogniser), "keyframes"), "similarity", m);
}

std::pair<KeyframeId, KeyframeId> PairOf(const Arguments& a, const Map& map) {
  if (!a.pair.empty()) {
    for (const KeyframeId id : IdsFrom<KeyframeId>(a.pair)) {
      if (map.FindKeyframe(id) == nullptr) throw std::runtime_error(fmt::format("the map has no keyframe {}", id));
    }
    return {KeyframeId(a.pair[0]), KeyframeId(a.pair[1])};
  }
  return PairWorthShowing(map).value_or(std::pair<KeyframeId, KeyframeId>());
}

void DrawPair(const Material& m, const Arguments& a) {
  if (!m.HasMap()) return Skip("keyframe_pair", "the run has no map (plslam run --save-map)");
  const StoredMap& stored = *m.run.map;
  const auto [first, second] = PairOf(a, stored.map);
  if (first < 0) return Skip("keyframe_pair", "no two keyframes share a landmark");
  if (!stored.features.contains(first) || !stored.features.contains(second)) {
    return Skip("keyframe_pair", "the map has no features of the keyframes");
  }
  const auto shown = [&](const exports::KeyframeImages& images, KeyframeId id) -> std::optional<PairedImage> {
    const MapKeyframe& keyframe = stored.map.keyframes().at(id);
    const auto image = images.At(keyframe.t_ns);
    if (!image) return std::nullopt;
    return PairedImage{fmt::format("keyframe {}, frame {}", id, keyframe.frame_id), *image, &stored.features.at(id)};
  };
  try {
    const exports::KeyframeImages images(OpenDatasetAndWarn(m.dataset, ""), MapCamera(stored, m.run.map_path));
    const auto a_shown = shown(images, first), b_shown = shown(images, second);
    if (!a_shown || !b_shown) return Skip("keyframe_pair", m.dataset + " has no images at these times");
    Write(PairFigure(m.title, *a_shown, *b_shown, SharedBy(stored.map, first, second)), "keyframe_pair", m);
  } catch (const std::runtime_error& e) {
    Skip("keyframe_pair", e.what());
  }
}

void DrawRuntime(const Material& m) {
  if (!m.run.summary || m.run.summary->empty()) {
    return Skip("runtime", fmt::format("the run has no {}", result_file::kSummary));
  }
  Write(RuntimeFigure(m.title, *m.run.summary), "runtime", m);
}

int DrawFigures(const Arguments& a) {
  const Material material = Collect(a);
  DrawTopView(material);
  DrawCovisibility(material);
  DrawSimilarity(material, a);
  DrawPair(material, a);
  DrawRuntime(material);
  return 0;
}

}  // namespace

int RunEvaluateFigures(int argc, char** argv) {
  CLI::App app("Draws figures of a run for print, as SVG, PDF and PNG. They are described in docs/metrics.md.",
               "evaluate figures");
  Arguments arguments;
  AddOptions(app, arguments);
  app.footer(
      "Example:\n  plslam run synthetic:room --out out/room --save-map out/room/map.plmap\n"
      "  evaluate figures out/room");
  return RunCommandLine(app, argc, argv, [&] { return DrawFigures(arguments); });
}

}  // namespace plslam::evaluate
