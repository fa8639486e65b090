// SPDX-License-Identifier: BSD-3-Clause
#include "viewer_headless/viewer_process.h"

int main(int argc, char** argv) { return plslam::bus::RunProcess(argc, argv, plslam::viewer::ViewerProcess()); }
