#include "core/bus/process.h"
#include "vo_process/prompt_threads.h"
#include "vo_process/vo_node.h"

int main(int argc, char** argv) {
  plslam::AskForShortTurns();
  return plslam::bus::RunProcess(argc, argv, plslam::VoSpec());
}
