// SPDX-License-Identifier: GPL-3.0-or-later
// What a recording's file gives back, whole, cut, and damaged.
#include "server/engine/recording/recording_file.h"

#include <doctest/doctest.h>
#include <sys/resource.h>

#include <bit>
#include <csignal>

#include "tests/support/file_content.h"
#include "tests/support/temporary_folder.h"

namespace acus {
namespace {

recorded::BodyCommand given() {
  Command command{.seq = 7, .pose = Pose{{-0.0, 2, 1e-300}, Quaternion(1, 0, 0, 0)}, .spin = {}};
  return {3, command};
}

// Three frames: the opening, ticks 1 and 2, tick 3 and the end.
std::string write_small(const TemporaryFolder& folder, const std::string& name) {
  RecordingWriter writer(folder / name);
  writer.add(recorded::Opening{1, "0.1", "2026-01-01T00:00:00Z"});
  writer.flush();
  writer.add(given());
  writer.add(recorded::Tick{1, ~std::uint64_t{0}, true});
  writer.add(recorded::Tick{2, 5, false});
  writer.flush();
  writer.add(recorded::Tick{3, 6, false});
  writer.add(recorded::Ending{""});
  writer.flush();
  return writer.path();
}

struct Read {
  int ticks = 0;
  std::string problem;
  bool damaged = false;
};

Read read_all(const std::string& path) {
  RecordingReader reader(path);
  Read read;
  while (const auto item = reader.next()) read.ticks += std::holds_alternative<recorded::Tick>(*item);
  read.problem = reader.problem();
  read.damaged = reader.damaged();
  return read;
}

std::string error_of(const std::string& path) {
  try {
    read_all(path);
    return "";
  } catch (const RecordingError& error) {
    return error.what();
  }
}

template <class It>
It there_and_back(const It& item) {
  std::string bytes;
  append(bytes, item);
  std::string_view left = bytes;
  const recorded::Item back = take_item(left);
  CHECK(left.empty());
  return std::get<It>(back);
}

// While it stands, no file of this process grows beyond so many bytes.
class FileSizeLimit {
 public:
  explicit FileSizeLimit(rlim_t bytes) {
    std::signal(SIGXFSZ, SIG_IGN);
    getrlimit(RLIMIT_FSIZE, &before_);
    rlimit limit = before_;
    limit.rlim_cur = bytes;
    setrlimit(RLIMIT_FSIZE, &limit);
  }
  ~FileSizeLimit() { setrlimit(RLIMIT_FSIZE, &before_); }

 private:
  rlimit before_{};
};

}  // namespace

TEST_CASE("what is recorded comes back to the last bit") {
  const recorded::BodyCommand given = there_and_back(acus::given());
  CHECK(given.body == 3);
  CHECK(given.command.seq == 7);
  REQUIRE(given.command.pose);
  CHECK(std::signbit(given.command.pose->position.x()));
  CHECK(given.command.pose->position.y() == 2);
  CHECK(given.command.pose->position.z() == 1e-300);
  CHECK(given.command.pose->orientation.w() == 1);
  CHECK(!given.command.spin);

  const auto tick = there_and_back(recorded::Tick{std::uint64_t{1} << 40, ~std::uint64_t{0}, true});
  CHECK(tick.tick == std::uint64_t{1} << 40);
  CHECK(tick.digest == ~std::uint64_t{0});
  CHECK(tick.economizing);

  recorded::World world{"a.yaml", "acus_scene: 1", 500, 12, {}};
  CHECK(!there_and_back(world).own_mesh);
  world.own_mesh = make_box_mesh({1, 1, 1}, {1, 2, 3});
  world.own_mesh->groups = {{"", 2, "liver", {0, 3, 5}}, {"label", -7, "", {1}}, {"", std::nullopt, "vessel", {2, 3}}};
  const recorded::World back = there_and_back(world);
  CHECK(back.file == "a.yaml");
  CHECK(back.rate == 500);
  REQUIRE(back.own_mesh);
  CHECK(back.own_mesh->nodes == world.own_mesh->nodes);
  CHECK(back.own_mesh->tetrahedra == world.own_mesh->tetrahedra);
  CHECK(back.own_mesh->groups == world.own_mesh->groups);
}

TEST_CASE("a recording is read to its end, and there is none of the same name before") {
  const TemporaryFolder folder;
  const std::string path = write_small(folder, "run");
  const Read read = read_all(path);
  CHECK(read.ticks == 3);
  CHECK(read.problem.empty());
  CHECK(!read.damaged);
  CHECK(RecordingReader(path).opening().server == "0.1");
  CHECK_THROWS_WITH_AS(RecordingWriter{path},
                       (path + ": there is a file of this name already; give the recording another one").c_str(),
                       RecordingError);
  CHECK(read_all(path).ticks == 3);
}

TEST_CASE("a recording that was cut anywhere gives what stood whole before") {
  const TemporaryFolder folder;
  const std::string whole = content_of(write_small(folder, "run"));
  int most = 0;
  for (std::size_t size = 0; size < whole.size(); ++size) {
    const std::string path = folder.write("cut", whole.substr(0, size));
    if (!error_of(path).empty()) {
      CHECK(most == 0);  // the opening itself is not whole
      continue;
    }
    const Read read = read_all(path);
    CHECK(read.ticks >= most);
    CHECK(!read.problem.empty());
    most = read.ticks;
  }
  CHECK(most == 2);
}

// Some bits of a frame's header mean nothing.
TEST_CASE("a recording with a byte changed gives what stands before it, or an error, and nothing else") {
  const TemporaryFolder folder;
  const std::string whole = content_of(write_small(folder, "run"));
  for (std::size_t at = 0; at < whole.size(); ++at) {
    std::string damaged = whole;
    damaged[at] = static_cast<char>(damaged[at] ^ 0x10);
    const std::string path = folder.write("damaged", damaged);
    if (!error_of(path).empty()) continue;
    const Read read = read_all(path);
    CHECK((read.ticks == 0 || read.ticks == 2 || read.ticks == 3));
    CHECK((read.ticks == 3) == read.problem.empty());
    CHECK((read.ticks == 3) != read.damaged);
  }
}

TEST_CASE("what stands behind the end of a recording is told of") {
  const TemporaryFolder folder;
  const std::string whole = content_of(write_small(folder, "run"));
  for (const std::string& more : {std::string("x"), std::string(100, '\0'), whole}) {
    const Read read = read_all(folder.write("more", whole + more));
    CHECK(read.ticks == 3);
    CHECK(read.damaged);
    CHECK(read.problem.starts_with("something stands behind its end"));
  }
}

TEST_CASE("what is no recording is refused with its name") {
  const TemporaryFolder folder;
  CHECK(error_of(folder.write("text", "t,needle,x\n")).starts_with(folder / "text: "));
  CHECK(error_of(folder.write("empty", "")).starts_with(folder / "empty: "));
  CHECK(error_of(folder / "none").find("cannot be read") != std::string::npos);
  CHECK(error_of(folder.path()).starts_with(folder.path()));
  RecordingWriter(folder / "only").add(recorded::Tick{});
  CHECK(!error_of(folder / "only").empty());
}

TEST_CASE("msgpack that is no item is refused") {
  for (const char* bytes : {"\x01", "\x90", "\x91\x01", "\x91\xa4tick", "\x91\xa4what", "\xdd\xff\xff\xff\xff", "\xc1",
                            "\x94\xa4tick\x01\x02\x03", "\x95\xa7""command\xff\x01\xc0\xc0"}) {
    std::string_view left = bytes;
    CHECK_THROWS_AS(take_item(left), RecordingError);
  }
}

TEST_CASE("a disk that is full ends a recording behind its last whole frame") {
  const TemporaryFolder folder;
  RecordingWriter writer(folder / "run");
  writer.add(recorded::Opening{1, "0.1", ""});
  writer.add(recorded::Tick{1, 5, false});
  writer.flush();
  const std::uint64_t before = writer.bytes();
  {
    const FileSizeLimit limit(before + 20);
    for (std::uint64_t i = 0; i < 1000; ++i) writer.add(recorded::Tick{i, i * 0x9e3779b97f4a7c15, false});
    CHECK_THROWS_AS(writer.flush(), RecordingError);
  }
  CHECK(writer.bytes() == before);
  CHECK(std::filesystem::file_size(folder / "run") == before);
  CHECK(read_all(folder / "run").ticks == 1);
}

TEST_CASE("a recording whose file is removed ends with an error, one that is renamed goes on") {
  const TemporaryFolder folder;
  RecordingWriter writer(folder / "run");
  writer.add(recorded::Opening{1, "0.1", ""});
  writer.flush();
  std::filesystem::rename(folder / "run", folder / "other");
  writer.add(recorded::Tick{1, 5, false});
  writer.flush();
  CHECK(read_all(folder / "other").ticks == 1);
  std::filesystem::remove(folder / "other");
  writer.add(recorded::Tick{2, 5, false});
  CHECK_THROWS_WITH_AS(writer.flush(), "the recording's file has been removed", RecordingError);
}

}  // namespace acus
