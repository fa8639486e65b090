# SPDX-License-Identifier: BSD-3-Clause
# Units of the processes, plslam-NAME@.service, made from process@.service.template.

# plslam_process_unit(FOLDER NAME PROGRAM ABOUT [MORE arguments] [COMMAND line] [NICE how] [RESTART when] [VIDEO])
function(plslam_process_unit folder name program about)
  cmake_parse_arguments(unit "VIDEO" "MORE;COMMAND;NICE;RESTART" "" ${ARGN})
  set(arguments "--config /etc/plslam/%i.yaml ${unit_MORE} --set bus.history_dir=%S/plslam/%i/${name}")
  string(REPLACE "  " " " arguments ${arguments})
  set(command "${PLSLAM_BIN}/${program} ${arguments}")
  if(unit_COMMAND)
    string(REPLACE "ARGUMENTS" ${arguments} command ${unit_COMMAND})
  endif()
  # Tracker and map have priority if there are few processors.
  set(nice 0)
  if(unit_NICE)
    set(nice ${unit_NICE})
  endif()
  set(restart always)
  if(unit_RESTART)
    set(restart ${unit_RESTART})
  endif()
  set(devices "PrivateDevices=yes")
  if(unit_VIDEO)
    # GStreamer caches the registry of its plug-ins there, which saves a second at each start.
    set(devices "SupplementaryGroups=video\nEnvironment=GST_REGISTRY=%S/plslam/%i/${name}/registry")
  endif()
  configure_file(${PLSLAM_UNITS}/process@.service.template ${folder}/plslam-${name}@.service @ONLY)
endfunction()

function(plslam_process_units folder)
  plslam_process_unit(${folder} mapping mapping_process "mapping (keyframes, points and lines, local bundle adjustment)"
                      MORE "--set mapping.state_file=%S/plslam/%i/mapping/state --set mapping.state_every=1")
  plslam_process_unit(${folder} loop loop_process "loop closing (place recognition and relocalisation)"
                      NICE 8)
  plslam_process_unit(${folder} vo vo_process "tracking (stereo odometry with points and lines)"
                      MORE "--set vo.state_file=%S/plslam/%i/vo/state")
  plslam_process_unit(${folder} viewer viewer_headless "viewer (trajectories, map and pictures as files)"
                      MORE "--force --set viewer.quiet=true --set viewer.out=%S/plslam/%i/viewer/out"
                      NICE 10)
  plslam_process_unit(${folder} adapter adapter "adapter (robots that use LCM: images in, poses and the map out)")
  # A dataset that has ended is not played again.
  plslam_process_unit(${folder} player player "player (the dataset of player.dataset as stereo frames)"
                      RESTART on-failure)
  # After a crash the numbers of frames continue.
  plslam_process_unit(${folder} camera camera "camera (the live cameras of camera.rig as stereo frames)"
                      MORE "--set camera.resume_after=bus" RESTART on-failure VIDEO)
  # The shell names each log after its time.
  set(log "%S/plslam/%i/recorder/$$(date -u +%%Y%%m%%dT%%H%%M%%S).lcm")
  plslam_process_unit(${folder} recorder plslam "recorder (all traffic as LCM event logs)"
                      COMMAND "/bin/sh -c \"exec ${PLSLAM_BIN}/plslam record ${log} ARGUMENTS\"")
endfunction()
