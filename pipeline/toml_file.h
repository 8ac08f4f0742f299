#pragma once

#include "pipeline/config.h"

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

namespace slim {

/// The lines of values that no line of a file says, for messages.
inline constexpr int kBySet = 0, kOnCommandLine = -1;

/// A place in a file: "job.toml:12", "job.toml, --set", "job.toml, command line".
std::string toml_place(const std::filesystem::path& file, int line);

/// The same as the place of a fault.
Fault toml_fault(const std::filesystem::path& file, int line, const std::string& key = {});

/// A TOML value of the kinds our files use, numbers as exact text.
struct TomlValue {
    std::string key;
    Field::Kind kind = Field::Kind::text;
    bool is_list = false;
    std::vector<std::string> items;
    int line = 0;
};

/// A TOML table: its values, its [tables] and its [[arrays of tables]] (one entry per table).
struct TomlTable {
    std::string name;
    int line = 0;
    std::vector<TomlValue> values;
    std::vector<TomlTable> tables;
};

/// The whole file as plain values. ConfigError naming file and line (not TOML, or a date, a nested
/// or mixed array); IoError if it cannot be read.
TomlTable read_toml(const std::filesystem::path& file);

/// Sets "table.key" (or "table.table.key") of a file that was read to a value as TOML would write
/// it, text without quotes allowed (render.size=640x480); tables that are missing are made.
/// ConfigError if there is no such form, the table is a [[list]], or the value begins as an array
/// and is none.
void set_value(TomlTable& root, const std::string& key_equals_value);

/// A value's items for a field. A list may be written as a command line has it, "a,b" for
/// ["a", "b"], and a single item alone. `folder`: where relative paths are from.
std::vector<std::string> items_for(const Field& field, const TomlValue& value,
                                   const std::filesystem::path& folder);

/// Items of a list in one text, a,b; a file whose name has a comma is that file.
std::vector<std::string> list_items(const Field& field, const std::string& text,
                                    const std::filesystem::path& folder = {});

/// Sets the fields that a table names; relative paths are taken from the file's folder. ConfigError
/// with file:line for an unknown key (and the nearest one), a wrong type or a value out of range.
void apply_table(const TomlTable& table, const FieldList& fields,
                 const std::filesystem::path& file);

/// apply_table of a file that holds nothing but a stage's keys; returns those that it says.
std::vector<std::string> apply_config_file(const std::filesystem::path& file,
                                           const FieldList& fields);

}  // namespace slim
