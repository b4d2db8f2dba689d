# Fails when PROGRAM with ARGUMENTS prints anything else than FILE holds.
execute_process(COMMAND ${PROGRAM} ${ARGUMENTS} OUTPUT_VARIABLE printed RESULT_VARIABLE code)
file(READ ${FILE} expected)
if(NOT code EQUAL 0 OR NOT printed STREQUAL expected)
  message(FATAL_ERROR "${FILE} is not what `${PROGRAM} ${ARGUMENTS}` prints (exit code ${code}): make it anew")
endif()
