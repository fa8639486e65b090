// SPDX-License-Identifier: BSD-3-Clause
#include "tools/calibration/node/live_pictures.h"

#include <unistd.h>

#include <atomic>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <optional>
#include <stdexcept>
#include <thread>
#include <vector>

#include <fmt/format.h>

#include "core/bus/bus.h"
#include "core/bus/messages/frame_channel.h"
#include "core/bus/run_loop.h"
#include "core/errors/error_text.h"
#include "core/errors/standard_streams.h"
#include "core/files/atomic_file.h"
#include "core/files/shared_file.h"
#include "core/io/images/png_codec.h"
#include "core/process/process_signals.h"
#include "core/run/process_names.h"
#include "tools/calibration/board_faults.h"
#include "tools/calibration/live/coverage_page.h"
#include "tools/calibration/live/picture_taker.h"
#include "tools/launch/child_process.h"
#include "tools/launch/run_bus.h"
#include "tools/launch/supervisor.h"

namespace plslam::calibration {
namespace {

namespace fs = std::filesystem;

constexpr std::chrono::milliseconds kTick(100);
constexpr double kPatienceAtTheEnd_s = 5.0;
/// Cameras without any image for this time count as started.
constexpr double kPatienceForFrames_s = 10.0;
/// Number of images before a fault of the board is reported.
constexpr int kLooksForAFault = 20;

/// Runs the process `camera` until the end of the scope.
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

  /// Returns false if its source has ended. Throws its last sentence if it has failed.
  bool Runs() {
    const auto exit = process_.Poll();
    if (exit && exit->code != 0) {
      const std::string how = fmt::format("{} {}", process_name::kCamera, launcher::ExitText(*exit));
      const std::string last_word = launcher::LastLine(log_);
      throw std::runtime_error(
          fmt::format("{}{}{} (its log: {})", how, last_word.empty() ? "" : ": ", last_word, log_.string()));
    }
    return !exit.has_value();
  }

 private:
  fs::path log_;
  launcher::ChildProcess process_;
};

/// A folder for pictures. If no picture is taken, the files in it that were created here are removed again, and the
/// folder too unless it has other content.
class PictureFolder {
 public:
  explicit PictureFolder(fs::path folder) : folder_(std::move(folder)) {
    for (const char* side : {"left", "right"}) {
      fs::create_directories(folder_ / side);
      if (fs::is_empty(folder_ / side)) continue;
      throw std::runtime_error(
          fmt::format("{0}: already contains pictures: `plslam calibrate {0}` uses them, or remove the folder",
                      folder_.string()));
    }
    fs::remove(log());
  }
  ~PictureFolder() {
    std::error_code ignored;
    if (!fs::is_empty(folder_ / "left", ignored)) return;
    if (!keeps_log_) fs::remove(log(), ignored);
    for (const fs::path& made : {rig(), folder_ / "left", folder_ / "right", folder_}) fs::remove(made, ignored);
  }
  PictureFolder(const PictureFolder&) = delete;
  PictureFolder& operator=(const PictureFolder&) = delete;

  fs::path rig() const { return folder_ / kRigOfPictures; }
  fs::path log() const { return folder_ / "camera.log"; }
  void KeepLog() { keeps_log_ = true; }

 private:
  fs::path folder_;
  bool keeps_log_ = false;
};

/// Faults of a board that gives no pictures, found in a session's images: each is reported once.
class BoardWatch {
 public:
  explicit BoardWatch(const Board& board) : board_(board), faults_(board) {}

  void Look(const StereoImages& images, const BoardView& left, const BoardView& right) {
    const bool in_left = !left.corners.empty(), in_right = !right.corners.empty();
    ++looks_;
    last_images_ = images;
    if (in_left || in_right || left.contradicts || right.contradicts) {
      ++looks_at_board_;
      faults_.Count(left);
      faults_.Count(right);
      in_both_ += in_left && in_right ? 1 : 0;
      in_left_ += in_left ? 1 : 0;
    }
    const int looks = looks_at_board_ > 0 ? looks_at_board_ : looks_;
    if (!fault_.empty() || looks % kLooksForAFault != 0) return;
    fault_ = Fault();
    if (!fault_.empty()) fmt::print("{}\n", fault_);
    std::fflush(stdout);
  }

  /// A sentence after the last image, also of a short or slow session; empty if the only fault is that no board was
  /// static.
  std::string FaultAtTheEnd() const { return fault_.empty() && looks_ > 0 ? Fault() : fault_; }

 private:
  std::string Fault() const {
    if (std::string contradiction = faults_.Contradiction(); !contradiction.empty()) return contradiction;
    if (looks_at_board_ == 0) {
      const std::string other = OtherSizeSeen(board_, last_images_.left);
      return other.empty() ? "" : fmt::format("the board {} is not seen{}", BoardText(board_), other);
    }
    if (in_both_ > 0) return "";
    return fmt::format("the board is seen only by the {} camera: hold it where both see it",
                       in_left_ == 0                ? "right"
                       : in_left_ < looks_at_board_ ? "left or the right"
                                                    : "left");
  }

  Board board_;
  BoardFaults faults_;
  int looks_ = 0, looks_at_board_ = 0, in_both_ = 0, in_left_ = 0;
  StereoImages last_images_;
  std::string fault_;
};

class LiveSession {
 public:
  LiveSession(const Board& board, const ImageSize& size, const LiveOptions& options)
      : board_(board), options_(options), taker_(board, size), watch_(board) {
    WritePage(true);
  }

  void Look(const StereoImages& images) {
    if (!first_frame_s_) first_frame_s_ = bus::NowS();
    const BoardView left = FindBoard(board_, images.left), right = FindBoard(board_, images.right);
    watch_.Look(images, left, right);
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
  /// Pairs that are written whole.
  int pictures() const { return static_cast<int>(pictures_.size()); }
  std::optional<double> first_frame_s() const { return first_frame_s_; }
  std::string FaultAtTheEnd() const { return watch_.FaultAtTheEnd(); }

 private:
  Board board_;
  LiveOptions options_;
  PictureTaker taker_;
  BoardWatch watch_;
  std::vector<std::string> pictures_;
  std::optional<double> first_frame_s_;
};

/// Runs `f`; returns the sentence of its exception, or an empty string.
std::string FailureOf(const std::function<void()>& f) {
  try {
    f();
  } catch (const std::exception& error) {
    return SentenceOf(error);
  }
  return "";
}

std::string WhyNoPicture(const Board& board, const LiveSession& session, double took_s) {
  if (!session.first_frame_s()) return fmt::format("the cameras sent no images within {:.1f} s", took_s);
  if (std::string fault = session.FaultAtTheEnd(); !fault.empty()) return fault;
  return fmt::format("the board {} was never held still", BoardText(board));
}

}  // namespace

void TakeLivePictures(const Board& board, const LiveRigFile& rig, const LiveOptions& options) {
  const fs::path camera = ProgramFolder() / process_name::kCamera;
  if (access(camera.c_str(), X_OK) != 0) {
    throw std::runtime_error(
        fmt::format("the program {} is missing: 'scripts/build release' builds it, with libgstreamer1.0-dev and "
                    "libgstreamer-plugins-base1.0-dev",
                    camera.string()));
  }
  PictureFolder folder(options.folder);
  WriteFileAtomically(folder.rig().string(), rig.for_camera);

  std::atomic<bool> stopped = false;
  // Before anything that starts threads, which must inherit the blocked signals.
  const bus::SignalWatcher signals([&](const std::string&) { stopped = true; });
  const launcher::RunBus run_bus("");
  bus::BusOptions bus_options;
  bus_options.url = run_bus.url();
  bus::Bus bus(bus_options, "plslam");
  LiveSession session(board, rig.size, options);
  const bus::FrameSubscriber frames(bus, bus::FrameSubscriber::Mode::kReliable,
                                    [&](const auto& frame) { session.Look(frame.images); });
  fmt::print(
      "hold the board still at one position after another; Ctrl-C ends the recording. {} shows the coverage.\n",
      options.page);
  std::fflush(stdout);
  CameraChild child(folder.rig(), run_bus.url(), folder.log());
  const double begin_s = bus::NowS();
  bus.Every(kTick, [&] {
    const double count_from_s = session.first_frame_s().value_or(begin_s + kPatienceForFrames_s);
    const bool is_late = options.seconds > 0.0 && bus::NowS() - count_from_s > options.seconds;
    if (stopped || is_late || session.is_complete() || !child.Runs()) bus.Stop();
  });
  const std::string failure = FailureOf([&] { bus.Run(); });
  const std::string failure_of_page = FailureOf([&] { session.WritePage(false); });
  if (session.pictures() == 0) {
    if (!failure.empty()) folder.KeepLog();
    throw std::runtime_error(!failure.empty() ? failure : WhyNoPicture(board, session, bus::NowS() - begin_s));
  }
  for (const std::string& warning : {failure, failure_of_page}) {
    if (!warning.empty()) PrintError("plslam: warning: " + warning);
  }
  fmt::print("{} pictures are kept in {}\n", session.pictures(), options.folder);
  std::fflush(stdout);
}

}  // namespace plslam::calibration
