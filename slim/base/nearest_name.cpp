#include "slim/base/nearest_name.h"

#include <algorithm>
#include <cctype>
#include <cstddef>

namespace slim {
namespace {

std::string lower(std::string_view text) {
    std::string out(text);
    for (char& c : out) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return out;
}

/// Optimal string alignment distance: one typo (also two letters swapped) counts 1.
std::size_t edit_distance(std::string_view a, std::string_view b) {
    std::vector<std::vector<std::size_t>> d(a.size() + 1, std::vector<std::size_t>(b.size() + 1));
    for (std::size_t i = 0; i <= a.size(); ++i) {
        for (std::size_t j = 0; j <= b.size(); ++j) {
            if (i == 0 || j == 0) {
                d[i][j] = i + j;
                continue;
            }
            const std::size_t change = a[i - 1] == b[j - 1] ? 0 : 1;
            d[i][j] = std::min({d[i - 1][j] + 1, d[i][j - 1] + 1, d[i - 1][j - 1] + change});
            if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
                d[i][j] = std::min(d[i][j], d[i - 2][j - 2] + 1);
        }
    }
    return d[a.size()][b.size()];
}

}  // namespace

std::string did_you_mean(std::string_view wrong, const std::vector<std::string>& known) {
    std::size_t best = std::max<std::size_t>(2, wrong.size() / 3) + 1;
    const std::string* nearest = nullptr;
    const std::string typed = lower(wrong);
    for (const std::string& name : known) {
        const std::size_t distance = edit_distance(typed, lower(name));
        if (distance >= best || distance >= std::max(wrong.size(), name.size())) continue;
        best = distance;
        nearest = &name;
    }
    return nearest ? "did you mean '" + *nearest + "'?" : "";
}

std::string suggestion(std::string_view wrong, const std::vector<std::string>& known) {
    const std::string hint = did_you_mean(wrong, known);
    return hint.empty() ? "" : " (" + hint + ")";
}

}  // namespace slim
