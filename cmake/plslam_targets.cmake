# SPDX-License-Identifier: BSD-3-Clause
# Compiler flags of all our targets, and the two functions that declare them.
add_library(plslam_flags INTERFACE)
target_include_directories(plslam_flags INTERFACE ${CMAKE_SOURCE_DIR})
# The presets make warnings errors; a plain build with another compiler does not fail because of new warnings.
option(PLSLAM_WARNINGS_AS_ERRORS "Warnings are errors" OFF)
# -fPIC, but calls within a library are direct: the odometry is also a shared library (tools/odometry_library).
# -ffp-contract=off: the same floating-point result on machines with and without fused multiply-add. The other two do
# not change results either: roots and roundings need no call that sets errno, and loops over floating-point numbers can
# be vectorised.
target_compile_options(plslam_flags INTERFACE -Wall -Wextra -Wpedantic -Wshadow -Wnon-virtual-dtor
                       -Wold-style-cast -Wconversion -Wno-sign-conversion $<$<BOOL:${PLSLAM_WARNINGS_AS_ERRORS}>:-Werror> -ffp-contract=off -fno-math-errno
                       -fPIC -fno-semantic-interposition
                       -fno-trapping-math)
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  # GCC does not search its memory for garbage below this size (kB): a tenth less time to compile, 150 MB more memory.
  target_compile_options(plslam_flags INTERFACE "SHELL:--param ggc-min-heapsize=1500000")
endif()
if(CMAKE_SYSTEM_PROCESSOR MATCHES "^(aarch64|arm64)$")
  # The same results as on amd64: char is signed, and Eigen does not fuse.
  target_compile_options(plslam_flags INTERFACE -U__ARM_FEATURE_FMA -fsigned-char)
  target_compile_definitions(plslam_flags INTERFACE EIGEN_DENSEBASE_PLUGIN="${CMAKE_CURRENT_LIST_DIR}/eigen_without_fma.h")
endif()
if(CMAKE_BUILD_TYPE STREQUAL "Debug")
  target_compile_options(plslam_flags INTERFACE -O1)
endif()
if(PLSLAM_SANITIZE)
  # Reports name functions; with -g1 (-DCMAKE_CXX_FLAGS=-g1) lines too, for a tenth more time to build.
  set(CMAKE_CXX_FLAGS_RELWITHDEBINFO "-O1")
  if(PLSLAM_SANITIZE MATCHES "undefined")
    # Undefined behaviour ends the program, and so fails the test. -Og halves the time to compile, and unit tests run as
    # fast; whole runs do not.
    add_compile_options(-fno-sanitize-recover=undefined)
    # The address sanitizer also finds null pointers, wrong types in memory and what is accessed through a pointer that has
    # overflowed, and x86 and ARM support unaligned reads: without these checks a build takes 40 % of the time.
    add_compile_options(-fno-sanitize=null,alignment,object-size,vptr,nonnull-attribute,returns-nonnull-attribute,pointer-overflow)
    set(PLSLAM_SANITIZED_OPTIMISATION "-Og" CACHE STRING "Optimisation under the address and undefined behaviour sanitizers")
    set(CMAKE_CXX_FLAGS_RELWITHDEBINFO "${PLSLAM_SANITIZED_OPTIMISATION}")
  endif()
  # GCC's analysis of uninitialised values also reports the instrumentation (see its manual).
  target_compile_options(plslam_flags INTERFACE -Wno-maybe-uninitialized)
  add_compile_options(-fsanitize=${PLSLAM_SANITIZE} -fno-omit-frame-pointer)
  add_link_options(-fsanitize=${PLSLAM_SANITIZE})
  add_compile_definitions(PLSLAM_SANITIZED=1)
endif()
# In a separate file, so that a new version does not recompile everything.
configure_file(${CMAKE_SOURCE_DIR}/cmake/plslam_version.h.in ${CMAKE_BINARY_DIR}/version/plslam_version.h)
include_directories(${CMAKE_BINARY_DIR}/version)

# lld takes a tenth of the time of ld for a hundred programs. GCC finds a cross linker by the name of its target.
find_program(LLD_PROGRAM ld.lld)
if(LLD_PROGRAM AND NOT CMAKE_CROSSCOMPILING)
  add_link_options(-fuse-ld=lld)
endif()

find_program(CCACHE_PROGRAM ccache)
if(CCACHE_PROGRAM)
  set(CMAKE_CXX_COMPILER_LAUNCHER ${CCACHE_PROGRAM})
endif()

# The code of tools and tests computes little; the work is done in core and in the processes.
add_library(plslam_light_flags INTERFACE)
target_link_libraries(plslam_light_flags INTERFACE plslam_flags)
if(NOT PLSLAM_SANITIZE)
  target_compile_options(plslam_light_flags INTERFACE -O1)
endif()

include(plslam_precompiled)

# The headers of other libraries take longer to compile than most sources, so the sources of a target are compiled eight
# at a time: half the time for all, more for the change of one. The debug preset compiles them one by one, and so does
# scripts/lint, also for the recent sources among the tests: a source that uses a name of another file by accident fails
# there.
option(PLSLAM_UNITY "Compile eight sources of a target at a time" OFF)

# plslam_compile_together(NAME [ALONE a.cpp ...]): those named have a name for another thing than their neighbours.
function(plslam_compile_together name)
  cmake_parse_arguments(ARG "" "" "ALONE" ${ARGN})
  set_target_properties(${name} PROPERTIES UNITY_BUILD ${PLSLAM_UNITY})
  if(ARG_ALONE)
    set_source_files_properties(${ARG_ALONE} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
  endif()
endfunction()

# plslam_library(NAME SOURCES a.cpp ... LINK target ... [ALONE a.cpp ...]): a static library of this tree. Those of core
# and of the message types are installed for other programs (plslam_install.cmake), without our warnings.
function(plslam_library name)
  cmake_parse_arguments(ARG "" "" "SOURCES;LINK;ALONE" ${ARGN})
  add_library(${name} STATIC ${ARG_SOURCES})
  plslam_compile_together(${name} ALONE ${ARG_ALONE})
  target_link_libraries(${name} PUBLIC $<BUILD_INTERFACE:plslam_flags> ${ARG_LINK})
  file(RELATIVE_PATH folder ${CMAKE_SOURCE_DIR} ${CMAKE_CURRENT_SOURCE_DIR})
  if(folder MATCHES "^(tools|tests)/")
    target_link_libraries(${name} PRIVATE plslam_light_flags)
    plslam_use_precompiled(${name} plslam_tool_headers)
  else()
    plslam_use_precompiled(${name} plslam_common_headers)
  endif()
  if(folder MATCHES "^(core|lcmtypes)(/|$)")
    set_property(GLOBAL APPEND PROPERTY PLSLAM_CORE_LIBRARIES ${name})
  endif()
endfunction()

# All programs for users, without tests and benchmarks; and those of a run alone (scripts/demo).
add_custom_target(plslam_programs)
add_custom_target(plslam_demo)

# plslam_program(NAME SOURCES main.cpp ... LINK target ...): an executable in build/PRESET/bin. Those of tests/ are for
# developers: neither among plslam_programs nor installed.
function(plslam_program name)
  cmake_parse_arguments(ARG "" "" "SOURCES;LINK" ${ARGN})
  add_executable(${name} ${ARG_SOURCES})
  plslam_compile_together(${name})
  target_link_libraries(${name} PRIVATE plslam_flags ${ARG_LINK})
  file(RELATIVE_PATH folder ${CMAKE_SOURCE_DIR} ${CMAKE_CURRENT_SOURCE_DIR})
  if(folder MATCHES "^(tools|tests)/")
    target_link_libraries(${name} PRIVATE plslam_light_flags)
    plslam_use_precompiled(${name} plslam_tool_headers)
  endif()
  if(NOT folder MATCHES "^tests/")
    add_dependencies(plslam_programs ${name})
    set_property(GLOBAL APPEND PROPERTY PLSLAM_INSTALLED_PROGRAMS ${name})
  endif()
endfunction()

# Folders of tests that read foreign bytes or receive in threads. Under a sanitizer they get the label `sanitized`, and the
# target plslam_sanitized_tests builds no others: scripts/test runs these; scripts/soak also runs those of pixels.
set(PLSLAM_SANITIZED_FOLDERS fuzz unit/adapter unit/robot unit/ros2 unit/bus unit/map_file)
add_custom_target(plslam_sanitized_tests)

# Long tests start first, so that no core waits for them at the end.
set(PLSLAM_COST_integration 100)
set(PLSLAM_COST_soak 100)
set(PLSLAM_COST_replay 50)
set(PLSLAM_COST_fuzz 10)

# plslam_test(NAME SOURCES a_test.cpp ... LINK target ... [LABEL unit] [TIMEOUT 300] [SERIAL Rates.*:Times.*] [ONE_BY_ONE]
# [TOGETHER Suite ...]): a GoogleTest executable, run by ctest test by test. Tests of times or rates run alone, after all
# others: SERIAL and patterns of --gtest_filter, * for all. ONE_BY_ONE: its tests do not run in parallel. TOGETHER: suites
# whose tests share what takes long, each run by one process. So is a whole executable under the address sanitizer,
# whose start and end take longer than most tests.
function(plslam_test name)
  cmake_parse_arguments(ARG "ONE_BY_ONE" "LABEL;TIMEOUT;SERIAL" "SOURCES;LINK;TOGETHER" ${ARGN})
  if(NOT ARG_LABEL)
    set(ARG_LABEL unit)
  endif()
  if(NOT ARG_TIMEOUT)
    set(ARG_TIMEOUT 300)
  endif()
  set(cost 0)
  if(DEFINED PLSLAM_COST_${ARG_LABEL})
    set(cost ${PLSLAM_COST_${ARG_LABEL}})
  endif()
  add_executable(${name} ${ARG_SOURCES})
  file(RELATIVE_PATH folder ${CMAKE_SOURCE_DIR}/tests ${CMAKE_CURRENT_SOURCE_DIR})
  set(headers plslam_test_headers)
  if(folder STREQUAL "integration")
    set(headers plslam_run_test_headers)
  endif()
  target_link_libraries(${name} PRIVATE plslam_light_flags plslam_test_support GTest::gmock GTest::gtest_main ${ARG_LINK})
  plslam_use_precompiled(${name} ${headers})
  set_target_properties(${name} PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/tests)
  if(PLSLAM_SANITIZE AND folder IN_LIST PLSLAM_SANITIZED_FOLDERS)
    set(ARG_LABEL sanitized)
    add_dependencies(plslam_sanitized_tests ${name})
    if(PLSLAM_SANITIZE MATCHES "address")
      add_test(NAME ${name} COMMAND ${name} WORKING_DIRECTORY ${CMAKE_BINARY_DIR}/bin)
      set_tests_properties(${name} PROPERTIES LABELS sanitized TIMEOUT 1200 COST ${cost})
      return()
    endif()
  endif()
  set(discovery DISCOVERY_MODE PRE_TEST WORKING_DIRECTORY ${CMAKE_BINARY_DIR}/bin)
  set(properties PROPERTIES LABELS ${ARG_LABEL} TIMEOUT ${ARG_TIMEOUT} COST ${cost})
  if(ARG_ONE_BY_ONE)
    list(APPEND properties RESOURCE_LOCK ${name})
  endif()
  if(ARG_SERIAL)
    gtest_discover_tests(${name} ${discovery} TEST_FILTER ${ARG_SERIAL} ${properties} RUN_SERIAL TRUE)
  endif()
  set(others ${ARG_SERIAL})
  foreach(suite ${ARG_TOGETHER})
    add_test(NAME ${suite} COMMAND ${name} --gtest_filter=${suite}.* WORKING_DIRECTORY ${CMAKE_BINARY_DIR}/bin)
    # It takes longer than other tests of its kind.
    math(EXPR cost_of_all "${cost} + 100")
    set_tests_properties(${suite} ${properties} COST ${cost_of_all} FAIL_REGULAR_EXPRESSION "Running 0 tests")
    string(APPEND others ":${suite}.*")
  endforeach()
  if(NOT ARG_SERIAL STREQUAL "*")
    gtest_discover_tests(${name} ${discovery} TEST_FILTER "-${others}" ${properties})
  endif()
endfunction()

# plslam_benchmark(NAME SOURCES a_benchmark.cpp LINK target ...): a Google Benchmark executable in build/PRESET/bin.
function(plslam_benchmark name)
  cmake_parse_arguments(ARG "" "" "SOURCES;LINK" ${ARGN})
  add_executable(${name} ${ARG_SOURCES})
  target_link_libraries(${name} PRIVATE plslam_flags plslam_test_support benchmark::benchmark ${ARG_LINK})
  plslam_use_precompiled(${name} plslam_common_headers)
endfunction()
