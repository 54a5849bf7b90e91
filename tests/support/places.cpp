// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/support/places.h"

namespace acus {

std::string source_path(const std::string& below) { return ACUS_SOURCE_DIR "/" + below; }

std::string program_path(const std::string& name) { return ACUS_BINARY_DIR "/" + name; }

}  // namespace acus
