# Line segments: detection, description, matching. Included by this folder's CMakeLists.txt.
set(plslam_line_sources
  coarse_lines.cpp
  edge_width.cpp
  gradients.cpp
  lbd.cpp
  line_depth.cpp
  line_detector.cpp
  line_detector_opencv.cpp
  line_edge_map.cpp
  line_edgechain.cpp
  line_extractor.cpp
  line_grower.cpp
  line_matcher.cpp
  line_select.cpp
  line_sigma.cpp
  line_stereo.cpp
  line_strip.cpp)
