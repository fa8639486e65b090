// SPDX-License-Identifier: BSD-3-Clause
#include "viewer_headless/video/film_process.h"

#include <fmt/format.h>
#include <signal.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <stdexcept>

#include "core/files/shared_file.h"
#include "viewer_headless/video/film_stream.h"

namespace plslam::viewer {
namespace {

// An encoder that takes longer for a picture counts as stuck.
constexpr timeval kFilmPatience = {60, 0};

/// Our end of a connection, and the program's.
struct FilmSockets {
  int ours = -1;
  int theirs = -1;

  FilmSockets() {
    int ends[2];
    if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0) return;
    ours = ends[0];
    theirs = ends[1];
    setsockopt(ours, SOL_SOCKET, SO_SNDTIMEO, &kFilmPatience, sizeof(kFilmPatience));
    setsockopt(ours, SOL_SOCKET, SO_RCVTIMEO, &kFilmPatience, sizeof(kFilmPatience));
  }
};

/// Both of its standard streams are the connection; its errors go where ours go. Returns 0 or an error number.
int SpawnFilmProgram(pid_t& pid, std::string program, std::string file, int connection) {
  posix_spawn_file_actions_t files;
  posix_spawn_file_actions_init(&files);
  posix_spawn_file_actions_adddup2(&files, connection, 0);
  posix_spawn_file_actions_adddup2(&files, connection, 1);
  posix_spawn_file_actions_addclosefrom_np(&files, 3);
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  sigset_t none;
  sigemptyset(&none);
  posix_spawnattr_setsigmask(&attributes, &none);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGMASK);
  char* const words[] = {program.data(), file.data(), nullptr};
  const int error = posix_spawn(&pid, program.c_str(), &files, &attributes, words, environ);
  posix_spawn_file_actions_destroy(&files);
  posix_spawnattr_destroy(&attributes);
  return error;
}

}  // namespace

std::filesystem::path FilmProgram() { return ProgramFolder() / "plslam_film"; }

FilmProcess::FilmProcess(const std::string& file, const std::filesystem::path& program)
    : file_(file), program_(program.string()) {
  const FilmSockets sockets;
  int error = errno;
  if (sockets.ours >= 0) {
    error = SpawnFilmProgram(pid_, program_, file, sockets.theirs);
    close(sockets.theirs);
    socket_ = sockets.ours;
  }
  if (error == 0) return;
  pid_ = -1;
  start_error_ = fmt::format("{} cannot be started: {}{}", program_, std::strerror(error),
                             error == ENOENT ? " ('scripts/build release' builds it)" : "");
}

FilmProcess::~FilmProcess() {
  if (socket_ >= 0) End();
}

std::string FilmProcess::End() {
  close(socket_);
  socket_ = -1;
  int status = 0;
  const pid_t pid = pid_;
  pid_ = -1;
  if (pid < 0 || waitpid(pid, &status, 0) != pid) return "is gone";
  if (WIFSIGNALED(status)) {
    // It had no time to.
    std::remove(film_stream::PartOf(file_).c_str());
    return fmt::format("was ended by signal {}", WTERMSIG(status));
  }
  return fmt::format("ended with exit code {}", WEXITSTATUS(status));
}

void FilmProcess::FailWithEnd() {
  // One that still runs is stuck: the time is over.
  if (pid_ > 0 && (errno == EAGAIN || errno == EWOULDBLOCK)) kill(pid_, SIGKILL);
  const std::string why = fmt::format("{}: no film: {} {}", file_, program_, End());
  if (!begun_) throw NoFilmsHere(why);
  throw std::runtime_error(why);
}

void FilmProcess::Send(const void* bytes, size_t n) {
  const auto* next = static_cast<const char*>(bytes);
  while (n > 0) {
    const ssize_t sent = socket_ < 0 ? -1 : send(socket_, next, n, MSG_NOSIGNAL);
    if (sent < 0 && errno == EINTR) continue;
    if (sent <= 0) FailWithEnd();
    next += sent;
    n -= static_cast<size_t>(sent);
  }
}

void FilmProcess::Await(const std::string& expected) {
  std::string line;
  for (char c = 0; line.size() < 4096;) {
    const ssize_t n = recv(socket_, &c, 1, 0);
    if (n < 0 && errno == EINTR) continue;
    if (n == 0) errno = 0;
    if (n <= 0) FailWithEnd();
    if (c == '\n') break;
    line += c;
  }
  if (line == expected) return;
  End();
  const auto after = [&line](const std::string& word) { return line.substr(word.size()); };
  if (line.starts_with(film_stream::kUnable)) throw NoFilmsHere(after(film_stream::kUnable));
  if (line.starts_with(film_stream::kError)) throw std::runtime_error(after(film_stream::kError));
  throw std::runtime_error(fmt::format("{} reports '{}'", program_, line));
}

void FilmProcess::Begin(double rate_hz, cv::Size size) {
  if (pid_ < 0) throw NoFilmsHere(start_error_);
  const std::string film = fmt::format("{} {} {}\n", size.width, size.height, rate_hz);
  Send(film.data(), film.size());
  Await(film_stream::kReady);
  begun_ = true;
}

void FilmProcess::Add(const cv::Mat& picture) {
  if (pid_ < 0) throw std::runtime_error(file_ + ": the film program has exited");
  char c = 0;
  // An error, for example of a full disk.
  if (recv(socket_, &c, 1, MSG_PEEK | MSG_DONTWAIT) > 0) Await(film_stream::kDone);
  Send(&film_stream::kPicture, 1);
  for (int y = 0; y < picture.rows; ++y) Send(picture.ptr(y), static_cast<size_t>(picture.cols) * picture.elemSize());
}

void FilmProcess::Finish() {
  if (pid_ < 0) throw std::runtime_error(file_ + ": the film program has exited");
  Send(&film_stream::kEnd, 1);
  Await(film_stream::kDone);
  End();
}

}  // namespace plslam::viewer
