# Manual pages for the Debian packages: help2man makes them of what the programs print for --help. Without it there are
# none.
find_program(HELP2MAN help2man)
find_program(GZIP gzip)
set(acus_manual_pages "")

# acus_manual_page(COMPONENT NAME "what it does" COMMAND DEPENDENCY...)
function(acus_manual_page component name meaning command)
  set(page ${PROJECT_BINARY_DIR}/man/${name}.1)
  add_custom_command(
    OUTPUT ${page}.gz
    COMMAND ${CMAKE_COMMAND} -E make_directory ${PROJECT_BINARY_DIR}/man
    COMMAND ${HELP2MAN} --no-info --locale=C.UTF-8 --name=${meaning} --version-string=${PROJECT_VERSION}
            --output=${page} ${command}
    COMMAND ${GZIP} --best --no-name --force ${page}
    DEPENDS ${ARGN} VERBATIM)
  install(FILES ${page}.gz DESTINATION ${CMAKE_INSTALL_MANDIR}/man1 COMPONENT ${component} OPTIONAL)
  set(acus_manual_pages ${acus_manual_pages} ${page}.gz PARENT_SCOPE)
endfunction()

# acus_program_page(COMPONENT TARGET "what it does")
macro(acus_program_page component program meaning)
  if(TARGET ${program})
    acus_manual_page(${component} ${program} ${meaning} $<TARGET_FILE:${program}> ${program})
  endif()
endmacro()

# acus_script_page(SCRIPT "what it does")
macro(acus_script_page script meaning)
  acus_manual_page(client acus-${script} ${meaning} ${PROJECT_SOURCE_DIR}/client/${script}
                   ${PROJECT_SOURCE_DIR}/client/python/acus/apps/${script}.py)
endmacro()

if(HELP2MAN AND GZIP)
  acus_program_page(server acus-server "simulates needles in soft tissue in real time")
  acus_program_page(server acus-mesh "reads mesh files for the other programs of Acus")
  acus_program_page(server acus-export "runs recordings of an Acus server again and exports them")
  acus_program_page(client acus-replay "drives a recorded motion into an Acus server")
  acus_program_page(client acus-haptic "puts a haptic device on a needle of an Acus server")
  acus_program_page(client acus-view "shows an Acus server in a browser")
  acus_program_page(client acus-keygen "makes keys for Acus servers and clients")
  acus_script_page(plot "draws the forces of a recorded Acus run, or how punctual it was")
  acus_script_page(picture "draws cuts through the tissue of a recorded Acus run")
  acus_script_page(top "shows how a running Acus server does")
  acus_script_page(study "runs studies of Acus scenes on a cluster, serves them, says how far they are")
  acus_script_page(fit "finds the parameters of an Acus scene from measured curves")
  add_custom_target(acus_manual ALL DEPENDS ${acus_manual_pages})
endif()
