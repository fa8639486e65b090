# At installation: the systemd units of PLSLAM_UNITS, with the programs where they now are, into share/plslam/systemd. Link
# them with `systemctl link` (docs/install.md).
set(PLSLAM_BIN ${CMAKE_INSTALL_PREFIX}/bin)
file(GLOB units ${PLSLAM_UNITS}/*.in)
foreach(unit ${units})
  get_filename_component(name ${unit} NAME_WLE)
  set(place $ENV{DESTDIR}${CMAKE_INSTALL_PREFIX}/share/plslam/systemd/${name})
  message(STATUS "Installing: ${place}")
  configure_file(${unit} ${place} @ONLY)
endforeach()
