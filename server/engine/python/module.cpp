// SPDX-License-Identifier: GPL-3.0-or-later
// The engine as a Python module, acus_engine; client/python/acus/engine.py is what users import. Names, units and
// frames are those of the protocol (protocol/README.md), quaternions are w, x, y, z.
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <algorithm>
#include <span>

#include "protocol/enums.h"
#include "protocol/printable.h"
#include "protocol/unit_quaternion.h"
#include "server/engine/math/rotation.h"
#include "server/engine/python/engine_state.h"
#include "server/engine/scene/field_error.h"
#include "server/engine/scene/files/mesh_process.h"
#include "server/engine/scene/text/text_table.h"
#include "server/engine/state/bytes/adoption.h"
#include "server/engine/state/bytes/snapshot.h"
#include "server/engine/state/bytes/state_bytes.h"
#include "server/engine/state/clearance.h"
#include "server/engine/state/placement.h"
#include "server/engine/tick/base_motion.h"
#include "server/engine/tick/drawn_tissue.h"

namespace py = pybind11;

namespace acus::python {
namespace {

using Array = py::array_t<double>;

// ---- Arrays ----

Array array_of(const Vector3& v) { return Array(3, v.data()); }

Array array_of(const Quaternion& q) {
  const double values[]{q.w(), q.x(), q.y(), q.z()};
  return Array(4, values);
}

// The columns of a matrix as rows, without a copy; not to be written. `owner` lives as long.
py::array rows_of(const Matrix3X& m, py::handle owner) {
  Array view({m.cols(), Eigen::Index{3}}, {3 * sizeof(double), sizeof(double)}, m.data(), owner);
  view.attr("flags").attr("writeable") = false;
  return view;
}

py::array rows_of(const std::vector<std::array<int, 4>>& rows, py::handle owner) {
  py::array_t<int> view({rows.size(), std::size_t{4}}, {4 * sizeof(int), sizeof(int)},
                        rows.empty() ? nullptr : rows.front().data(), owner);
  view.attr("flags").attr("writeable") = false;
  return view;
}

Vector3 vector_from(const py::handle& given, const std::string& what) {
  const auto array = Array::ensure(given);
  if (!array || array.ndim() != 1 || array.size() != 3) throw py::value_error(what + ": expected 3 numbers");
  return {array.at(0), array.at(1), array.at(2)};
}

Quaternion quaternion_from(const py::handle& given, const std::string& what) {
  const auto array = Array::ensure(given);
  if (!array || array.ndim() != 1 || array.size() != 4) throw py::value_error(what + ": expected 4 numbers, w x y z");
  const double w = array.at(0), x = array.at(1), y = array.at(2), z = array.at(3);
  const double length = protocol::quaternion_length(w, x, y, z);
  if (!protocol::is_unit_length(length))
    throw py::value_error(what + ": expected a unit quaternion, its length is " + std::to_string(length));
  return {w / length, x / length, y / length, z / length};
}

// ---- Reports ----

struct Report {
  std::shared_ptr<EngineModel> model;
  TickReport report;
};

// What a tick tells of one needle; `of` keeps it.
struct ReportOfNeedle {
  std::shared_ptr<const Report> of;
  int needle;

  const NeedleReport& report() const { return of->report.needles[static_cast<std::size_t>(needle)]; }
  Quaternion world_from_base() const { return report().base.orientation; }
};

struct ReportOfEvent {
  std::shared_ptr<const Report> of;
  Event event;

  const Scene& scene() const { return of->model->scene(); }
};

std::shared_ptr<Report> report_of(const EngineState& state, TickReport report) {
  return std::make_shared<Report>(Report{state.model, std::move(report)});
}

std::vector<ReportOfEvent> events_of(const std::shared_ptr<Report>& report) {
  std::vector<ReportOfEvent> events;
  for (const Event& event : report->report.events) events.push_back({report, event});
  return events;
}

// ---- Steps ----

// (position, orientation) or (position, orientation, spin); None leaves position and orientation, or spin, as they are.
// `body` for errors.
Command command_from(const py::handle& given, const std::string& body, bool guide) {
  const auto error = [&body](const std::string& what) {
    return py::value_error("the command of '" + body + "': " + what);
  };
  if (!py::isinstance<py::sequence>(given) || py::len(given) < 2 || py::len(given) > 3)
    throw error("expected (position, orientation) or (position, orientation, spin)");
  const auto parts = py::reinterpret_borrow<py::sequence>(given);
  const py::object position = parts[0], orientation = parts[1];
  Command command;
  if (position.is_none() != orientation.is_none()) throw error("position and orientation go together");
  if (!position.is_none())
    command.pose = Pose{vector_from(position, "the position of '" + body + "'"),
                        quaternion_from(orientation, "the orientation of '" + body + "'")};
  if (py::len(given) == 3 && !py::object(parts[2]).is_none()) {
    const auto spin = Array::ensure(parts[2]);
    if (!spin || spin.size() != 1) throw error("spin: expected a number");
    command.spin = *spin.data();
  }
  if (guide && command.spin) throw error("guides do not spin");
  if (!in_range(command)) throw error("a number is not finite, or too large");
  return command;
}

std::map<int, Command> commands_from(const EngineState& state, const py::dict& given) {
  const Model& model = state.model->model();
  std::map<int, Command> commands;
  for (const auto& [key, value] : given) {
    const std::string name = py::str(key);
    const int body = state.model->body(name), guide = body - model.needle_count();
    Command command = command_from(value, name, guide >= 0);
    command.seq = 1 + (guide < 0 ? state.state.bases[body] : state.state.guides[guide].motion).command_seq;
    commands[body] = command;
  }
  return commands;
}

constexpr const char* kBusy = "another thread steps this state; copy() it first, or wait for it";

// For who reads it: not while another thread steps it.
const EngineState& resting(const EngineState& state) {
  if (state.busy) throw std::runtime_error(kBusy);
  return state;
}

// One thread at a time: the interpreter's lock is not held while it steps.
class Stepping {
 public:
  explicit Stepping(EngineState& state) : state_(state) {
    if (std::exchange(state_.busy, true)) throw std::runtime_error(kBusy);
  }
  ~Stepping() { state_.busy = false; }
  Stepping(const Stepping&) = delete;
  Stepping& operator=(const Stepping&) = delete;

 private:
  EngineState& state_;
};

std::vector<TickReport> run(EngineState& state, const py::dict& commands, int ticks, bool each) {
  if (ticks < 1) throw py::value_error("ticks: expected at least 1, found " + std::to_string(ticks));
  const std::map<int, Command> parsed = commands_from(state, commands);
  const Stepping stepping(state);
  std::vector<TickReport> reports;
  bool interrupted = false;
  {
    const py::gil_scoped_release release;
    state.step(parsed, ticks, each ? &reports : nullptr, [&interrupted] {
      const py::gil_scoped_acquire acquire;
      return interrupted = PyErr_CheckSignals() != 0;
    });
  }
  if (interrupted) throw py::error_already_set();  // as KeyboardInterrupt; the state is that of the last tick
  if (!each) reports.push_back(state.report);
  return reports;
}

std::shared_ptr<Report> step(EngineState& state, const py::dict& commands, int ticks) {
  return report_of(state, std::move(run(state, commands, ticks, false).front()));
}

std::vector<std::shared_ptr<Report>> trace(EngineState& state, const py::dict& commands, int ticks) {
  std::vector<std::shared_ptr<Report>> reports;
  for (TickReport& each : run(state, commands, ticks, true)) reports.push_back(report_of(state, std::move(each)));
  return reports;
}

// ---- States as bytes ----

py::bytes bytes_of(const EngineState& state) {
  const std::vector<std::byte> bytes = make_snapshot(state.model->model().fingerprint, resting(state).state);
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

EngineState from_bytes(const std::shared_ptr<EngineModel>& model, const py::bytes& given) {
  const std::string_view bytes = given;
  try {
    return {model, read_snapshot(model->model(), std::as_bytes(std::span(bytes)))};
  } catch (const SnapshotError& error) {
    throw py::value_error(error.what());
  }
}

EngineState adopted(const std::shared_ptr<EngineModel>& model, const EngineState& state) {
  try {
    return {model, adopt(model->model(), state.model->model(), resting(state).state)};
  } catch (const AdoptionError& error) {
    throw py::value_error(error.what());
  }
}

Array orientations(const EngineState& state, const std::string& needle) {
  const auto& q = resting(state).state.needles[static_cast<std::size_t>(state.model->needle(needle))].q;
  Array all({q.size(), std::size_t{4}});
  auto rows = all.mutable_unchecked<2>();
  for (std::size_t i = 0; i < q.size(); ++i) {
    const auto row = static_cast<py::ssize_t>(i);
    rows(row, 0) = q[i].w(), rows(row, 1) = q[i].x(), rows(row, 2) = q[i].y(), rows(row, 3) = q[i].z();
  }
  return all;
}

DrawnTissue drawn_of(const EngineState& state) {
  DrawnTissue drawn(state.model->model());
  draw_tissue(state.model->model(), resting(state).state, drawn);
  return drawn;
}

std::vector<Array> paths_of(const EngineState& state) {
  const DrawnTissue drawn = drawn_of(state);
  std::vector<Array> paths;
  int first = 0;
  for (const int size : drawn.path_sizes) {
    Array points({static_cast<py::ssize_t>(size), py::ssize_t{3}});
    std::copy_n(drawn.path_points.col(first).data(), 3 * size, points.mutable_data());
    paths.push_back(std::move(points));
    first += size;
  }
  return paths;
}

// (centres, moves, radii): dents x 3, dents x 3 and dents x 2.
py::tuple dents_of(const EngineState& state) {
  const DrawnTissue drawn = drawn_of(state);
  const auto count = static_cast<py::ssize_t>(drawn.dents.size());
  Array centres({count, py::ssize_t{3}}), moves({count, py::ssize_t{3}}), radii({count, py::ssize_t{2}});
  double *centre = centres.mutable_data(), *move = moves.mutable_data(), *radius = radii.mutable_data();
  for (const Dent& dent : drawn.dents) {
    centre = std::copy_n(dent.centre.data(), 3, centre);
    move = std::copy_n(dent.move.data(), 3, move);
    *radius++ = dent.radii.inner;
    *radius++ = dent.radii.outer;
  }
  return py::make_tuple(centres, moves, radii);
}

// ---- The state after loading ----

State started(const EngineModel& of, const std::map<int, Pose>& places) {
  try {
    return of.start(places);
  } catch (const PlacementError& error) {
    throw py::value_error(error.what());
  }
}

// With bodies, {name: (position, orientation)}, elsewhere than in the scene.
EngineState start(const std::shared_ptr<EngineModel>& of, const py::dict& bodies) {
  std::map<int, Pose> places;
  for (const auto& [key, value] : bodies) {
    const std::string name = py::str(key);
    const int body = of->body(name);
    const Command command = command_from(value, name, body >= of->model().needle_count());
    if (!command.pose || command.spin)
      throw py::value_error("the place of '" + name + "': expected (position, orientation)");
    places[body] = *command.pose;
  }
  State state = started(*of, places);
  if (const auto overlap = find_overlap(of->scene(), of->model().needles, state.needles))
    throw py::value_error(sentence(of->scene(), *overlap) + "; put one of them elsewhere");
  return {of, std::move(state)};
}

// ---- The scene ----

py::list needles_of(const EngineModel& of) {
  const State loaded = make_state(of.model());
  py::list needles;
  for (std::size_t i = 0; i < of.scene().needles.size(); ++i) {
    const Pose base = loaded.bases[i].spun_pose();
    needles.append(py::dict(
        py::arg("name") = of.scene().needles[i].name, py::arg("length") = of.model().needles[i].length,
        py::arg("diameter") = of.model().needles[i].diameter, py::arg("nodes") = of.model().needles[i].nodes(),
        py::arg("base_position") = array_of(base.position), py::arg("base_orientation") = array_of(base.orientation),
        py::arg("cutting_direction") = array_of(of.model().cutting_direction(static_cast<int>(i)))));
  }
  return needles;
}

py::list guides_of(const EngineModel& of) {
  py::list guides;
  for (std::size_t g = 0; g < of.scene().guides.size(); ++g) {
    const Guide& guide = of.scene().guides[g];
    guides.append(py::dict(py::arg("name") = guide.name, py::arg("needle") = guide.needle,
                           py::arg("position") = array_of(guide.pose.position),
                           py::arg("orientation") = array_of(guide.pose.orientation)));
  }
  return guides;
}

std::vector<std::string> regions_of(const EngineModel& of) {
  std::vector<std::string> names;
  if (of.scene().tissue.left_out()) return names;
  for (const Region& region : of.scene().tissue.regions) names.push_back(region.name);
  return names;
}

// ---- The module ----

// Objects come from the functions of this module: `__new__`, which Python would call, would leave them empty.
void forbid_new(py::module_& module) {
  for (const char* name : {"Model", "State", "Report", "NeedleReport", "Event"})
    module.attr(name).attr("__new__") = py::cpp_function([](const py::args&, const py::kwargs&) {
      throw py::type_error("objects of acus_engine come from its functions");
    });
}

// "tick 12 (0.012 s)"
std::string shown_moment(std::uint64_t tick, double time) {
  return "tick " + std::to_string(tick) + " (" + five_digits(time) + " s)";
}

std::string shown_state(const EngineState& state) {
  const Model& model = state.model->model();
  return "<State of '" + protocol::printable(model.scene.name) +
         "': " + shown_moment(state.state.tick, static_cast<double>(state.state.tick) * model.h) + ">";
}

std::string shown_report(const Report& of) {
  const auto& needles = of.model->model().scene.needles;
  std::string text = "<Report of " + shown_moment(of.report.tick, of.report.time);
  for (std::size_t i = 0; i < needles.size(); ++i) {
    const NeedleReport& needle = of.report.needles[i];
    text += "; " + protocol::printable(needles[i].name) + ": " +
            std::string(protocol::kPhaseNames[static_cast<std::size_t>(needle.phase)]) + ", depth " +
            five_digits(1e3 * needle.inserted_depth) + " mm, base force " + five_digits(needle.base_force.norm()) +
            " N";
  }
  return text + "; " + std::to_string(of.report.events.size()) + " events>";
}

void declare_model(py::module_& module) {
  py::class_<EngineModel, std::shared_ptr<EngineModel>>(module, "Model", "A loaded scene; constant.")
      .def_static(
          "read", [](const std::string& path) { return std::make_shared<EngineModel>(read_scene(path)); },
          py::arg("path"), "Of a scene file, with its mesh.")
      .def_static(
          "parse",
          [](const std::string& text, const std::string& folder) {
            return std::make_shared<EngineModel>(parse_scene(text, "scene", folder));
          },
          py::arg("text"), py::arg("folder") = "", "Of YAML; meshes are looked up in the folder.")
      .def("start", start, py::arg("bodies") = py::dict(),
           "The State after loading; {name: (position, orientation)} puts needles and guides elsewhere.")
      .def("state", from_bytes, py::arg("bytes"),
           "The State of a snapshot: of State.bytes(), or of a server with the same scene.")
      .def("adopt", adopted, py::arg("state"),
           "A copy of a State of another scene that differs in numbers alone, to go on in this one.")
      .def_property_readonly("name", [](const EngineModel& of) { return of.scene().name; })
      .def_property_readonly(
          "rate", [](const EngineModel& of) { return of.scene().rate; }, "Hz, ticks a second.")
      .def_property_readonly(
          "time_step", [](const EngineModel& of) { return of.model().h; }, "s")
      .def_property_readonly("needles", needles_of, "As `hello_reply` lists them.")
      .def_property_readonly("guides", guides_of, "Likewise.")
      .def_property_readonly("regions", regions_of, "Names.")
      .def_property_readonly(
          "mesh_notes", [](const EngineModel& of) { return of.model().mesh.notes; },
          "How its mesh file was read: what was split or left out. Empty for a box.")
      .def_property_readonly(
          "tetrahedra",
          [](py::object self) { return rows_of(self.cast<const EngineModel&>().model().mesh.tetrahedra, self); },
          "Nodes of each, n x 4.")
      .def_property_readonly(
          "tetrahedron_regions",
          [](const EngineModel& of) {
            return py::array_t<int>(static_cast<py::ssize_t>(of.model().regions.size()), of.model().regions.data());
          },
          "Number of the region of each.")
      .def_property_readonly(
          "rest_positions",
          [](py::object self) { return rows_of(self.cast<const EngineModel&>().model().mesh.nodes, self); },
          "m, nodes x 3, of the tissue at rest.");
}

void declare_state(py::module_& module) {
  py::class_<EngineState>(module, "State",
                          "All that the next tick depends on, besides the model and commands: a value.")
      .def("__repr__", shown_state)
      .def("copy", [](const EngineState& state) { return EngineState(resting(state)); })
      .def("__copy__", [](const EngineState& state) { return EngineState(resting(state)); })
      .def("__deepcopy__", [](const EngineState& state, const py::dict&) { return EngineState(resting(state)); })
      .def(
          "__eq__",
          [](const EngineState& a, const EngineState& b) {
            return a.model->model().fingerprint == b.model->model().fingerprint &&
                   identical(resting(a).state, resting(b).state);
          },
          py::is_operator())
      .def("step", step, py::arg("commands") = py::dict(), py::arg("ticks") = 1,
           "So many ticks; {name: (position, orientation[, spin])} is taken in by the first. The Report of the last.")
      .def("trace", trace, py::arg("commands") = py::dict(), py::arg("ticks") = 1, "Likewise; the Report of each.")
      .def(
          "record",
          [](EngineState& state, const std::filesystem::path& path) {
            resting(state);
            state.record(path, ACUS_VERSION);
          },
          py::arg("path"),
          "Into a new file, until end_recording() or the end of the state: a recording, as servers make them.")
      .def("end_recording",
           [](EngineState& state) {
             resting(state);
             state.end_recording();
           })
      .def("bytes", bytes_of, "A snapshot; a server with the same scene goes on from it by `restore`.")
      .def_property_readonly(
          "hash", [](const EngineState& state) { return comparable_hash(resting(state).state); },
          "As a server's `hash`.")
      .def_property_readonly("model", [](const EngineState& state) { return state.model; })
      .def_property_readonly(
          "report", [](const EngineState& state) { return report_of(state, resting(state).report); },
          "Of the last tick.")
      .def_property_readonly("tick", [](const EngineState& state) { return state.state.tick; })
      .def_property_readonly(
          "time",
          [](const EngineState& state) { return static_cast<double>(state.state.tick) * state.model->model().h; }, "s")
      .def_property_readonly(
          "tissue_positions",
          [](py::object self) { return rows_of(self.cast<const EngineState&>().state.tissue.x, self); },
          "m, nodes x 3: a view, which steps change.")
      .def(
          "needle_positions",
          [](py::object self, const std::string& needle) {
            const auto& state = self.cast<const EngineState&>();
            return rows_of(state.state.needles[static_cast<std::size_t>(state.model->needle(needle))].x, self);
          },
          py::arg("needle"), "m, nodes x 3, the base first: a view, which steps change.")
      .def("needle_orientations", orientations, py::arg("needle"), "Nodes x 4, world from node.")
      .def_property_readonly("paths", paths_of, "m, points x 3 of each, the mouth first.")
      .def_property_readonly("dents", dents_of,
                             "(centres, moves, radii), m: of each what the mesh is too coarse to show around a needle; "
                             "acus.drawn draws them.");
}

// A vector of the report as a property.
template <Vector3 NeedleReport::*Field>
Array vector_field(const ReportOfNeedle& of) {
  return array_of(of.report().*Field);
}

void declare_reports(py::module_& module) {
  using Needle = ReportOfNeedle;
  py::class_<Report, std::shared_ptr<Report>>(module, "Report", "What a tick tells.")
      .def("__repr__", shown_report)
      .def(
          "__getitem__",
          [](const std::shared_ptr<Report>& of, const std::string& needle) {
            return Needle{of, of->model->needle(needle)};
          },
          "What it tells of a needle, by name.")
      .def_property_readonly("tick", [](const Report& of) { return of.report.tick; })
      .def_property_readonly(
          "time", [](const Report& of) { return of.report.time; }, "s")
      .def_property_readonly("flags", [](const Report& of) { return of.report.flags; })
      .def_property_readonly("rows", [](const Report& of) { return of.report.rows; })
      .def_property_readonly(
          "residual", [](const Report& of) { return of.report.residual; }, "N")
      .def_property_readonly(
          "imbalance", [](const Report& of) { return of.report.imbalance; }, "N")
      .def_property_readonly("events", events_of);
  py::class_<Needle>(module, "NeedleReport", "What a tick tells of a needle, by the names of the topic `force`.")
      .def_property_readonly("tick", [](const Needle& of) { return of.of->report.tick; })
      .def_property_readonly("time", [](const Needle& of) { return of.of->report.time; })
      .def_property_readonly("flags", [](const Needle& of) { return of.of->report.flags; })
      .def_property_readonly(
          "needle",
          [](const Needle& of) { return of.of->model->scene().needles[static_cast<std::size_t>(of.needle)].name; })
      .def_property_readonly("seq", [](const Needle& of) { return of.report().command_seq; })
      .def_property_readonly(
          "phase", [](const Needle& of) { return protocol::kPhaseNames[static_cast<std::size_t>(of.report().phase)]; })
      .def_property_readonly("depth", [](const Needle& of) { return of.report().inserted_depth; })
      .def_property_readonly("unheld", [](const Needle& of) { return of.report().unheld; })
      .def_property_readonly("spin", [](const Needle& of) { return of.report().spin; })
      .def_property_readonly("base_position", [](const Needle& of) { return array_of(of.report().base.position); })
      .def_property_readonly("base_orientation",
                             [](const Needle& of) { return array_of(of.report().base.orientation); })
      .def_property_readonly("commanded_position",
                             [](const Needle& of) { return array_of(of.report().commanded.position); })
      .def_property_readonly(
          "commanded_orientation",
          [](const Needle& of) {
            return array_of(Quaternion(of.report().commanded.orientation * rotation_exp({-of.report().spin, 0, 0})));
          })
      .def_property_readonly(
          "base_force_in_base",
          [](const Needle& of) { return array_of(Vector3(of.world_from_base().conjugate() * of.report().base_force)); })
      .def_property_readonly("base_torque_in_base",
                             [](const Needle& of) {
                               return array_of(Vector3(of.world_from_base().conjugate() * of.report().base_torque));
                             })
      .def_property_readonly("tip_position", vector_field<&NeedleReport::tip_position>)
      .def_property_readonly("tip_force", vector_field<&NeedleReport::tip_force>)
      .def_property_readonly("base_force", vector_field<&NeedleReport::base_force>)
      .def_property_readonly("base_torque", vector_field<&NeedleReport::base_torque>)
      .def_property_readonly("cutting_force", vector_field<&NeedleReport::cutting_force>)
      .def_property_readonly("friction_force", vector_field<&NeedleReport::friction_force>)
      .def_property_readonly("lateral_force", vector_field<&NeedleReport::lateral_force>)
      .def_property_readonly("guide_force", vector_field<&NeedleReport::guide_force>)
      .def_property_readonly("needle_force", vector_field<&NeedleReport::needle_force>);
  py::class_<ReportOfEvent>(module, "Event", "As the topic `event` tells it.")
      .def_property_readonly("tick", [](const ReportOfEvent& of) { return of.event.tick; })
      .def_property_readonly("time", [](const ReportOfEvent& of) { return of.of->report.time; })
      .def_property_readonly(
          "needle",
          [](const ReportOfEvent& of) { return of.scene().needles[static_cast<std::size_t>(of.event.needle)].name; })
      .def_property_readonly(
          "kind",
          [](const ReportOfEvent& of) { return protocol::kEventKindNames[static_cast<std::size_t>(of.event.kind)]; })
      .def_property_readonly("region",
                             [](const ReportOfEvent& of) {
                               return of.scene().tissue.regions[static_cast<std::size_t>(of.event.region)].name;
                             })
      .def_property_readonly("position", [](const ReportOfEvent& of) { return array_of(of.event.position); })
      .def_property_readonly("force", [](const ReportOfEvent& of) { return of.event.force; });
}

}  // namespace
}  // namespace acus::python

PYBIND11_MODULE(acus_engine, module) {
  using namespace acus::python;
  module.doc() = "The simulation of Acus in this process; import acus.engine.";
  module.attr("version") = ACUS_VERSION;
  py::register_exception<acus::SceneError>(module, "SceneError", PyExc_ValueError);
  py::register_exception_translator([](std::exception_ptr thrown) {
    try {
      if (thrown) std::rethrow_exception(thrown);
    } catch (const std::out_of_range& error) {
      PyErr_SetString(PyExc_KeyError, error.what());
    } catch (const acus::RecordingError& error) {
      PyErr_SetString(PyExc_OSError, error.what());
    }
  });
  module.def("use_mesh_program", acus::use_mesh_program, py::arg("path"));
  declare_model(module);
  declare_state(module);
  declare_reports(module);
  forbid_new(module);
}
