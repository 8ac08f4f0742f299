#include "formats/cloud_endings.h"

#include <algorithm>
#include <array>
#include <cstddef>

namespace slim {
namespace {

constexpr auto kText = std::to_array<std::string_view>({".xyz", ".txt", ".asc", ".pts", ".csv"});

}  // namespace

bool is_text_ending(std::string_view ending) {
    return std::find(kText.begin(), kText.end(), ending) != kText.end();
}

bool is_cloud_ending(std::string_view ending) { return ending == ".ply" || is_text_ending(ending); }

std::string text_endings(std::string_view between, std::string_view before_last) {
    std::string out(kText[0]);
    for (std::size_t i = 1; i < kText.size(); ++i) {
        out += i + 1 < kText.size() ? between : before_last;
        out += kText[i];
    }
    return out;
}

}  // namespace slim
