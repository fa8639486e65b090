# SPDX-License-Identifier: BSD-3-Clause
# npm_packages(FOLDER WORK NPM OUT): installs the packages of FOLDER/package-lock.json into WORK/node_modules if the
# lock has changed. Writes nothing into the source tree. OUT is empty if they are installed, else the output of npm: the
# registry may not be reachable.
function(npm_packages folder work npm out)
  file(MAKE_DIRECTORY ${work})
  set(${out} "" PARENT_SCOPE)
  set(stamp ${work}/installed-lock.json)
  file(SHA256 ${folder}/package-lock.json wanted)
  set(installed "")
  if(EXISTS ${stamp})
    file(SHA256 ${stamp} installed)
  endif()
  if(installed STREQUAL wanted)
    return()
  endif()
  file(COPY ${folder}/package.json ${folder}/package-lock.json DESTINATION ${work})
  execute_process(
    COMMAND ${npm} ci --ignore-scripts --no-audit --no-fund --prefer-offline --fetch-retries=1 --fetch-retry-mintimeout=1000 --fetch-retry-maxtimeout=2000
            --fetch-timeout=60000
    WORKING_DIRECTORY ${work} RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output TIMEOUT 300)
  if(NOT result EQUAL 0)
    set(${out} "npm ci: ${result}\n${output}" PARENT_SCOPE)
    return()
  endif()
  file(COPY_FILE ${folder}/package-lock.json ${stamp})
endfunction()

# cmake -DFOLDER= -DWORK= -DNPM= -P npm_packages.cmake: the same for a test, which is skipped if they are not available.
if(CMAKE_SCRIPT_MODE_FILE STREQUAL CMAKE_CURRENT_LIST_FILE)
  npm_packages(${FOLDER} ${WORK} ${NPM} said)
  if(said)
    message(NOTICE "${said}\nThe tests that read with these packages will be skipped. The next build tries again.")
  endif()
endif()
