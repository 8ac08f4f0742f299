#pragma once

#include <charconv>
#include <cstdlib>
#include <limits>
#include <string>
#include <string_view>
#include <system_error>

namespace slim {

inline bool is_blank(char c) {
    return c == ' ' || c == '\t' || c == '\r' || c == '\v' || c == '\f';
}

/// Takes the next word off the front of `line`; empty at its end.
inline std::string_view next_word(std::string_view& line) {
    std::size_t from = 0;
    while (from < line.size() && is_blank(line[from])) ++from;
    std::size_t to = from;
    while (to < line.size() && !is_blank(line[to])) ++to;
    const std::string_view word = line.substr(from, to - from);
    line.remove_prefix(to);
    return word;
}

/// Reads a whole word as a number, the same in every locale: decimal, `nan`, `inf`, a leading plus,
/// and the `1.#QNAN` of old Windows programs (a NaN). Too large becomes infinite, too small zero.
/// Returns false if the word is no number.
inline bool parse_number(std::string_view word, double& value) {
    if (!word.empty() && word[0] == '+') word.remove_prefix(1);
    const char* end = word.data() + word.size();
    const auto [stop, status] = std::from_chars(word.data(), end, value);
    if (status == std::errc::result_out_of_range)
        value = std::strtod(std::string(word).c_str(), nullptr);
    else if (status != std::errc{}) return false;
    if (stop == end) return true;
    if (*stop != '#') return false;
    value = std::numeric_limits<double>::quiet_NaN();
    return true;
}

}  // namespace slim
