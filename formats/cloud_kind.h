#pragma once

#include <string>
#include <string_view>

namespace slim {

enum class CloudKind { ply, text };

/// Says by its first bytes (and, for text formats that have none, by its name) what a cloud is.
///
/// path  for the message and the extension; `.gz` at its end is not looked at
/// head  the first bytes, unpacked; 4 KiB are enough
/// throws FormatError naming the format that was recognised, the formats that are read and, where
///        there is one, the way to convert
CloudKind cloud_kind(const std::string& path, std::string_view head);

/// Whether the first bytes or the name are those of a format that is known, read or not.
bool is_known_format(const std::string& path, std::string_view head);

}  // namespace slim
