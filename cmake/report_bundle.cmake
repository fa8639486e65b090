# SPDX-License-Identifier: BSD-3-Clause
# The page of reports: viewer_headless/page, bundled with three.js and uPlot (npm, pinned by its package-lock.json) into
# share/plslam/report_template.html of the build folder. Without node or npm, or if their registry cannot be reached,
# the build continues without it, with a loud message, and viewer_headless writes no report.

# plslam_report_template(PAGE_FOLDER PROGRAM): built with PROGRAM if a source of the page has changed.
function(plslam_report_template page program)
  set(template ${CMAKE_BINARY_DIR}/share/plslam/report_template.html)
  find_program(NODE_PROGRAM NAMES node nodejs)
  find_program(NPM_PROGRAM npm)
  if(NOT NODE_PROGRAM OR NOT NPM_PROGRAM)
    message(WARNING "No node and npm (scripts/setup installs them): viewer_headless will make NO report.html.")
    file(REMOVE ${template})
    return()
  endif()
  file(GLOB sources CONFIGURE_DEPENDS ${page}/*)
  add_custom_command(
    OUTPUT ${template}
    COMMAND ${CMAKE_COMMAND} -DPAGE=${page} -DWORK=${CMAKE_BINARY_DIR}/report_page -DTEMPLATE=${template}
            -DNODE=${NODE_PROGRAM} -DNPM=${NPM_PROGRAM} -P ${CMAKE_SOURCE_DIR}/cmake/bundle_report.cmake
    DEPENDS ${sources} ${CMAKE_SOURCE_DIR}/cmake/bundle_report.cmake
            ${CMAKE_SOURCE_DIR}/cmake/npm_packages.cmake
    COMMENT "Bundling the page of reports"
    VERBATIM)
  add_custom_target(report_template DEPENDS ${template})
  add_dependencies(${program} report_template)
endfunction()
