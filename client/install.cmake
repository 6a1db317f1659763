# cmake --install: the robot library as a package, find_package(headframe) and link headframe::robot_client.
include(CMakePackageConfigHelpers)
set(rooms headframe_options headframe_proto headframe_geometry headframe_cloud headframe_coverage headframe_signature headframe_network
  headframe_descriptor headframe_wire headframe_security headframe_dataset headframe_keyframe headframe_spool
  headframe_credential headframe_uplink headframe_robot_client)
if(HEADFRAME_NETWORKS)
  list(APPEND rooms headframe_onnx)
endif()
set_target_properties(${rooms} PROPERTIES POSITION_INDEPENDENT_CODE ON)  # for programs that load them, as Python does
foreach(room ${rooms})
  string(REPLACE headframe_ "" exported ${room})
  set_target_properties(${room} PROPERTIES EXPORT_NAME ${exported})
endforeach()
install(TARGETS ${rooms} EXPORT headframe ARCHIVE DESTINATION lib/headframe COMPONENT robot)
install(TARGETS headframe-replay RUNTIME DESTINATION bin COMPONENT robot)
install(DIRECTORY ${CMAKE_SOURCE_DIR}/client ${CMAKE_SOURCE_DIR}/common DESTINATION include/headframe COMPONENT robot
  FILES_MATCHING PATTERN *.hpp)
install(EXPORT headframe NAMESPACE headframe:: DESTINATION lib/cmake/headframe FILE headframeTargets.cmake COMPONENT robot)
write_basic_package_version_file(${CMAKE_CURRENT_BINARY_DIR}/headframeConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES headframeConfig.cmake ${CMAKE_CURRENT_BINARY_DIR}/headframeConfigVersion.cmake
  DESTINATION lib/cmake/headframe COMPONENT robot)
