# The server around the simulation: real-time loop, sockets, program.
find_package(CLI11 REQUIRED)

add_library(acus_server_core STATIC loaded_scene.cpp realtime_loop.cpp publisher.cpp endpoint.cpp listening.cpp
                                    privileges.cpp termination.cpp)
target_link_libraries(acus_server_core PUBLIC acus_simulation acus_protocol PkgConfig::zeromq Threads::Threads
                                              spdlog::spdlog)
target_compile_definitions(acus_server_core PUBLIC ACUS_VERSION="${PROJECT_VERSION}")

add_executable(acus-server main.cpp)
target_link_libraries(acus-server PRIVATE acus_server_core CLI11::CLI11)
