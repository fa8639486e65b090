# SPDX-License-Identifier: BSD-3-Clause
# The message types as a jar: LCM_GEN writes Java for TYPES/*.lcm into WORK, JAVAC compiles it, JAR packs it into OUTPUT.
file(REMOVE_RECURSE ${WORK})
file(MAKE_DIRECTORY ${WORK}/source ${WORK}/classes)
get_filename_component(folder ${OUTPUT} DIRECTORY)
file(MAKE_DIRECTORY ${folder})
file(GLOB types ${TYPES}/*.lcm)
execute_process(COMMAND ${LCM_GEN} --java --jpath ${WORK}/source ${types} COMMAND_ERROR_IS_FATAL ANY)
file(GLOB_RECURSE sources ${WORK}/source/*.java)
execute_process(COMMAND ${JAVAC} -nowarn -Xlint:none -encoding UTF-8 -cp ${LCM_JAR} -d ${WORK}/classes ${sources}
                COMMAND_ERROR_IS_FATAL ANY)
execute_process(COMMAND ${JAR} cf ${OUTPUT} -C ${WORK}/classes . COMMAND_ERROR_IS_FATAL ANY)
