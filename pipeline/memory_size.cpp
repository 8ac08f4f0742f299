#include "pipeline/memory_size.h"

#include "pipeline/plain_number.h"
#include "slim/base/error.h"

#include <fmt/format.h>

#include <cctype>
#include <charconv>
#include <cmath>

namespace slim {
namespace {

/// Power of 1024 of a unit such as "", "B", "k", "MiB", "GB"; -1 if it is none.
int unit_power(std::string_view unit) {
    if (unit.empty()) return 0;
    const std::string_view letters = "BKMGT";
    const auto letter = static_cast<char>(std::toupper(static_cast<unsigned char>(unit[0])));
    const std::size_t power = letters.find(letter);
    if (power == std::string_view::npos) return -1;
    const std::string_view rest = unit.substr(1);
    const bool plain = rest.empty();
    const bool named = rest == "B" || rest == "b" || rest == "iB" || rest == "ib";
    return plain || (power > 0 && named) ? static_cast<int>(power) : -1;
}

}  // namespace

std::uint64_t parse_memory_size(std::string_view text) {
    const ConfigError no_size({.key = "memory",
                               .expected =
                                   "a number with an optional unit, such as 1GiB or 800M",
                               .found = fmt::format("'{}'", text)});
    double value = 0;
    const auto number = std::from_chars(text.data(), text.data() + text.size(), value);
    if (number.ec != std::errc()) throw no_size;
    std::string_view unit = text.substr(static_cast<std::size_t>(number.ptr - text.data()));
    while (!unit.empty() && unit.front() == ' ') unit.remove_prefix(1);
    const int power = unit_power(unit);
    const double bytes = std::ldexp(value, 10 * power);
    if (power < 0 || std::isnan(bytes)) throw no_size;
    if (!(bytes >= 1) || bytes > 0x1p62)
        throw ConfigError({.key = "memory",
                           .expected = "at least one byte and at most 4 EiB",
                           .found = fmt::format("'{}'", text)});
    return static_cast<std::uint64_t>(bytes);
}

std::string memory_size_text(std::uint64_t bytes) {
    const char* units[] = {"B", "KiB", "MiB", "GiB", "TiB"};
    auto value = static_cast<double>(bytes);
    std::size_t unit = 0;
    for (; value >= 1024 && unit < 4; ++unit) value /= 1024;
    return unit == 0 ? fmt::format("{} B", bytes)
                     : fmt::format("{} {}", plain_number(value, 3), units[unit]);
}

}  // namespace slim
