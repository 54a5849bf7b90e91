# acus-bench: the simulation without sockets, timed. Trajectories come from the client library.
find_package(CLI11 REQUIRED)

add_library(acus_bench STATIC
  bench/bench_report.cpp bench/calibration.cpp bench/measurement.cpp bench/trajectory_driver.cpp)
target_include_directories(acus_bench SYSTEM PUBLIC ${CHOLMOD_INCLUDE})
target_link_libraries(acus_bench PUBLIC acus_simulation acus_client PRIVATE ${CHOLMOD_LIBRARY})

# Where sanitizers need malloc for themselves, nothing is to be measured.
if(NOT ACUS_SANITIZE)
  add_executable(acus-bench bench_main.cpp bench/allocation_count.cpp)
  target_link_libraries(acus-bench PRIVATE acus_bench CLI11::CLI11)
endif()
