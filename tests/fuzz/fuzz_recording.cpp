// SPDX-License-Identifier: GPL-3.0-or-later
// Recordings of a small scene: after a beginning that is right, anything.
#include <unistd.h>
#include <zstd.h>

#include <fstream>

#include "server/engine/recording/rerun.h"
#include "server/engine/state/bytes/snapshot.h"
#include "tests/fuzz/fuzz.h"
#include "tests/support/small_block.h"

namespace {

constexpr int kMaxTicks = 20;

std::string beginning() {
  const acus::Simulation simulation(acus::test::small_block());
  const std::uint64_t fingerprint = simulation.model().fingerprint;
  std::string bytes;
  acus::append(bytes, acus::recorded::Opening{1, "0.1", ""});
  acus::append(bytes, acus::record_of(simulation.scene(), simulation.mesh(), fingerprint));
  acus::append(bytes, acus::recorded::Beginning{0, make_snapshot(fingerprint, simulation.state())});
  return bytes;
}

// All items of any bytes, and whether a scene is among them, which takes its time.
bool has_scene(std::string_view bytes) {
  bool found = false;
  try {
    while (!bytes.empty()) found |= std::holds_alternative<acus::recorded::World>(acus::take_item(bytes));
  } catch (const acus::RecordingError&) {
  }
  return found;
}

void write_frame(const std::string& path, const std::string& items) {
  std::string packed(ZSTD_compressBound(items.size()), '\0');
  packed.resize(ZSTD_compress(packed.data(), packed.size(), items.data(), items.size(), 1));
  std::ofstream(path, std::ios::binary) << packed;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const std::string path = "/tmp/acus-fuzz-" + std::to_string(getpid()) + ".acus";
  static const std::string begin = beginning();
  const std::string_view input = acus::fuzz::text_of(data, size);
  if (has_scene(input)) return 0;
  unlink(path.c_str());
  write_frame(path, begin + std::string(input));
  try {
    acus::Rerun rerun(path);
    for (int i = 0; i < kMaxTicks && rerun.step(); ++i) {
    }
  } catch (const acus::RecordingError&) {
  }
  unlink(path.c_str());
  return 0;
}
