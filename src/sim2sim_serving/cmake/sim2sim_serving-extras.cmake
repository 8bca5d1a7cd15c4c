# The rest of a package pusht_NAME for kinds of simulators, after find_package and catkin_package: the library SOURCES
# (those APART are not joined), which other packages see together with the libraries PUBLIC; the node NAME_node, which
# serves KIND (NAME, if not given); the rostest test/NAME.test; and their installation, with that of DIRECTORIES.
# (Headers and plugin_description.xml the package installs itself, where catkin_lint looks for it.)
set(PUSHT_SERVING_CMAKE ${CMAKE_CURRENT_LIST_DIR})
function(pusht_simulator_package)
  cmake_parse_arguments(_kind "" "KIND" "SOURCES;APART;PUBLIC;PRIVATE;DIRECTORIES" ${ARGN})
  string(REGEX REPLACE "^pusht_" "" name ${PROJECT_NAME})
  if(NOT _kind_KIND)
    set(_kind_KIND ${name})
  endif()

  # In another workspace than pusht_task's, its library is a file.
  set(task ${catkin_LIBRARIES})
  list(FILTER task INCLUDE REGEX "^(.*/lib)?pusht_task(\\.so)?$")
  add_library(${PROJECT_NAME} SHARED ${_kind_SOURCES})
  target_include_directories(${PROJECT_NAME} PUBLIC ${catkin_INCLUDE_DIRS})
  if(IS_DIRECTORY ${CMAKE_CURRENT_SOURCE_DIR}/include)
    target_include_directories(${PROJECT_NAME} PUBLIC include)
  endif()
  target_link_libraries(${PROJECT_NAME} PUBLIC ${task} ${_kind_PUBLIC} PRIVATE ${_kind_PRIVATE})
  pusht_compile_options(${PROJECT_NAME})
  add_dependencies(comparison ${PROJECT_NAME})
  pusht_join_sources(${PROJECT_NAME} COUNT 7 APART ${_kind_APART})

  configure_file(${PUSHT_SERVING_CMAKE}/simulator_node.cpp.in ${name}_node.cpp @ONLY)
  add_executable(${name}_node ${CMAKE_CURRENT_BINARY_DIR}/${name}_node.cpp)
  target_link_libraries(${name}_node PRIVATE ${PROJECT_NAME} ${catkin_LIBRARIES})
  add_dependencies(${name}_node ${catkin_EXPORTED_TARGETS})
  pusht_compile_options(${name}_node)
  pusht_optimize_little(${name}_node)

  install(TARGETS ${PROJECT_NAME}
    ARCHIVE DESTINATION ${CATKIN_PACKAGE_LIB_DESTINATION}
    LIBRARY DESTINATION ${CATKIN_PACKAGE_LIB_DESTINATION})
  install(TARGETS ${name}_node RUNTIME DESTINATION ${CATKIN_PACKAGE_BIN_DESTINATION})
  install(DIRECTORY ${_kind_DIRECTORIES} DESTINATION ${CATKIN_PACKAGE_SHARE_DESTINATION})

  if(CATKIN_ENABLE_TESTING)
    find_package(rostest REQUIRED)
    add_rostest(test/${name}.test DEPENDENCIES ${name}_node)
  endif()
endfunction()
