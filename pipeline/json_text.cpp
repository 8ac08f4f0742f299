#include "pipeline/json_text.h"

#include "slim/base/error.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <istream>
#include <sstream>

namespace slim {

using nlohmann::json;

json json_from(std::istream& in) { return json::parse(in); }

namespace {

/// Where the word begins that a place is in, so that it is shown whole.
std::size_t word_begin(const std::string& text, std::size_t at) {
    const auto in_word = [&](std::size_t i) {
        return i < text.size() && std::isalnum(static_cast<unsigned char>(text[i])) != 0;
    };
    while (at > 0 && in_word(at) && in_word(at - 1)) --at;
    return at;
}

/// "'abc'" of what stands at a place of a text, as it is shown in a message.
std::string shown(const std::string& text, std::size_t at) {
    if (at >= text.size()) return text.empty() ? "an empty file" : "the end of the file";
    constexpr std::size_t kMost = 24;
    std::string out;
    for (std::size_t i = at; i < text.size() && i < at + kMost && text[i] != '\n'; ++i) {
        const auto byte = static_cast<unsigned char>(text[i]);
        if (byte < 0x20 || byte >= 0x7f) break;
        out += text[i];
    }
    if (out.empty()) return "byte " + std::to_string(static_cast<unsigned char>(text[at]));
    return "'" + out + "'";
}

}  // namespace

json read_json(const std::string& path) {
    errno = 0;
    std::ifstream in(path, std::ios::binary);
    std::stringstream read;
    if (in && in.peek() != std::ifstream::traits_type::eof()) read << in.rdbuf();
    if (!in.is_open() || in.bad() || std::filesystem::is_directory(path))
        throw IoError({.file = path,
                       .problem = std::string("cannot be opened: ") +
                                  (errno != 0 ? std::strerror(errno) : "is no file")});
    const std::string text = std::move(read).str();
    try {
        return json::parse(text);
    } catch (const json::parse_error& error) {  // its byte counts from 1
        const std::size_t at = word_begin(text, error.byte > 0 ? error.byte - 1 : 0);
        const std::string before = text.substr(0, at);
        const auto line = 1 + std::count(before.begin(), before.end(), '\n');
        throw FormatError(Fault{.file = path,
                                .line = static_cast<int>(line),
                                .problem = "byte " + std::to_string(at),
                                .expected = "JSON",
                                .found = shown(text, at)});
    } catch (const json::exception&) {  // a number that no double holds
        throw FormatError(Fault{.file = path,
                                .expected = "JSON",
                                .found = "a number that is too large"});
    }
}

json json_or_discarded(std::istream& in) { return json::parse(in, nullptr, false); }

json json_or_discarded(const std::string& text) { return json::parse(text, nullptr, false); }

std::string text_of(const json& value, int indent) {
    return value.dump(indent, ' ', false, json::error_handler_t::replace);
}

}  // namespace slim
