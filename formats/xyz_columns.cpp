#include "formats/xyz_columns.h"

#include <algorithm>
#include <cctype>
#include <cmath>

namespace slim {
namespace {

bool is_separator(char c) {
    return c == ' ' || c == '\t' || c == ',' || c == ';' || c == '\r' || c == '\v' || c == '\f';
}

std::string plain_name(std::string_view word) {
    std::string name;
    for (const char c : word)
        if (c != '"' && c != '\'' && c != '#' && c != '/')
            name += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return name;
}

bool is_unit_triple(const std::vector<double>& row, std::size_t from, bool& is_zero) {
    const double sq = row[from] * row[from] + row[from + 1] * row[from + 1] +
                      row[from + 2] * row[from + 2];
    is_zero = sq == 0;
    return is_zero || std::abs(std::sqrt(sq) - 1) < 0.02;
}

bool are_normals(const std::vector<std::vector<double>>& rows, std::size_t from) {
    std::size_t n_zero = 0;
    for (const auto& row : rows) {
        bool is_zero = false;
        if (!is_unit_triple(row, from, is_zero)) return false;
        n_zero += is_zero ? 1 : 0;
    }
    return n_zero * 2 < rows.size();
}

}  // namespace

void split_row(std::string_view line, std::vector<std::string_view>& words) {
    words.clear();
    for (std::size_t i = 0; i < line.size();) {
        while (i < line.size() && is_separator(line[i])) ++i;
        const std::size_t from = i;
        while (i < line.size() && !is_separator(line[i])) ++i;
        if (i > from) words.push_back(line.substr(from, i - from));
    }
}

bool has_decimal_commas(std::string_view line) {
    std::size_t n_words = 0, n_commas = 0;
    for (std::size_t i = 0; i < line.size();) {
        const std::size_t end = std::min(line.find_first_of(" \t\r;", i), line.size());
        const std::string_view word = line.substr(i, end - i);
        i = end + 1;
        if (word.empty()) continue;
        ++n_words;
        const std::size_t comma = word.find(',');
        if (word.find_first_not_of("0123456789+-,eE") != std::string_view::npos) return false;
        if (comma == std::string_view::npos) continue;
        const auto digit_at = [&](std::size_t k) {
            return k < word.size() && std::isdigit(static_cast<unsigned char>(word[k]));
        };
        if (comma == 0 || !digit_at(comma - 1) || !digit_at(comma + 1) ||
            word.find(',', comma + 1) != std::string_view::npos)
            return false;
        ++n_commas;
    }
    return n_words >= 3 && n_commas > 0;
}

bool columns_from_names(std::string_view line, XyzColumns& out) {
    std::vector<std::string_view> words;
    split_row(line, words);
    std::vector<std::string> names;
    for (const auto word : words)
        if (std::string name = plain_name(word); !name.empty()) names.push_back(std::move(name));
    const auto find = [&](const char* name) {
        const auto at = std::find(names.begin(), names.end(), name);
        return at == names.end() ? -1 : static_cast<int>(at - names.begin());
    };
    XyzColumns columns;
    columns.n_columns = names.size();
    const char* const positions[] = {"x", "y", "z"};
    const char* const normals[] = {"nx", "ny", "nz"};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        columns.position[axis] = find(positions[axis]);
        columns.normal[axis] = find(normals[axis]);
        if (columns.position[axis] < 0) return false;
    }
    if (std::min({columns.normal[0], columns.normal[1], columns.normal[2]}) < 0)
        std::fill_n(columns.normal, 3, -1);
    columns.scan = find("scan");
    columns.names = std::move(names);
    out = std::move(columns);
    return true;
}

XyzColumns columns_from_rows(const std::vector<std::vector<double>>& rows) {
    XyzColumns columns;
    columns.n_columns = rows.front().size();
    if (columns.n_columns < 6) return columns;
    for (const std::size_t from : {std::size_t{3}, columns.n_columns - 3}) {
        if (!are_normals(rows, from)) continue;
        for (int axis = 0; axis < 3; ++axis) columns.normal[axis] = static_cast<int>(from) + axis;
        break;
    }
    return columns;
}

}  // namespace slim
