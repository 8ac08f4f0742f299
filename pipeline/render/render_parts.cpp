#include "pipeline/render/render_parts.h"

#include "pipeline/option_names.h"
#include "raytrace/shade.h"
#include "slim/base/error.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <optional>

namespace slim {
namespace {

constexpr std::uint64_t kPartBytes = std::uint64_t{384} << 20;
/// Of the renderer's tiles: a band that begins with one is drawn in the same lanes as the whole.
constexpr int kAlign = 32;

/// Whole numbers between separators; empty if the text is no such list of n.
std::vector<int> whole_numbers(const std::string& text, char separator, std::size_t n) {
    std::vector<int> numbers;
    const char* at = text.data();
    const char* const end = at + text.size();
    while (at < end) {
        int value = 0;
        const auto [rest, error] = std::from_chars(at, end, value);
        if (error != std::errc() || (rest < end && (*rest != separator || rest + 1 == end)))
            return {};
        numbers.push_back(value);
        at = rest < end ? rest + 1 : rest;
    }
    return numbers.size() == n ? numbers : std::vector<int>();
}

PixelWindow parse_crop(const std::string& text, const PictureSize& size) {
    const std::vector<int> n = whole_numbers(text, ',', 4);
    if (n.empty() || n[0] < 0 || n[1] < 0 || n[2] < 1 || n[3] < 1 || n[2] > size.width - n[0] ||
        n[3] > size.height - n[1])
        throw ConfigError(
            {.key = "crop",
             .expected =
                 fmt::format("x,y,w,h inside the picture of {}x{}", size.width, size.height),
             .found = "'" + text + "'"});
    return {n[0], n[1], n[2], n[3]};
}

PixelWindow parse_tile(const std::string& text, const PictureSize& size) {
    const std::vector<int> n = whole_numbers(text, '/', 2);
    if (n.empty() || n[1] < 1 || n[0] < 1 || n[0] > n[1] || n[1] > size.height)
        throw ConfigError(
            {.key = "tile",
             .expected = fmt::format("i/n with i from 1 to n, n at most the picture's {} rows",
                                     size.height),
             .found = "'" + text + "'"});
    const auto row = [&](int i) {
        return static_cast<int>(static_cast<std::int64_t>(size.height) * i / n[1]);
    };
    return {0, row(n[0] - 1), size.width, row(n[0]) - row(n[0] - 1)};
}

}  // namespace

PixelWindow wanted_window(const RenderConfig& config, const PictureSize& size) {
    if (config.crop.empty() && config.tile.empty()) return {0, 0, size.width, size.height};
    if (!config.crop.empty() && !config.tile.empty())
        throw ConfigError(
            {.key = "crop",
             .problem = " and " + quoted_key("tile") + " both say what part to draw: give one"});
    return config.crop.empty() ? parse_tile(config.tile, size) : parse_crop(config.crop, size);
}

int shading_margin(const PictureSize& size) { return shade_reach(size.width, size.height) + 2; }

PixelWindow drawn_window(const PixelWindow& w, const PictureSize& size, int margin) {
    if (w.width == size.width && w.height == size.height) return w;
    const auto down = [&](int v) { return std::max(0, v - margin) / kAlign * kAlign; };
    const auto up = [&](int v, int end) {
        return std::min(end, (v + margin + kAlign - 1) / kAlign * kAlign);
    };
    const int x = down(w.x), y = down(w.y);
    return {x, y, up(w.x + w.width, size.width) - x, up(w.y + w.height, size.height) - y};
}

std::vector<PicturePart> picture_parts(const PictureSize& size, const PixelWindow& window,
                                       std::uint64_t pixel_bytes, int margin) {
    const std::uint64_t row_bytes = pixel_bytes * static_cast<std::uint64_t>(window.width);
    const auto affordable =
        static_cast<int>(std::clamp<std::uint64_t>(kPartBytes / row_bytes, kAlign, 1 << 20));
    const int rows = affordable / kAlign * kAlign;
    std::vector<PicturePart> parts;
    for (int y = 0; y < window.height; y += rows) {
        const PixelWindow band{window.x, window.y + y, window.width,
                               std::min(rows, window.height - y)};
        parts.push_back({band, drawn_window(band, size, margin)});
    }
    return parts;
}

}  // namespace slim
