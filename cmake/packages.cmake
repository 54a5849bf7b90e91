# Debian packages, which scripts/package builds: acus-server, acus-client, python3-acus, python3-acus-engine, libacus-dev,
# libacus-engine-dev and acus-scenes, each with what install.cmake gives its component. Files that only packages have are of the same
# components, and left out of `cmake --install`.
set(ACUS_MAINTAINER "The Acus authors <authors@acus.example>" CACHE STRING "Who answers for the Debian packages")
set(acus_debian_revision 1)
set(acus_components server client python dev engine scenes)
if(TARGET acus_engine_python)
  list(APPEND acus_components pyengine)
endif()
set(acus_package_server acus-server)
set(acus_package_client acus-client)
set(acus_package_python python3-acus)
set(acus_package_dev libacus-dev)
set(acus_package_engine libacus-engine-dev)
set(acus_package_pyengine python3-acus-engine)
set(acus_package_scenes acus-scenes)

if(TARGET acus_engine_python)
  get_target_property(acus_python acus_engine_python ACUS_PYTHON)
  string(REPLACE "." ";" acus_python "${acus_python}")
  list(GET acus_python 1 acus_python_minor)
  math(EXPR acus_next_python_minor "${acus_python_minor} + 1")
endif()

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME acus)
set(CPACK_PACKAGE_VENDOR "The Acus authors")
set(CPACK_PACKAGE_CONTACT "${ACUS_MAINTAINER}")
set(CPACK_PACKAGE_VERSION ${PROJECT_VERSION})
set(CPACK_PACKAGE_DIRECTORY ${PROJECT_SOURCE_DIR}/build/packages)
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "")  # the first line of each description below is its own
set(CPACK_STRIP_FILES ON)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ
                                                WORLD_EXECUTE)
set(CPACK_COMPONENTS_ALL ${acus_components})
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_RELEASE ${acus_debian_revision})
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_PRIORITY optional)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)

set(CPACK_DEBIAN_SERVER_DESCRIPTION "simulates needles in soft tissue in real time
Acus simulates flexible needles that enter soft tissue, a thousand times a
second, and serves forces and shapes over ZeroMQ to haptic devices and
viewers. This package has the server, a systemd unit for it, acus-export, which
runs recordings again, and acus-mesh, which reads mesh files for both.

The programs need a processor of the level x86-64-v3 and say so where it is
older.")
set(CPACK_DEBIAN_CLIENT_DESCRIPTION "replay, plots and a monitor for Acus servers
Acus simulates needles in soft tissue in real time. This package has programs
that talk to its server: acus-replay drives recorded motions into it and writes
what comes back, acus-plot and acus-picture draw that,
acus-top shows how a running server does, acus-view shows it in a browser,
acus-keygen makes keys for server and clients, and acus-haptic puts a haptic
device, a gamepad or a simulated hand on a needle. acus-study runs programs with
studies on a cluster, acus-fit finds the parameters of a scene from measured
curves, acus-cloud shows where a tip may be.")
set(CPACK_DEBIAN_PYTHON_DESCRIPTION "Python package for Acus servers
Acus simulates needles in soft tissue in real time. This package has the
Python module acus: a client of its server, servers of one's own, scenes,
recorded runs as arrays, and environments for learning to steer needles.")
set(CPACK_DEBIAN_DEV_DESCRIPTION "client library of Acus, development files
Acus simulates needles in soft tissue in real time. This package has headers,
static libraries and the CMake package of its protocol, of its C++ client
library and of its haptic kit.")
set(CPACK_DEBIAN_ENGINE_DESCRIPTION "simulation of Acus as a library, development files
Acus simulates needles in soft tissue in real time. This package has headers
and a static library of its engine, for programs that step scenes themselves,
without a server. They need a processor of the level x86-64-v3.")
set(CPACK_DEBIAN_PYENGINE_DESCRIPTION "simulation of Acus as a Python module
Acus simulates needles in soft tissue in real time. This package has the module
behind acus.engine, which steps scenes in the Python process itself, without a
server. It needs a processor of the level x86-64-v3.")
set(CPACK_DEBIAN_SCENES_DESCRIPTION "scenes and documents of Acus
Acus simulates needles in soft tissue in real time. This package has scenes for
its server, with their meshes and recorded motions, and the documents.")

set(CPACK_DEBIAN_SERVER_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_CLIENT_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_SERVER_PACKAGE_RECOMMENDS "acus-scenes, libopenblas0-serial")
set(CPACK_DEBIAN_SERVER_PACKAGE_SUGGESTS acus-client)
set(CPACK_DEBIAN_CLIENT_PACKAGE_DEPENDS "python3, python3-acus (= ${PROJECT_VERSION}-${acus_debian_revision})")
set(CPACK_DEBIAN_CLIENT_PACKAGE_RECOMMENDS "acus-server, python3-matplotlib, python3-pil")
set(CPACK_DEBIAN_CLIENT_PACKAGE_SUGGESTS "chromium, ffmpeg") # acus-view --export
set(CPACK_DEBIAN_PYTHON_PACKAGE_ARCHITECTURE all)
set(CPACK_DEBIAN_PYTHON_PACKAGE_SECTION python)
set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS "python3, python3-msgpack, python3-numpy, python3-zmq")
set(CPACK_DEBIAN_PYTHON_PACKAGE_SUGGESTS "acus-server, python3-acus-engine, python3-cloudpickle, python3-distributed, python3-matplotlib, python3-pandas, python3-scipy")
set(CPACK_DEBIAN_DEV_PACKAGE_DEPENDS "libzmq3-dev, pkg-config")
set(CPACK_DEBIAN_DEV_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_ENGINE_PACKAGE_DEPENDS
    "libacus-dev (= ${PROJECT_VERSION}-${acus_debian_revision}), libeigen3-dev, libsuitesparse-dev, libxxhash-dev, libyaml-cpp-dev, libzstd-dev")
set(CPACK_DEBIAN_ENGINE_PACKAGE_RECOMMENDS "acus-server, libopenblas0-serial")
set(CPACK_DEBIAN_ENGINE_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_PYENGINE_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PYENGINE_PACKAGE_DEPENDS
    "python3 (>= 3.${acus_python_minor}), python3 (<< 3.${acus_next_python_minor}), python3-acus (= ${PROJECT_VERSION}-${acus_debian_revision})")
set(CPACK_DEBIAN_PYENGINE_PACKAGE_RECOMMENDS "acus-scenes, acus-server, libopenblas0-serial")
set(CPACK_DEBIAN_PYENGINE_PACKAGE_SECTION python)
set(CPACK_DEBIAN_SCENES_PACKAGE_ARCHITECTURE all)

set(acus_debian_dir ${PROJECT_SOURCE_DIR}/cmake/debian)
set(CPACK_DEBIAN_SERVER_PACKAGE_CONTROL_EXTRA ${acus_debian_dir}/server/postinst ${acus_debian_dir}/server/prerm
                                              ${acus_debian_dir}/server/postrm)
set(CPACK_DEBIAN_CLIENT_PACKAGE_CONTROL_EXTRA ${acus_debian_dir}/client/prerm)
set(CPACK_DEBIAN_PYTHON_PACKAGE_CONTROL_EXTRA ${acus_debian_dir}/python/prerm)

# The changelog and the copyright that policy asks every package for.
set(acus_debian_files ${PROJECT_BINARY_DIR}/debian)
configure_file(${acus_debian_dir}/changelog.in ${acus_debian_files}/changelog.Debian @ONLY)
configure_file(${PROJECT_SOURCE_DIR}/CHANGELOG.md ${acus_debian_files}/changelog COPYONLY)
if(GZIP)
  foreach(name changelog.Debian changelog)
    execute_process(COMMAND ${GZIP} --best --no-name --force --keep ${acus_debian_files}/${name}
                    COMMAND_ERROR_IS_FATAL ANY)
  endforeach()
endif()
foreach(component ${acus_components})
  set(package ${acus_package_${component}})
  string(TOUPPER ${component} upper)
  set(CPACK_DEBIAN_${upper}_PACKAGE_NAME ${package})
  install(FILES ${acus_debian_dir}/copyright ${acus_debian_files}/changelog.Debian.gz ${acus_debian_files}/changelog.gz
          DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/${package} COMPONENT ${component} EXCLUDE_FROM_ALL OPTIONAL)
  install(FILES ${acus_debian_dir}/${component}/lintian-overrides RENAME ${package}
          DESTINATION ${CMAKE_INSTALL_DATADIR}/lintian/overrides COMPONENT ${component} EXCLUDE_FROM_ALL OPTIONAL)
endforeach()
include(CPack)
