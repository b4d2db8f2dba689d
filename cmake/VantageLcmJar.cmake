# cmake -DLCM_GEN= -DJAVAC= -DJAR= -DLCM_JAR= -DWORK= -DOUT= -DTYPES=<list> -DPLUGINS=<list> -P VantageLcmJar.cmake
#
# Compiles the Java bindings of TYPES and the plugins for lcm-spy into the jar OUT. A script, because which .java files there are is
# known only after lcm-gen has run.
cmake_minimum_required(VERSION 3.25)

function(run)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if(NOT result EQUAL 0)
    message(FATAL_ERROR "${ARGN} failed:\n${output}")
  endif()
endfunction()

file(REMOVE_RECURSE ${WORK})
file(MAKE_DIRECTORY ${WORK}/classes)
run(${LCM_GEN} --java --jpath ${WORK}/source ${TYPES})
file(GLOB_RECURSE sources ${WORK}/source/*.java)
# For any Java that can run lcm-spy, not only the one that compiles.
run(${JAVAC} --release 11 -nowarn -classpath ${LCM_JAR} -d ${WORK}/classes ${sources} ${PLUGINS})
cmake_path(GET OUT PARENT_PATH folder)
file(MAKE_DIRECTORY ${folder})
run(${JAR} --create --file ${OUT} -C ${WORK}/classes .)
