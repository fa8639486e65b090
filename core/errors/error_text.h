// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <exception>
#include <fstream>
#include <stdexcept>
#include <string>
#include <string_view>

namespace plslam {

/// `NAME:LINE: ...` for YAML that cannot be parsed: `line` (from 0; below 0: unknown) and `what` as the parser says
/// them, with the text of the line. A tab before a key, of which the parser complains at another line in other words,
/// is found here.
std::string YamlComplaint(const std::string& name, std::string_view text, int line, const std::string& what);

/// Foreign text in a sentence for the user: printable ASCII as it is, other bytes as \xNN, and not more than 60
/// characters, the last of them "..." where the text goes on. What stands in a file or on the network must not steer
/// a terminal.
std::string Shown(std::string_view text);

/// Text in a page: what HTML would take for marks, as entities.
std::string InHtml(std::string_view text);

/// What an error number of the system means, with the limit behind it where there is one: of processes and threads
/// (EAGAIN), of open files (EMFILE), of memory (ENOMEM); each with the command that shows it.
std::string ReasonOf(int error_number);
/// The same of a path: a permission that is missing may be that of a folder above it, which is named.
std::string ReasonOf(int error_number, const std::string& path);

/// The sentence of an exception: what() of ours. Those of the library get what theirs leave out: the path and the
/// operation (files), the limit (threads, memory).
std::string SentenceOf(const std::exception& error);

/// Whether it says that memory is not enough, in the words of the library or of OpenCV.
bool IsOfMemory(const std::exception& error);

/// Two sentences in one, "a; b"; the other one where one of them is empty.
std::string Joined(const std::string& a, const std::string& b);

/// Runs `f`; where memory is not enough for it, throws std::runtime_error "WHAT: memory is not enough: ...". `what`
/// names the file and the size ("room.plmap: 3000 MB").
template <class F>
auto WithMemoryFor(const std::string& what, F f) {
  try {
    return f();
  } catch (const std::exception& error) {
    if (IsOfMemory(error)) throw std::runtime_error(what + ": " + SentenceOf(error));
    throw;
  }
}

/// Opens a file or a pipe for reading, binary. Throws std::runtime_error "PATH: cannot be read: REASON" where there
/// is none, where it is a folder, or where permission is missing.
std::ifstream OpenInput(const std::string& path);

/// Why `OpenInput` would refuse, without the path ("cannot be read: No such file or directory"); empty where it would
/// not.
std::string WhyUnreadable(const std::string& path);

}  // namespace plslam
