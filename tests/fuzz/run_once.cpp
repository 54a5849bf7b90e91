// SPDX-License-Identifier: GPL-3.0-or-later
// Gives a target its samples, and every file of a folder, once. Usage: run_TARGET TARGET FOLDER [SAMPLES]. With SAMPLES,
// a folder, the samples are written there instead.
#include <filesystem>
#include <fstream>

#include "tests/fuzz/fuzz.h"
#include "tests/fuzz/samples.h"
#include "tests/support/file_content.h"

namespace {

void give(const std::string& input) {
  LLVMFuzzerTestOneInput(reinterpret_cast<const std::uint8_t*>(input.data()), input.size());
}

void write(const std::vector<std::string>& samples, const std::filesystem::path& folder) {
  for (std::size_t i = 0; i < samples.size(); ++i)
    std::ofstream(folder / ("sample_" + std::to_string(i)), std::ios::binary) << samples[i];
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 3) return 1;
  const std::vector<std::string> samples = acus::fuzz::samples(argv[1]);
  if (argc > 3) {
    write(samples, argv[3]);
    return 0;
  }
  for (const std::string& sample : samples) give(sample);
  give("");
  if (!std::filesystem::is_directory(argv[2])) return 0;
  for (const auto& entry : std::filesystem::directory_iterator(argv[2])) {
    std::printf("%s\n", entry.path().c_str());
    give(acus::content_of(entry.path()));
  }
  return 0;
}
