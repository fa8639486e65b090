# cmake -DPAGE= -DWORK= -DTEMPLATE= -DNODE= -DNPM= -P bundle_report.cmake: npm packages into WORK, where the lock has changed,
# then one HTML file to TEMPLATE. Writes nothing into the source tree. Failure is loud, and no failure of the build.
function(give_up why output)
  file(REMOVE ${TEMPLATE})
  message(NOTICE "${output}\n"
    "**********************************************************************\n"
    "*  ${why}:\n"
    "*  viewer_headless will make NO report.html. The next build tries again.\n"
    "**********************************************************************")
endfunction()

file(MAKE_DIRECTORY ${WORK})
set(stamp ${WORK}/installed-lock.json)
file(SHA256 ${PAGE}/package-lock.json wanted)
set(installed "")
if(EXISTS ${stamp})
  file(SHA256 ${stamp} installed)
endif()
if(NOT installed STREQUAL wanted)
  file(COPY ${PAGE}/package.json ${PAGE}/package-lock.json DESTINATION ${WORK})
  execute_process(
    COMMAND ${NPM} ci --ignore-scripts --no-audit --no-fund --prefer-offline --fetch-retries=1 --fetch-retry-mintimeout=1000 --fetch-retry-maxtimeout=2000
            --fetch-timeout=60000
    WORKING_DIRECTORY ${WORK} RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output TIMEOUT 300)
  if(NOT result EQUAL 0)
    give_up("'npm ci' failed (registry not reachable?)" "${output}")
    return()
  endif()
  file(COPY_FILE ${PAGE}/package-lock.json ${stamp})
endif()
execute_process(COMMAND ${NODE} ${PAGE}/build.mjs ${WORK}/node_modules ${TEMPLATE} WORKING_DIRECTORY ${WORK}
                RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output TIMEOUT 120)
if(NOT result EQUAL 0)
  # Not the machine's fault: the page itself is wrong.
  message(FATAL_ERROR "The page of reports cannot be bundled:\n${output}")
endif()
