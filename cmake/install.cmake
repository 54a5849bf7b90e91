# Installs the programs, the scenes, and the protocol and client libraries for find_package(acus), which offers
# acus::protocol, acus::client and acus::haptics. Headers are included as in the sources: "client/link/client.h" from
# include/acus.
# With COMPONENTS engine it offers acus::engine, too, the simulation as a library.
# Components are the Debian packages of packages.cmake: server, client, python, pyengine, dev, engine, scenes; licences go into no package, which
# has a file `copyright` instead.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

set(acus_package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/acus)

install(TARGETS acus_protocol acus_client acus_haptics EXPORT acus_targets
        ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT dev)
install(DIRECTORY protocol client DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/acus COMPONENT dev
        FILES_MATCHING PATTERN "*.h" PATTERN "socket.h" EXCLUDE PATTERN "command_line.h" EXCLUDE PATTERN "packer.h" EXCLUDE
        PATTERN "client/haptics/devices" EXCLUDE PATTERN "client/haptics/program" EXCLUDE PATTERN "client/view" EXCLUDE)
install(EXPORT acus_targets NAMESPACE acus:: FILE acusTargets.cmake DESTINATION ${acus_package_dir} COMPONENT dev)

if(TARGET acus_engine)
  install(TARGETS acus_engine acus_engine_flags EXPORT acus_engine_targets
          ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT engine)
  install(DIRECTORY server/engine DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/acus/server COMPONENT engine
          FILES_MATCHING PATTERN "*.h" PATTERN "example" EXCLUDE)
  install(DIRECTORY server/engine/example DESTINATION ${CMAKE_INSTALL_DOCDIR}/server/engine COMPONENT scenes)
  install(FILES protocol/packer.h DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/acus/protocol COMPONENT engine)
  install(EXPORT acus_engine_targets NAMESPACE acus:: FILE acusEngineTargets.cmake DESTINATION ${acus_package_dir}
          COMPONENT engine)
endif()

configure_package_config_file(${PROJECT_SOURCE_DIR}/cmake/acusConfig.cmake.in ${PROJECT_BINARY_DIR}/acusConfig.cmake
                              INSTALL_DESTINATION ${acus_package_dir})
# Until version 1.0 a minor version may break what stands before it.
write_basic_package_version_file(${PROJECT_BINARY_DIR}/acusConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/acusConfig.cmake ${PROJECT_BINARY_DIR}/acusConfigVersion.cmake
        DESTINATION ${acus_package_dir} COMPONENT dev)

install(TARGETS acus-replay acus-haptic acus-keygen RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT client)
if(TARGET acus-view)
  install(TARGETS acus-view RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT client)
  foreach(file index.html view.css view.js NOTICE)
    install(FILES ${PROJECT_BINARY_DIR}/view/${file} DESTINATION ${CMAKE_INSTALL_DATADIR}/acus/view COMPONENT client)
  endforeach()
endif()
# The Python programs are modules of the package, and links to one launcher.
install(PROGRAMS client/python/launch DESTINATION ${CMAKE_INSTALL_DATADIR}/acus/client COMPONENT client)
foreach(script plot picture top study fit cloud)
  file(RELATIVE_PATH target ${CMAKE_INSTALL_FULL_BINDIR} ${CMAKE_INSTALL_FULL_DATADIR}/acus/client/launch)
  file(CREATE_LINK ${target} ${PROJECT_BINARY_DIR}/acus-${script} SYMBOLIC)
  install(FILES ${PROJECT_BINARY_DIR}/acus-${script} DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT client)
endforeach()
# acus-view looks for it beside itself, in a build, too.
file(MAKE_DIRECTORY ${CMAKE_RUNTIME_OUTPUT_DIRECTORY})
file(CREATE_LINK ${PROJECT_SOURCE_DIR}/client/python/launch ${CMAKE_RUNTIME_OUTPUT_DIRECTORY}/acus-cloud SYMBOLIC)
# Python itself finds the package there below /usr; the programs above also below other prefixes.
install(DIRECTORY client/python/acus DESTINATION lib/python3/dist-packages COMPONENT python
        FILES_MATCHING PATTERN "*.py" PATTERN py.typed PATTERN __pycache__ EXCLUDE)
if(TARGET acus_engine_python)
  install(TARGETS acus_engine_python LIBRARY DESTINATION lib/python3/dist-packages COMPONENT pyengine)
endif()
install(DIRECTORY client/python/examples DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/python3-acus COMPONENT python
        FILES_MATCHING PATTERN "*.py" PATTERN "*.ipynb" PATTERN __pycache__ EXCLUDE)
if(TARGET acus-server)
  install(TARGETS acus-server acus-export RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT server)
  if(TARGET acus-mesh)
    install(TARGETS acus-mesh RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT server)
  endif()
  # systemd finds units below /usr and /usr/local.
  install(FILES cmake/acus-server@.service DESTINATION lib/systemd/system COMPONENT server)
  install(DIRECTORY scenes/ DESTINATION ${CMAKE_INSTALL_DATADIR}/acus/scenes COMPONENT scenes
          PATTERN pictures EXCLUDE PATTERN README.md EXCLUDE
          PATTERN make-trajectories EXCLUDE)
endif()

# The documents stand to each other as in the sources, so that the links between them lead somewhere.
install(FILES README.md CHANGELOG.md CONTRIBUTING.md DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT scenes)
install(FILES LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT licences)
install(FILES client/LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR} RENAME LICENSE.client-and-protocol COMPONENT licences)
foreach(folder docs protocol scenes server tests/benchmarks tests/references)
  file(GLOB documents CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/${folder}/*.md)
  install(FILES ${documents} DESTINATION ${CMAKE_INSTALL_DOCDIR}/${folder} COMPONENT scenes)
endforeach()
install(FILES docs/figures.json DESTINATION ${CMAKE_INSTALL_DOCDIR}/docs COMPONENT scenes)
install(FILES server/model_path.svg DESTINATION ${CMAKE_INSTALL_DOCDIR}/server COMPONENT scenes)
install(DIRECTORY scenes/pictures DESTINATION ${CMAKE_INSTALL_DOCDIR}/scenes COMPONENT scenes)
