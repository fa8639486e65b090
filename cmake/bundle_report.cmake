# SPDX-License-Identifier: BSD-3-Clause
# cmake -DPAGE= -DWORK= -DTEMPLATE= -DNODE= -DNPM= -P bundle_report.cmake: npm packages into WORK if the lock has
# changed, then one HTML file to TEMPLATE. Writes nothing into the source tree. A failure is reported loudly, but does
# not fail the build.
function(give_up why output)
  file(REMOVE ${TEMPLATE})
  message(NOTICE "${output}\n"
    "**********************************************************************\n"
    "*  ${why}:\n"
    "*  viewer_headless will make NO report.html. The next build tries again.\n"
    "**********************************************************************")
endfunction()

include(${CMAKE_CURRENT_LIST_DIR}/npm_packages.cmake)
npm_packages(${PAGE} ${WORK} ${NPM} said)
if(said)
  give_up("'npm ci' failed (registry not reachable?)" "${said}")
  return()
endif()
execute_process(COMMAND ${NODE} ${PAGE}/build.mjs ${WORK}/node_modules ${TEMPLATE} WORKING_DIRECTORY ${WORK}
                RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output TIMEOUT 120)
if(NOT result EQUAL 0)
  # The error is in the page itself, not on this machine.
  message(FATAL_ERROR "The page of reports cannot be bundled:\n${output}")
endif()
