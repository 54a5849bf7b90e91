// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/recording/recording.h"

#include <array>
#include <ctime>
#include <limits>
#include <msgpack.hpp>

#include "protocol/packer.h"
#include "server/engine/state/bytes/report_hash.h"

namespace acus {

namespace {

using recorded::Item;

// ---- Writing ----

using protocol::Packer;

void pack(Packer& packer, std::uint64_t number) { packer.pack(number); }
void pack(Packer& packer, double number) { packer.pack_number(number); }
void pack(Packer& packer, bool value) { packer.pack(value); }
void pack(Packer& packer, const std::string& text) { packer.pack(text); }

void pack_bytes(Packer& packer, const void* data, std::size_t size) {
  packer.pack_bin(static_cast<std::uint32_t>(size));
  packer.pack_bin_body(static_cast<const char*>(data), static_cast<std::uint32_t>(size));
}

void pack(Packer& packer, const std::vector<std::byte>& bytes) { pack_bytes(packer, bytes.data(), bytes.size()); }

void pack(Packer& packer, const Pose& pose) {
  packer.pack_array(7);
  for (const double x : pose.position) packer.pack_number(x);
  const Quaternion& q = pose.orientation;
  for (const double x : {q.w(), q.x(), q.y(), q.z()}) packer.pack_number(x);
}

void pack(Packer& packer, const TetrahedralMesh& mesh) {
  packer.pack_array(3);
  pack_bytes(packer, mesh.nodes.data(), static_cast<std::size_t>(mesh.nodes.size()) * sizeof(double));
  pack_bytes(packer, mesh.tetrahedra.data(), mesh.tetrahedra.size() * sizeof mesh.tetrahedra[0]);
  packer.pack_array(static_cast<std::uint32_t>(mesh.groups.size()));
  for (const MeshGroup& group : mesh.groups) {
    packer.pack_array(4);
    packer.pack(group.array);
    packer.pack(group.name);
    group.number ? packer.pack(*group.number) : packer.pack_nil();
    pack_bytes(packer, group.members.data(), group.members.size() * sizeof group.members[0]);
  }
}

template <class T>
void pack(Packer& packer, const std::optional<T>& value) {
  if (!value) {
    packer.pack_nil();
  } else {
    pack(packer, *value);
  }
}

template <class... Values>
void pack_item(std::string& bytes, const char* name, const Values&... values) {
  protocol::StringSink sink{bytes};
  Packer packer(sink);
  packer.pack_array(1 + sizeof...(values));
  packer.pack(name);
  (pack(packer, values), ...);
}

struct Append {
  std::string& bytes;

  void operator()(const recorded::Opening& it) const { pack_item(bytes, "recording", it.version, it.server, it.started); }
  void operator()(const recorded::World& it) const {
    pack_item(bytes, "scene", it.file, it.text, it.rate, it.fingerprint, it.own_mesh);
  }
  void operator()(const recorded::Beginning& it) const { pack_item(bytes, "begin", it.epoch, it.snapshot); }
  void operator()(const recorded::BodyCommand& it) const {
    const Command& command = it.command;
    pack_item(bytes, "command", static_cast<std::uint64_t>(it.body), command.seq, command.pose, command.spin);
  }
  void operator()(const recorded::Tick& it) const { pack_item(bytes, "tick", it.tick, it.digest, it.economizing); }
  void operator()(const recorded::StateAfter& it) const { pack_item(bytes, "state", it.tick, it.hash); }
  void operator()(const recorded::Ending& it) const { pack_item(bytes, "end", it.why); }
};

// ---- Reading ----

using Object = msgpack::object;

[[noreturn]] void unexpected(const char* expected) {
  throw RecordingError(std::string("the recording is damaged or no recording of Acus: expected ") + expected);
}

void unpack(const Object& object, std::uint64_t& number) {
  if (object.type != msgpack::type::POSITIVE_INTEGER) unexpected("a whole number");
  number = object.via.u64;
}

void unpack(const Object& object, int& number) {
  std::uint64_t wide = 0;
  unpack(object, wide);
  if (wide > static_cast<std::uint64_t>(std::numeric_limits<int>::max())) unexpected("a small number");
  number = static_cast<int>(wide);
}

void unpack(const Object& object, double& number) {
  if (object.type != msgpack::type::FLOAT64) unexpected("a number");
  number = object.via.f64;
}

void unpack(const Object& object, bool& value) {
  if (object.type != msgpack::type::BOOLEAN) unexpected("true or false");
  value = object.via.boolean;
}

void unpack(const Object& object, std::string& text) {
  if (object.type != msgpack::type::STR) unexpected("a text");
  text.assign(object.via.str.ptr, object.via.str.size);
}

std::span<const char> bytes_of(const Object& object, std::size_t unit) {
  if (object.type != msgpack::type::BIN || object.via.bin.size % unit != 0) unexpected("whole numbers of bytes");
  return {object.via.bin.ptr, object.via.bin.size};
}

void unpack(const Object& object, std::vector<std::byte>& bytes) {
  const auto packed = std::as_bytes(bytes_of(object, 1));
  bytes.assign(packed.begin(), packed.end());
}

template <class Element>
void unpack_elements(const Object& object, std::vector<Element>& elements) {
  const std::span<const char> packed = bytes_of(object, sizeof(Element));
  elements.resize(packed.size() / sizeof(Element));
  std::copy(packed.begin(), packed.end(), reinterpret_cast<char*>(elements.data()));
}

std::span<const Object> array_of(const Object& object, std::size_t size) {
  if (object.type != msgpack::type::ARRAY || object.via.array.size != size) unexpected("another number of elements");
  return {object.via.array.ptr, size};
}

void unpack(const Object& object, Pose& pose) {
  std::array<double, 7> numbers{};
  const auto packed = array_of(object, numbers.size());
  for (std::size_t i = 0; i < numbers.size(); ++i) unpack(packed[i], numbers[i]);
  const auto& [x, y, z, qw, qx, qy, qz] = numbers;
  pose = {{x, y, z}, Quaternion(qw, qx, qy, qz)};
}

void unpack(const Object& object, MeshGroup& group) {
  const auto packed = array_of(object, 4);
  unpack(packed[0], group.array);
  unpack(packed[1], group.name);
  if (packed[2].type == msgpack::type::POSITIVE_INTEGER || packed[2].type == msgpack::type::NEGATIVE_INTEGER)
    group.number = packed[2].via.i64;
  else if (!packed[2].is_nil())
    unexpected("the number of a group");
  unpack_elements(packed[3], group.members);
}

void unpack(const Object& object, TetrahedralMesh& mesh) {
  if (object.type == msgpack::type::ARRAY && object.via.array.size == 4)
    throw RecordingError("the recording's mesh has the form of an older version of Acus; record the run again");
  const auto packed = array_of(object, 3);
  std::vector<std::array<double, 3>> nodes;
  unpack_elements(packed[0], nodes);
  mesh.nodes.resize(3, static_cast<Eigen::Index>(nodes.size()));
  for (std::size_t i = 0; i < nodes.size(); ++i) mesh.nodes.col(static_cast<Eigen::Index>(i)) = Vector3(nodes[i].data());
  unpack_elements(packed[1], mesh.tetrahedra);
  if (packed[2].type != msgpack::type::ARRAY) unexpected("groups of tetrahedra");
  for (const Object& group : std::span(packed[2].via.array.ptr, packed[2].via.array.size)) {
    unpack(group, mesh.groups.emplace_back());
    for (const int member : mesh.groups.back().members)
      if (member < 0 || member >= mesh.tetrahedron_count()) unexpected("groups of the mesh's tetrahedra");
  }
}

template <class T>
void unpack(const Object& object, std::optional<T>& value) {
  if (!object.is_nil()) unpack(object, value.emplace());
}

template <class It, class... Members>
Item unpack_item(std::span<const Object> elements, Members It::*... members) {
  if (elements.size() != 1 + sizeof...(members)) unexpected("another number of elements");
  It it;
  std::size_t next = 1;
  (unpack(elements[next++], it.*members), ...);
  return it;
}

Item unpack_body_command(std::span<const Object> elements) {
  if (elements.size() != 5) unexpected("another number of elements");
  recorded::BodyCommand given;
  unpack(elements[1], given.body);
  unpack(elements[2], given.command.seq);
  unpack(elements[3], given.command.pose);
  unpack(elements[4], given.command.spin);
  return given;
}

Item unpack_item(const Object& object) {
  using namespace recorded;
  if (object.type != msgpack::type::ARRAY || object.via.array.size == 0) unexpected("a list");
  const std::span<const Object> elements(object.via.array.ptr, object.via.array.size);
  std::string name;
  unpack(elements[0], name);
  if (name == "tick") return unpack_item(elements, &Tick::tick, &Tick::digest, &Tick::economizing);
  if (name == "command") return unpack_body_command(elements);
  if (name == "state") return unpack_item(elements, &StateAfter::tick, &StateAfter::hash);
  if (name == "begin") return unpack_item(elements, &Beginning::epoch, &Beginning::snapshot);
  if (name == "scene")
    return unpack_item(elements, &World::file, &World::text, &World::rate, &World::fingerprint, &World::own_mesh);
  if (name == "end") return unpack_item(elements, &Ending::why);
  if (name == "recording") return unpack_item(elements, &Opening::version, &Opening::server, &Opening::started);
  throw RecordingError("the recording holds '" + name.substr(0, 40) + "', which this version of Acus does not know");
}

// Enough for a scene's mesh and a state; what claims more is damaged.
const msgpack::unpack_limit kLimits(1 << 16, 1 << 4, std::size_t{1} << 28, std::size_t{1} << 28, 0, 4);

}  // namespace

recorded::Opening opening_now(const std::string& server) {
  const std::time_t now = std::time(nullptr);
  std::tm parts{};
  gmtime_r(&now, &parts);
  char started[sizeof "2026-01-01T00:00:00Z"];
  std::strftime(started, sizeof started, "%Y-%m-%dT%H:%M:%SZ", &parts);
  return {.version = recorded::Opening().version, .server = server, .started = started};
}

recorded::World record_of(const Scene& scene, const TetrahedralMesh& own_mesh, std::uint64_t fingerprint) {
  recorded::World world{scene.file, scene.text, scene.rate, fingerprint, {}};
  if (!scene.tissue.gmsh || scene.tissue.left_out()) return world;
  world.own_mesh.emplace();
  world.own_mesh->nodes = own_mesh.nodes;
  world.own_mesh->tetrahedra = own_mesh.tetrahedra;
  world.own_mesh->groups = own_mesh.groups;
  return world;
}

RecordedScene scene_of(const recorded::World& world) {
  Scene scene = parse_scene(world.text, world.file);
  scene.rate = world.rate;
  std::optional<TetrahedralMesh> mesh = world.own_mesh;
  if (scene.tissue.gmsh && !scene.tissue.left_out() && !mesh)
    throw RecordingError("the recording lacks the mesh of its scene");
  if (mesh) try {
      build_topology(*mesh);
    } catch (const MeshError& error) {
      throw RecordingError(std::string("the mesh in the recording cannot be used: ") + error.what());
    }
  return {std::move(scene), std::move(mesh)};
}

std::unique_ptr<Simulation> simulation_of(const recorded::World& world, const Progress& progress) {
  RecordedScene recorded = scene_of(world);
  auto simulation = std::make_unique<Simulation>(recorded.scene, progress, std::move(recorded.own_mesh));
  if (simulation->model().fingerprint != world.fingerprint)
    throw RecordingError("the scene in the recording means something else to this version of Acus than to that which recorded it");
  return simulation;
}

void append(std::string& bytes, const Item& item) { std::visit(Append{bytes}, item); }

Item take_item(std::string_view& bytes) {
  std::size_t taken = 0;
  try {
    const msgpack::object_handle handle = msgpack::unpack(bytes.data(), bytes.size(), taken, nullptr, nullptr, kLimits);
    bytes.remove_prefix(taken);
    return unpack_item(handle.get());
  } catch (const msgpack::unpack_error& error) {
    throw RecordingError(std::string("the recording is damaged or no recording of Acus: ") + error.what());
  }
}

std::uint64_t digest(Hasher& hasher, const TickReport& report) {
  hasher.restart();
  add_report(hasher, report);
  return hasher.digest();
}

}  // namespace acus
