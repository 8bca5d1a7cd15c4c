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
