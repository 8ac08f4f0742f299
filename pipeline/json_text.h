#pragma once

#include <nlohmann/json_fwd.hpp>

#include <iosfwd>
#include <string>

namespace slim {

/// JSON from and to text, compiled once: the parser and the writer take seconds of every file that
/// instantiates them.

/// throws  nlohmann::json::parse_error with the byte, for text that is not JSON
nlohmann::json json_from(std::istream& in);

/// A whole file. IoError if it cannot be read; FormatError with the line and byte, and what stands
/// there, for text that is not JSON.
nlohmann::json read_json(const std::string& path);

/// The same, but `discarded` (is_discarded(), of no type) for text that is not JSON.
nlohmann::json json_or_discarded(std::istream& in);
nlohmann::json json_or_discarded(const std::string& text);

/// indent   spaces per level; -1: all on one line. Bytes that are not UTF-8 become U+FFFD.
std::string text_of(const nlohmann::json& value, int indent = -1);

}  // namespace slim
