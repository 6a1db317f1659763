# Installs the robot library from BUILD, and builds and runs the example of SOURCE against it in OUT.
function(run expected)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE status OUTPUT_VARIABLE out ERROR_VARIABLE out)
  if(NOT status EQUAL expected)
    list(JOIN ARGN " " command)
    message(FATAL_ERROR "${command}\nended with ${status}, not ${expected}:\n${out}")
  endif()
endfunction()

file(REMOVE_RECURSE ${OUT})
run(0 ${CMAKE_COMMAND} --install ${BUILD} --prefix ${OUT}/prefix --component robot)
run(0 ${CMAKE_COMMAND} -G Ninja -S ${SOURCE}/tests/installed -B ${OUT}/build -DCMAKE_PREFIX_PATH=${OUT}/prefix
  -DCMAKE_BUILD_TYPE=Release -DEXAMPLE=${SOURCE}/client/example.cpp)
run(0 ${CMAKE_COMMAND} --build ${OUT}/build)
run(2 ${OUT}/build/robot)
run(1 ${OUT}/build/robot ${OUT}/no-recording localhost)
run(0 ${OUT}/prefix/bin/headframe-replay --help)
