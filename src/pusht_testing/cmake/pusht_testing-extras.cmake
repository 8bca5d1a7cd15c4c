# The library of this package has tests of gtest, and needs it where it is linked.
find_package(GTest REQUIRED)

# A gtest of a package of pusht_simulator_package(): it sees the private headers of the package, and has all suites.
function(pusht_add_kind_gtest target)
  find_package(nlohmann_json REQUIRED)
  pusht_add_gtest(${target} ${ARGN})
  target_include_directories(${target} PRIVATE src ${pusht_testing_INCLUDE_DIRS})
  target_link_libraries(${target} ${PROJECT_NAME} ${pusht_testing_LIBRARIES} GTest::gtest)
endfunction()
