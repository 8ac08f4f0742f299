#include "pipeline/shell_word.h"

#include <algorithm>
#include <string_view>

namespace slim {
namespace {

bool is_plain(char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
           std::string_view("_@%+=:,./-").find(c) != std::string_view::npos;
}

/// Where the value of "--option=value" begins; 0 for any other word.
std::size_t value_of_option(const std::string& word) {
    const std::size_t equals = word.find('=');
    const bool is_option =
        word.starts_with("--") && equals != std::string::npos &&
        std::all_of(word.begin(), word.begin() + static_cast<std::ptrdiff_t>(equals), is_plain);
    return is_option && equals + 1 < word.size() ? equals + 1 : 0;
}

}  // namespace

std::string shell_quoted(const std::string& text) {
    std::string out = "'";
    for (const char c : text) out += c == '\'' ? std::string("'\\''") : std::string(1, c);
    return out + "'";
}

std::string shell_word(const std::string& text) {
    return !text.empty() && std::all_of(text.begin(), text.end(), is_plain) ? text
                                                                            : shell_quoted(text);
}

std::string shell_line(const std::vector<std::string>& words) {
    std::string line;
    for (const std::string& word : words) {
        const std::size_t value = value_of_option(word);
        line += (line.empty() ? "" : " ") + word.substr(0, value) + shell_word(word.substr(value));
    }
    return line;
}

}  // namespace slim
