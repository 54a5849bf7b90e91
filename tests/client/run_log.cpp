// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/replay/run_log.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <fstream>
#include <string>
#include <vector>

#include "tests/support/temporary_folder.h"

using acus::TemporaryFolder;
using acus::client::LogError;
using acus::client::RunLog;

namespace {

std::vector<std::string> lines_of(const std::string& path) {
  std::ifstream file(path);
  std::vector<std::string> lines;
  for (std::string line; std::getline(file, line);) lines.push_back(line);
  return lines;
}

}  // namespace

TEST_CASE("a row per force state with units in the header, events beside it") {
  const TemporaryFolder folder;
  RunLog log(folder / "run.csv", true);
  acus::protocol::Force force;
  force.tick = 3;
  force.needle = "left, bent";
  force.phase = acus::protocol::Phase::inside;
  force.base_force = {0.1, -2, 1e-20};
  log.write(force, 0.25);
  acus::protocol::Event event;
  event.kind = acus::protocol::EventKind::puncture;
  event.region = "fat";
  event.force = 0.97;
  log.write(event);
  log.close();

  const auto forces = lines_of(log.path());
  REQUIRE(forces.size() == 2);
  for (const char* column :
       {"epoch,tick,time_s,needle,seq,age_s,echo_s,fresh,lost,reordered,limited,stale,phase,depth_m,",
        ",unheld_m,base_position_x_m,", ",haptic_force_z_N,haptic_torque_x_Nm,",
        "base_orientation_w,base_orientation_x,", ",commanded_position_x_m,", ",spin_rad,",
        ",base_force_x_N,base_force_y_N,", ",base_torque_in_base_z_Nm,", ",guide_force_z_N,", ",flags,received_s"}) {
    CHECK_MESSAGE(forces[0].find(column) != std::string::npos, column);
  }
  CHECK(forces[1].find("\"left, bent\"") != std::string::npos);
  CHECK(forces[1].find(",inside,") != std::string::npos);
  CHECK(forces[1].find(",0.1,-2,1e-20,") != std::string::npos);
  CHECK(forces[1].substr(forces[1].rfind(',')) == ",0.25");
  CHECK(std::count(forces[0].begin(), forces[0].end(), ',') + 1 == std::count(forces[1].begin(), forces[1].end(), ','));

  const auto events = lines_of(folder / "run.events.csv");
  REQUIRE(events.size() == 2);
  CHECK(events[0] == "epoch,tick,time_s,needle,kind,region,position_x_m,position_y_m,position_z_m,force_N");
  CHECK(events[1] == "0,0,0,,puncture,fat,0,0,0,0.97");
}

TEST_CASE("without wall time the rows hold nothing but the simulation") {
  const TemporaryFolder folder;
  RunLog log(folder / "run.csv", false);
  log.write(acus::protocol::Force{}, 0.25);
  log.close();
  CHECK(lines_of(log.path()).at(0).find("received_s") == std::string::npos);
}

TEST_CASE("a log that cannot be written says which file") {
  CHECK_THROWS_WITH_AS(RunLog("/nowhere/run.csv", true), "/nowhere/run.csv: cannot be written; does its folder exist?",
                       LogError);
}
