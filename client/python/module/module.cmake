# `import headframe`: the robot library for Python, where pybind11 is. Debian's Python, for whoever has another one before it.
set(HEADFRAME_PYTHON /usr/bin/python3 CACHE FILEPATH "A Python that has numpy and protobuf")
set(PYTHON_EXECUTABLE ${HEADFRAME_PYTHON})
find_package(pybind11 CONFIG QUIET)
if(NOT pybind11_FOUND)
  message(STATUS "import headframe is left out: it needs pybind11-dev, python3-dev and python3-numpy (docker/install-deps)")
  return()
endif()
set(python_module ${CMAKE_BINARY_DIR}/python-module)
pybind11_add_module(headframe_python_module MODULE NO_EXTRAS python/module/headframe/module.cpp python/module/headframe/arrays.cpp)
target_link_libraries(headframe_python_module PRIVATE headframe_robot_client)
set_target_properties(headframe_python_module PROPERTIES OUTPUT_NAME _robot UNITY_BUILD OFF CXX_VISIBILITY_PRESET hidden
  LIBRARY_OUTPUT_DIRECTORY ${python_module}/headframe)
# What is Python lies beside it; headframe.operator works from where it is too.
set(python_sources ${CMAKE_CURRENT_SOURCE_DIR}/python/module/headframe)
file(GLOB python_files CONFIGURE_DEPENDS ${python_sources}/*.py ${python_sources}/*.pyi ${python_sources}/operator/*.py)
add_custom_command(TARGET headframe_python_module POST_BUILD
  COMMAND ${CMAKE_COMMAND} -E copy_if_different ${python_sources}/__init__.py ${python_sources}/__init__.pyi
    ${python_sources}/robot.py ${python_sources}/py.typed ${python_module}/headframe
  COMMAND ${CMAKE_COMMAND} -E copy_directory ${python_sources}/operator ${python_module}/headframe/operator)
set_property(TARGET headframe_python_module APPEND PROPERTY LINK_DEPENDS ${python_files})
