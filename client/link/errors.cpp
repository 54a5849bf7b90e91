// SPDX-License-Identifier: MIT
#include "client/link/errors.h"

#include <string>

namespace acus::client {

namespace {

std::string told(const protocol::Error& error) {
  const std::string subject = error.rejected.value_or("message");
  return "the server refused '" + subject + "' (" + protocol::name_of(error.code) + "): " + error.message;
}

}  // namespace

Refused::Refused(const protocol::Error& rejection) : ClientError(told(rejection)), error(rejection) {}

}  // namespace acus::client
