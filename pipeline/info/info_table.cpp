#include "pipeline/info/info_table.h"

#include "slim/base/error.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string_view>
#include <vector>

namespace slim {
namespace {

using nlohmann::json;
using Cells = std::vector<std::string>;

/// Some programs begin a text with it.
constexpr std::string_view kByteOrderMark = "\xef\xbb\xbf";

/// The next row; nothing at the end. `closed`: its quotes end. A quoted cell may hold line breaks.
std::optional<Cells> next_row(std::istream& in, bool& closed) {
    closed = true;
    if (in.peek() == std::char_traits<char>::eof()) return std::nullopt;
    Cells cells(1);
    bool quoted = false;
    for (int c = in.get(); c != std::char_traits<char>::eof(); c = in.get()) {
        if (quoted) {
            if (c != '"') cells.back() += static_cast<char>(c);
            else if (in.peek() == '"') cells.back() += static_cast<char>(in.get());
            else quoted = false;
        } else if (c == '"') {
            quoted = true;
        } else if (c == ',') {
            cells.emplace_back();
        } else if (c == '\n') {
            break;
        } else if (c != '\r') {
            cells.back() += static_cast<char>(c);
        }
    }
    closed = !quoted;
    return cells;
}

/// Of a blank line, which is no row: many programs end a table with one.
bool is_blank(const Cells& row) {
    return row.size() == 1 && row[0].find_first_not_of(" \t") == std::string::npos;
}

bool is_number(const std::string& text) {
    double value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    return error == std::errc() && end == text.data() + text.size();
}

/// Whether a first line begins a cloud, or something that only its reader can tell. Names may stand
/// in quotes.
bool begins_a_cloud(std::string line) {
    if (line.starts_with(kByteOrderMark)) line.erase(0, kByteOrderMark.size());
    const bool is_quoted = line.find('"') != std::string::npos;
    for (char& c : line)
        c = c == ';' || c == ',' || c == '\t' || c == '\r' || c == '"'
                ? ' '
                : static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    if (line.starts_with("#") || line.starts_with("//")) return true;
    Cells words;
    for (std::size_t at = 0; (at = line.find_first_not_of(' ', at)) != std::string::npos;) {
        const std::size_t end = std::min(line.find(' ', at), line.size());
        words.push_back(line.substr(at, end - at));
        at = end;
    }
    const auto holds = [&](const char* name) {
        return std::find(words.begin(), words.end(), name) != words.end();
    };
    return (!is_quoted && std::all_of(words.begin(), words.end(), is_number)) ||
           (holds("x") && holds("y") && holds("z"));
}

}  // namespace

std::optional<json> table_info(const std::string& path) {
    std::ifstream in(path, std::ios::binary);
    std::string first;
    if (!in || !std::getline(in, first) || begins_a_cloud(first)) return std::nullopt;
    in.clear();
    const bool is_marked = first.starts_with(kByteOrderMark);
    in.seekg(is_marked ? static_cast<std::streamoff>(kByteOrderMark.size()) : 0);
    bool closed = true;
    const Cells names = *next_row(in, closed);
    std::uint64_t rows = 0;
    while (closed) {
        const auto row = next_row(in, closed);
        if (!row) break;
        if (closed && is_blank(*row)) continue;
        ++rows;
        if (row->size() != names.size())
            throw FormatError(fmt::format("{}: row {}: expected {} cells, as its first line names; "
                                          "found {}",
                                          path, rows, names.size(), row->size()));
    }
    if (!closed)
        throw FormatError(fmt::format("{}: row {}: ends within quotes", path, rows));
    const bool timed = std::find(names.begin(), names.end(), "timed in the run of") != names.end();
    const std::filesystem::path report = std::filesystem::path(path).parent_path() / "report.json";
    return json{{"kind", "table"},
                {"bytes", std::filesystem::file_size(path)},
                {"about", timed || std::filesystem::exists(report)
                              ? "rows of an experiment, as 'slim report' writes"
                              : "a table (CSV), no cloud: it names no columns x, y and z"},
                {"rows", rows},
                {"columns", names}};
}

}  // namespace slim
