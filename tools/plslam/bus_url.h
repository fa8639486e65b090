// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace plslam {

/// A UDP port that nothing else on this machine uses; it stays ours until the end of the scope, so that two launchers
/// never pick the same one. Others may share it (LCM does) but the kernel gives it to nobody who asks for any port.
class PrivatePort {
 public:
  /// Throws std::runtime_error where there is none.
  PrivatePort();
  ~PrivatePort();
  PrivatePort(const PrivatePort&) = delete;
  PrivatePort& operator=(const PrivatePort&) = delete;

  int port() const { return port_; }
  /// LCM URL on this port, not beyond this machine.
  std::string Url() const;

 private:
  int socket_ = -1;
  int port_ = 0;
};

}  // namespace plslam
