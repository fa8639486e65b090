# SPDX-License-Identifier: BSD-3-Clause
# PkgConfig::GSTREAMER, the libraries of GStreamer for live cameras and films, if they are installed.
find_package(PkgConfig)
if(PkgConfig_FOUND)
  pkg_check_modules(GSTREAMER IMPORTED_TARGET gstreamer-1.0>=1.18 gstreamer-app-1.0 gstreamer-video-1.0)
endif()
if(TARGET PkgConfig::GSTREAMER)
  # GStreamer adds -pthread, which is incompatible with the precompiled headers of the tree; Threads::Threads suffices.
  set_target_properties(PkgConfig::GSTREAMER PROPERTIES INTERFACE_COMPILE_OPTIONS "")
endif()
