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

# A gtest with gmock's main, JSON and the golden vectors at hand; for packages of this source tree.
set(PUSHT_GOLDEN_DIR ${CMAKE_CURRENT_LIST_DIR}/../test/data)
function(pusht_add_gtest target)
  catkin_add_gmock(${target} ${ARGN})
  pusht_compile_options(${target})
  target_compile_definitions(${target} PRIVATE PUSHT_GOLDEN_DIR="${PUSHT_GOLDEN_DIR}")
  target_link_libraries(${target} gmock_main gmock nlohmann_json::nlohmann_json)
endfunction()

# A file of Python tests, which pytest runs (catkin_add_nosetests needs nose, which Debian 13 has no more).
# TIMEOUT is the limit of each test [s], 60 if not given. pytest returns 1 if tests fail; after any other failure it may
# not have run them all, so no results may stay: a test without results is a failed one.
function(pusht_add_pytest file)
  cmake_parse_arguments(_pytest "" "TIMEOUT" "DEPENDENCIES" ${ARGN})
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
endfunction()
