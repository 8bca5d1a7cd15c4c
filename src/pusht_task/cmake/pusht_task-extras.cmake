# How every target of the suite is compiled: C++17, warnings on, and floating point exactly as written
# (the determinism contract: no contraction into FMA, no fast-math, no code for one machine only).
if(NOT CMAKE_BUILD_TYPE AND NOT CMAKE_CONFIGURATION_TYPES)
  set(CMAKE_BUILD_TYPE Release CACHE STRING "Debug, Release, RelWithDebInfo or MinSizeRel" FORCE)
endif()

function(pusht_compile_options target)
  set_target_properties(${target} PROPERTIES CXX_STANDARD 17 CXX_STANDARD_REQUIRED ON CXX_EXTENSIONS OFF)
  target_compile_options(${target} PRIVATE -Wall -Wextra -Wpedantic -ffp-contract=off)
  if(PUSHT_WERROR)
    target_compile_options(${target} PRIVATE -Werror)
  endif()
endfunction()

# What script/compare builds, of the packages that are configured: nodes, simulators, policies, views. Those who are part
# of it add themselves.
if(NOT TARGET comparison)
  add_custom_target(comparison)
endif()

# Compiles the sources of a target jointly, in units of COUNT (12, if not given): they share most of their headers, so
# that takes a third of the time. Who changes one source at a time may switch it off. Not for the inner loops of engines
# and policies, whose speed may depend on what the compiler sees at once: they stay APART.
option(PUSHT_JOIN_SOURCES "Compile the sources of a target jointly" ON)
function(pusht_join_sources target)
  cmake_parse_arguments(_join "" "COUNT" "APART" ${ARGN})
  if(NOT _join_COUNT)
    set(_join_COUNT 12)
  endif()
  set_target_properties(${target} PROPERTIES UNITY_BUILD ${PUSHT_JOIN_SOURCES} UNITY_BUILD_BATCH_SIZE ${_join_COUNT})
  if(_join_APART)
    set_source_files_properties(${_join_APART} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
  endif()
endfunction()

# In a release, code that computes nothing at length is compiled at -O1, in 70 % of the time of -O3, and runs as fast.
# Tests, too: at -O0, in 60 %, those of the engines would run for 35 s instead of 2.
function(pusht_optimize_little target)
  target_compile_options(${target} PRIVATE $<$<CONFIG:Release>:-O1>)
endfunction()

# A gtest with gmock's main and JSON at hand.
function(pusht_add_gtest target)
  catkin_add_gmock(${target} ${ARGN})
  pusht_compile_options(${target})
  pusht_optimize_little(${target})
  pusht_join_sources(${target})
  target_link_libraries(${target} gmock_main gmock nlohmann_json::nlohmann_json)
endfunction()

# A file of Python tests, which pytest runs (catkin_add_nosetests needs nose, which Debian 13 has no more).
# TIMEOUT is the limit of each test [s], 60 if not given; COST what the file takes [s], where that is much: ctest begins
# with the longest. pytest returns 1 if tests fail; after any other failure it may
# not have run them all, so no results may stay: a test without results is a failed one.
function(pusht_add_pytest file)
  cmake_parse_arguments(_pytest "" "TIMEOUT;COST" "DEPENDENCIES" ${ARGN})
  if(NOT _pytest_TIMEOUT)
    set(_pytest_TIMEOUT 60)
  endif()
  string(REPLACE "/" "." name ${file})
  set(results pytest-${name}.xml)
  set(path ${CATKIN_TEST_RESULTS_DIR}/${PROJECT_NAME}/${results})
  string(CONCAT command
    "${PYTHON_EXECUTABLE} -m pytest --quiet -p no:cacheprovider --rootdir=${CMAKE_CURRENT_SOURCE_DIR}"
    " --timeout=${_pytest_TIMEOUT} --override-ini=junit_family=xunit1 --junitxml=${path}"
    " ${CMAKE_CURRENT_SOURCE_DIR}/${file} || [ $? -eq 1 ] || rm -f ${path}")
  catkin_run_tests_target(pytest ${name} ${results} COMMAND ${command} DEPENDENCIES ${_pytest_DEPENDENCIES})
  pusht_test_cost(pytest_${name} ${_pytest_COST})
endfunction()

# Says what a test takes [s], such as gtest_audit_test or rostest_test_live_session.test.
function(pusht_test_cost name)
  if(ARGN)
    set_tests_properties(_ctest_${PROJECT_NAME}_${name} PROPERTIES COST ${ARGN})
  endif()
endfunction()
