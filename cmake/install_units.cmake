# SPDX-License-Identifier: BSD-3-Clause
# At installation: writes the systemd units of PLSLAM_UNITS, with the installed paths of the programs, into
# share/plslam/systemd. Link them with `systemctl link` (docs/install.md).
set(PLSLAM_BIN ${CMAKE_INSTALL_PREFIX}/bin)
set(folder $ENV{DESTDIR}${CMAKE_INSTALL_PREFIX}/share/plslam/systemd)
message(STATUS "Installing: ${folder}")
file(GLOB units ${PLSLAM_UNITS}/*.in)
foreach(unit ${units})
  get_filename_component(name ${unit} NAME_WLE)
  configure_file(${unit} ${folder}/${name} @ONLY)
endforeach()
include(${PLSLAM_UNITS}/processes.cmake)
plslam_process_units(${folder})
