#include "viewer_headless/viewer_process.h"

int main(int argc, char** argv) { return plslam::bus::RunProcess(argc, argv, plslam::ViewerProcess()); }
