// SPDX-License-Identifier: BSD-3-Clause
#include "core/bus/transport/datagram_filter.h"

#include <linux/filter.h>
#include <sys/socket.h>

#include <cstdint>
#include <vector>

#include "core/bus/transport/udp_receiver.h"

namespace plslam::bus {
namespace {

// The filter sees a datagram from its UDP header on.
constexpr uint32_t kPacketAt = 8;
constexpr uint32_t kNameAt = kPacketAt + kLcmHeadBytes;
// BPF's answers: how many bytes of the datagram are kept.
constexpr uint32_t kAll = 0xffffffff;
constexpr uint32_t kNone = 0;

using Program = std::vector<sock_filter>;

void Load(Program& program, uint16_t size, uint32_t at) {
  program.push_back({static_cast<uint16_t>(BPF_LD | size | BPF_ABS), 0, 0, at});
}

void Return(Program& program, uint32_t answer) { program.push_back({BPF_RET | BPF_K, 0, 0, answer}); }

// Where what was loaded is not `value`, `skipped` instructions are left out.
void Expect(Program& program, uint32_t value, size_t skipped) {
  program.push_back({BPF_JMP | BPF_JEQ | BPF_K, 0, static_cast<uint8_t>(skipped), value});
}

// Keeps a datagram whose channel is this one. At most 64 bytes are compared by words, then by single bytes, two
// instructions each.
void KeepChannel(Program& program, const std::string& name) {
  const size_t size = name.size() + 1;  // with the zero that ends it
  const size_t words = size / 4;
  const size_t comparisons = words + size % 4;
  const auto byte = [&name](size_t i) { return static_cast<uint32_t>(static_cast<unsigned char>(name.c_str()[i])); };
  size_t at = 0;
  for (size_t i = 0; i < comparisons; ++i) {
    const bool word = i < words;
    const uint32_t value = word ? byte(at) << 24 | byte(at + 1) << 16 | byte(at + 2) << 8 | byte(at + 3) : byte(at);
    Load(program, word ? BPF_W : BPF_B, kNameAt + static_cast<uint32_t>(at));
    Expect(program, value, 2 * (comparisons - i - 1) + 1);
    at += word ? 4 : 1;
  }
  Return(program, kAll);
}

}  // namespace

void FilterLargeDatagrams(int fd, const std::set<std::string, std::less<>>& names) {
  Program program;
  program.push_back({BPF_LD | BPF_W | BPF_LEN, 0, 0, 0});
  program.push_back({BPF_JMP | BPF_JGT | BPF_K, 1, 0, static_cast<uint32_t>(kUnfilteredBytes)});
  Return(program, kAll);
  Load(program, BPF_W, kPacketAt);
  program.push_back({BPF_JMP | BPF_JEQ | BPF_K, 1, 0, kLcmMagic});
  Return(program, kAll);
  for (const std::string& name : names) KeepChannel(program, name);
  Return(program, kNone);
  if (program.size() > BPF_MAXINSNS) return RemoveDatagramFilter(fd);
  const sock_fprog filter{static_cast<unsigned short>(program.size()), program.data()};
  // The one before would keep new channels out.
  if (setsockopt(fd, SOL_SOCKET, SO_ATTACH_FILTER, &filter, sizeof filter) != 0) RemoveDatagramFilter(fd);
}

void RemoveDatagramFilter(int fd) {
  const int unused = 0;
  setsockopt(fd, SOL_SOCKET, SO_DETACH_FILTER, &unused, sizeof unused);
}

}  // namespace plslam::bus
