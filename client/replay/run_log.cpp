// SPDX-License-Identifier: MIT
#include "client/replay/run_log.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <filesystem>
#include <string_view>
#include <type_traits>
#include <utility>

namespace acus::client {
namespace {

using namespace std::string_view_literals;

// What ends the column names of a field; fields that are not listed have no unit.
constexpr std::array kUnits{
    std::pair{"time"sv, "_s"sv},
    std::pair{"age"sv, "_s"sv},
    std::pair{"echo"sv, "_s"sv},
    std::pair{"depth"sv, "_m"sv},
    std::pair{"unheld"sv, "_m"sv},
    std::pair{"base_position"sv, "_m"sv},
    std::pair{"commanded_position"sv, "_m"sv},
    std::pair{"tip_position"sv, "_m"sv},
    std::pair{"position"sv, "_m"sv},
    std::pair{"spin"sv, "_rad"sv},
    std::pair{"tip_force"sv, "_N"sv},
    std::pair{"base_force"sv, "_N"sv},
    std::pair{"base_torque"sv, "_Nm"sv},
    std::pair{"base_force_in_base"sv, "_N"sv},
    std::pair{"base_torque_in_base"sv, "_Nm"sv},
    std::pair{"haptic_force"sv, "_N"sv},
    std::pair{"haptic_torque"sv, "_Nm"sv},
    std::pair{"cutting_force"sv, "_N"sv},
    std::pair{"friction_force"sv, "_N"sv},
    std::pair{"lateral_force"sv, "_N"sv},
    std::pair{"guide_force"sv, "_N"sv},
    std::pair{"needle_force"sv, "_N"sv},
    std::pair{"force"sv, "_N"sv},
};

std::string_view unit_of(std::string_view field) {
  const auto* entry = std::find_if(kUnits.begin(), kUnits.end(), [&](const auto& unit) { return unit.first == field; });
  return entry == kUnits.end() ? std::string_view{} : entry->second;
}

void append_cell(std::string& row, std::string_view text) {
  if (!row.empty()) row += ',';
  row += text;
}

// Quotes what would break a row apart.
void append_text(std::string& row, std::string_view text) {
  if (text.find_first_of(",\"\n\r") == std::string_view::npos) return append_cell(row, text);
  std::string quoted(1, '"');
  for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  append_cell(row, quoted + '"');
}

template <class Number>
void append_number(std::string& row, Number number) {
  std::array<char, 32> buffer{};
  const auto* end = std::to_chars(buffer.data(), buffer.data() + buffer.size(), number).ptr;
  append_cell(row, {buffer.data(), static_cast<std::size_t>(end - buffer.data())});
}

// Visits the fields of a message and appends the names of their columns.
struct AppendNames {
  std::string& row;

  template <class T>
  void operator()(const char* name, const T&) {
    const std::string field = name;
    const auto components = components_of<T>();
    if (components.empty()) append_cell(row, field + std::string(unit_of(field)));
    for (const char component : components) append_cell(row, field + '_' + component + std::string(unit_of(field)));
  }

  template <class T>
  static constexpr std::string_view components_of() {
    if constexpr (std::is_same_v<T, protocol::Vector3>) return "xyz";
    if constexpr (std::is_same_v<T, protocol::Quaternion>) return "wxyz";
    return {};
  }
};

// Visits the fields of a message and appends their values.
struct AppendValues {
  std::string& row;

  void operator()(const char*, const std::string& value) { append_text(row, value); }
  void operator()(const char*, const protocol::Vector3& value) {
    for (const double component : value) append_number(row, component);
  }
  void operator()(const char*, const protocol::Quaternion& value) {
    for (const double component : {value.w, value.x, value.y, value.z}) append_number(row, component);
  }
  template <class T>
  void operator()(const char*, const T& value) {
    if constexpr (std::is_enum_v<T>) {
      append_cell(row, protocol::name_of(value));
    } else if constexpr (std::is_same_v<T, bool>) {
      append_cell(row, value ? "1" : "0");
    } else {
      append_number(row, value);
    }
  }
};

template <class Message>
std::string header_of() {
  std::string row;
  const Message message;
  Message::fields(message, AppendNames{row});
  return row;
}

// Own files of forces have wall time or not.
LogFile forces_file(const std::string& path, bool wall_time) {
  const std::string columns = header_of<protocol::Force>();
  return {path, protocol::beginning_with(columns), columns + (wall_time ? ",received_s" : "") + '\n'};
}

}  // namespace

RunLog::RunLog(const std::string& path, bool wall_time)
    : wall_time_(wall_time),
      forces_(forces_file(path, wall_time)),
      events_(events_path_beside(path), header_of<protocol::Event>() + '\n') {}

std::string RunLog::events_path_beside(const std::string& path) {
  return std::filesystem::path(path).replace_extension(".events.csv").string();
}

void RunLog::write(const protocol::Force& force, double received_s) {
  row_.clear();
  protocol::Force::fields(force, AppendValues{row_});
  if (wall_time_) append_number(row_, received_s);
  row_ += '\n';
  forces_.out() << row_;
  events_.out();  // a run without events has a file of events, too
}

void RunLog::write(const protocol::Event& event) {
  row_.clear();
  protocol::Event::fields(event, AppendValues{row_});
  row_ += '\n';
  forces_.out();  // likewise
  events_.out() << row_;
}

void RunLog::close() {
  forces_.close();
  events_.close();
}

}  // namespace acus::client
