// SPDX-License-Identifier: BSD-3-Clause
#include "tools/calibration/node/live_pictures.h"

#include <unistd.h>

#include <atomic>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <stdexcept>
#include <thread>
#include <vector>

#include <fmt/format.h>

#include "core/bus/bus.h"
#include "core/bus/messages/frame_channel.h"
#include "core/bus/run_loop.h"
#include "core/io/files/atomic_file.h"
#include "core/io/files/shared_file.h"
#include "core/io/images/png_codec.h"
#include "core/process/process_signals.h"
#include "core/run/process_names.h"
#include "tools/calibration/live/coverage_page.h"
#include "tools/calibration/live/picture_taker.h"
#include "tools/plslam/child_process.h"
#include "tools/plslam/run_bus.h"
#include "tools/plslam/supervisor.h"

namespace plslam::calibration {
namespace {

namespace fs = std::filesystem;

constexpr std::chrono::milliseconds kTick(100);
constexpr double kPatienceAtTheEnd_s = 5.0;

/// The process `camera` until the end of the scope.
class CameraChild {
 public:
  CameraChild(const fs::path& rig, const std::string& url, const fs::path& log)
      : log_(log),
        process_(ProgramFolder() / process_name::kCamera,
                 {rig.string(), "--url", url, "--exit", "--parent", std::to_string(getpid())}, log, 0,
                 launcher::EndedBy::kLauncher) {}
  ~CameraChild() {
    if (process_.Poll()) return;
    process_.Signal(bus::kStopOrder);
    const double end_s = bus::NowS() + kPatienceAtTheEnd_s;
    while (!process_.Poll() && bus::NowS() < end_s) std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  CameraChild(const CameraChild&) = delete;
  CameraChild& operator=(const CameraChild&) = delete;

  /// False where its source has ended. Throws where it has failed.
  bool Runs() {
    const auto exit = process_.Poll();
    if (exit && exit->code != 0) throw std::runtime_error(launcher::LastLine(log_));
    return !exit.has_value();
  }

 private:
  fs::path log_;
  launcher::ChildProcess process_;
};

/// A new folder for pictures, which goes again where none is taken.
class PictureFolder {
 public:
  explicit PictureFolder(fs::path folder) : folder_(std::move(folder)) {
    for (const char* side : {"left", "right"}) fs::create_directories(folder_ / side);
  }
  ~PictureFolder() {
    std::error_code ignored;
    if (fs::is_empty(folder_ / "left", ignored)) fs::remove_all(folder_, ignored);
  }
  PictureFolder(const PictureFolder&) = delete;
  PictureFolder& operator=(const PictureFolder&) = delete;

 private:
  fs::path folder_;
};

class LiveSession {
 public:
  LiveSession(const Board& board, const ImageSize& size, const LiveOptions& options)
      : board_(board), options_(options), taker_(board, size) {
    WritePage(true);
  }

  void Look(const StereoImages& images) {
    const BoardView left = FindBoard(board_, images.left), right = FindBoard(board_, images.right);
    if (!taker_.Add(left, right, 1e-9 * static_cast<double>(images.t_ns))) return;
    const std::string name = fmt::format("{:03}.png", taker_.pictures());
    WritePng((fs::path(options_.folder) / "left" / name).string(), images.left, 1);
    WritePng((fs::path(options_.folder) / "right" / name).string(), images.right, 1);
    pictures_.push_back((fs::path(options_.folder).filename() / "left" / name).string());
    const std::vector<std::string> missing = taker_.Missing();
    fmt::print("picture {}: {}\n", taker_.pictures(), missing.empty() ? "no view is missing" : missing.front());
    std::fflush(stdout);
    WritePage(true);
  }

  void WritePage(bool is_running) const {
    WriteFileAtomically(options_.page, CoveragePage(taker_, pictures_, is_running));
  }
  bool is_complete() const { return taker_.Missing().empty(); }
  int pictures() const { return taker_.pictures(); }

 private:
  Board board_;
  LiveOptions options_;
  PictureTaker taker_;
  std::vector<std::string> pictures_;
};

}  // namespace

int TakeLivePictures(const Board& board, const LiveRigFile& rig, const LiveOptions& options) {
  const fs::path folder(options.folder);
  if (fs::exists(folder)) {
    throw std::runtime_error(fmt::format(
        "{0}: there are pictures already: `plslam calibrate {0}` takes them, or remove the folder", options.folder));
  }
  const fs::path camera = ProgramFolder() / process_name::kCamera;
  if (access(camera.c_str(), X_OK) != 0) {
    throw std::runtime_error(fmt::format(
        "there is no program {}: install libgstreamer1.0-dev and libgstreamer-plugins-base1.0-dev, and build again",
        camera.string()));
  }
  const PictureFolder made(folder);
  const fs::path rig_path = folder / "camera.rig.yaml";
  WriteFileAtomically(rig_path.string(), rig.for_camera);

  const launcher::RunBus run_bus("");
  bus::BusOptions bus_options;
  bus_options.url = run_bus.url();
  std::atomic<bool> stopped = false;
  const bus::SignalWatcher signals([&](const std::string&) { stopped = true; });
  bus::Bus bus(bus_options, "plslam");
  LiveSession session(board, rig.size, options);
  const bus::FrameSubscriber frames(bus, bus::FrameSubscriber::Mode::kReliable,
                                    [&](const auto& frame) { session.Look(frame.images); });
  fmt::print("hold the board still, again and again elsewhere; Ctrl-C ends it. {} shows what is there.\n",
             options.page);
  std::fflush(stdout);
  CameraChild child(rig_path, run_bus.url(), folder / "camera.log");
  const double begin_s = bus::NowS();
  bus.Every(kTick, [&] {
    const bool is_late = options.seconds > 0.0 && bus::NowS() - begin_s > options.seconds;
    if (stopped || is_late || session.is_complete() || !child.Runs()) bus.Stop();
  });
  bus.Run();
  session.WritePage(false);
  return session.pictures();
}

}  // namespace plslam::calibration
