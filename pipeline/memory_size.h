#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace slim {

/// Bytes from "1GiB", "512 MiB", "2g", "800M", "1048576": k, M, G, T are powers of 1024, with or
/// without "B" or "iB", any case; fractions allowed ("1.5G"). ConfigError naming the text
/// otherwise.
std::uint64_t parse_memory_size(std::string_view text);

/// "1.5 GiB", "812 KiB", "17 B": for people.
std::string memory_size_text(std::uint64_t bytes);

}  // namespace slim
