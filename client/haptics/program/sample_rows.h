// SPDX-License-Identifier: MIT
// Samples of sessions as rows of CSV.
#pragma once

#include <cstdio>
#include <initializer_list>
#include <ostream>

#include "client/haptics/program/pupil.h"
#include "client/haptics/program/session.h"

namespace acus::haptics {

inline constexpr const char* kSampleHeader =
    "t_s,device_x_m,device_y_m,device_z_m,base_x_m,base_y_m,base_z_m,wanted_x_N,wanted_y_N,wanted_z_N,force_x_N,force_"
    "y_N,force_z_N,server_x_N,server_y_N,server_z_N,account_J,withheld_J\n";
inline constexpr const char* kPupilHeader =
    "t_s,device_x_m,device_y_m,device_z_m,force_x_N,force_y_N,force_z_N,ahead_x_m,ahead_y_m,ahead_z_m,share,account_J\n";

// The time, the coordinates of the vectors, the numbers.
inline void write_row(std::ostream& out, double time, std::initializer_list<Vector3> vectors,
                      std::initializer_list<double> numbers) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6f", time);
  out << text;
  const auto add = [&](double value) {
    std::snprintf(text, sizeof text, ",%.9g", value);
    out << text;
  };
  for (const Vector3& each : vectors)
    for (const double coordinate : each.at) add(coordinate);
  for (const double each : numbers) add(each);
  out << '\n';
}

inline void write(std::ostream& out, const SampleRecord& sample) {
  write_row(out, sample.time,
            {sample.device.position, sample.base.position, sample.wanted.force, sample.rendered.force,
             sample.server.force},
            {sample.account, sample.withheld});
}

inline void write(std::ostream& out, const PupilSample& sample) {
  write_row(out, sample.time, {sample.device.position, sample.rendered.force, wrench_of(sample.ahead).force},
            {sample.share, sample.account});
}

}  // namespace acus::haptics
