# acus-study: many simulations in process, and what they show as tables.
add_library(acus_study STATIC
  study/csv.cpp study/error_settings.cpp study/errors.cpp study/experiment.cpp study/locking.cpp study/mesh_dependence.cpp
  study/study_errors.cpp study/study_refinement.cpp study/study_stability.cpp
  study/stability_cases.cpp study/stability_criteria.cpp study/stability_mesh.cpp study/stability_run.cpp
  study/stability_trial.cpp)
target_link_libraries(acus_study PUBLIC acus_bench)

add_executable(acus-study study/study_main.cpp)
target_link_libraries(acus-study PRIVATE acus_study CLI11::CLI11)
