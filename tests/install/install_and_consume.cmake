# Installs the build in BUILD_DIR to an empty prefix, then configures, builds and runs the project in CONSUMER_DIR
# against it. cmake -D ... -P install_and_consume.cmake
function(run)
  execute_process(COMMAND ${ARGV} COMMAND_ECHO STDOUT COMMAND_ERROR_IS_FATAL ANY)
endfunction()

file(REMOVE_RECURSE ${WORK_DIR})
set(prefix ${WORK_DIR}/prefix)
run(${CMAKE_COMMAND} --install ${BUILD_DIR} --prefix ${prefix})

# The links between the installed documents.
run(${CMAKE_COMMAND} -E env ACUS_DOCUMENTS=${prefix}/${DOCUMENTS} /usr/bin/python3 ${LINKS_TEST} Documents.test_links)

set(flags "")
if(SANITIZE)  # the libraries refer to the sanitizers' runtime
  set(flags "-fsanitize=${SANITIZE}")
endif()
run(${CMAKE_COMMAND} -S ${CONSUMER_DIR} -B ${WORK_DIR}/build -G ${GENERATOR} -D CMAKE_PREFIX_PATH=${prefix}
    -D CMAKE_CXX_COMPILER=${COMPILER} -D CMAKE_CXX_FLAGS=${flags})
run(${CMAKE_COMMAND} --build ${WORK_DIR}/build)
run(${WORK_DIR}/build/consumer)
if(EXAMPLE_DIR)
  run(${CMAKE_COMMAND} -S ${EXAMPLE_DIR} -B ${WORK_DIR}/example -G ${GENERATOR} -D CMAKE_PREFIX_PATH=${prefix}
      -D CMAKE_CXX_COMPILER=${COMPILER} -D CMAKE_CXX_FLAGS=${flags})
  run(${CMAKE_COMMAND} --build ${WORK_DIR}/example)
  execute_process(COMMAND ${WORK_DIR}/example/push ${prefix}/share/acus/scenes/layers.yaml
                  OUTPUT_VARIABLE forces COMMAND_ERROR_IS_FATAL ANY)
  if(NOT forces MATCHES "\n7.9 [3-9][0-9].[0-9]+ [0-9].[0-9]+\n") # it is deep in the tissue, and bears a force
    message(FATAL_ERROR "push printed\n${forces}")
  endif()
endif()
run(${prefix}/bin/acus-replay --help)
run(${prefix}/bin/acus-keygen --help)
run(${prefix}/bin/acus-haptic --help)
if(EXISTS ${BUILD_DIR}/bin/acus-view)
  run(${prefix}/bin/acus-view --help)
endif()
run(${prefix}/bin/acus-top --help)
run(${prefix}/bin/acus-plot --help)
run(${prefix}/bin/acus-study cluster --help)
run(${prefix}/bin/acus-fit --help)
run(${prefix}/bin/acus-cloud --help)
run(${prefix}/bin/acus-picture --help)
