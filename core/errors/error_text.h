// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <exception>
#include <fstream>
#include <stdexcept>
#include <string>
#include <string_view>

namespace plslam {

/// Returns `NAME:LINE: ...` for YAML that cannot be parsed: `line` (from 0; below 0: unknown) and `what` come from the
/// parser; the text of the line is appended. A tab before a key, which the parser reports at another line in other
/// words, is detected here.
std::string YamlComplaint(const std::string& name, std::string_view text, int line, const std::string& what);

/// Returns foreign text for a sentence to the user: printable ASCII as it is, other bytes as \xNN, at most 60
/// characters, the last of them "..." if the text is longer. Text from a file or the network must not control a
/// terminal.
std::string Shown(std::string_view text);

/// Returns text for a page, with the special characters of HTML as entities.
std::string InHtml(std::string_view text);

/// Returns the meaning of a system error number, with the limit that causes it if there is one: of processes and
/// threads (EAGAIN), of open files (EMFILE), of memory (ENOMEM); each with the command that shows it.
std::string ReasonOf(int error_number);
/// Returns the same for a path: if a permission is missing on a folder above it, that folder is named.
std::string ReasonOf(int error_number, const std::string& path);

/// Returns the sentence of an exception: what() of our own types. Exceptions of the standard library are completed:
/// with the path and the operation (files, standard output), or the limit (threads, memory).
std::string SentenceOf(const std::exception& error);

/// Returns whether the exception reports insufficient memory, in the words of the library or of OpenCV.
bool IsOfMemory(const std::exception& error);

/// Joins two sentences as "a; b"; returns the other one if one is empty.
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

/// Opens a file or a pipe for reading, binary. Throws std::runtime_error "PATH: cannot be read: REASON" if it does not
/// exist, is a folder, or permission is missing.
std::ifstream OpenInput(const std::string& path);

/// Returns the reason why `OpenInput` would fail, without the path ("cannot be read: No such file or directory"); empty
/// if it would not.
std::string WhyUnreadable(const std::string& path);

}  // namespace plslam
