# cmake -DJAVA= -DJAVAC= -DCLASSPATH= -DSOURCE= -DWORK= -P run.cmake: compiles ViewTest.java and runs it in WORK,
# where the pictures it paints stay for people to look at.
file(REMOVE_RECURSE ${WORK})
file(MAKE_DIRECTORY ${WORK})
execute_process(COMMAND ${JAVAC} --release 11 -cp ${CLASSPATH} -d ${WORK} ${SOURCE} COMMAND_ERROR_IS_FATAL ANY)
execute_process(COMMAND ${JAVA} -cp ${CLASSPATH}:${WORK} vantage.spy.ViewTest WORKING_DIRECTORY ${WORK}
                COMMAND_ERROR_IS_FATAL ANY)
