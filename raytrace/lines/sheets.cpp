#include "raytrace/lines/sheets.h"

#include "raytrace/lines/line_lanes.h"
#include "slim/base/parallel.h"

#include <algorithm>
#include <cmath>

namespace slim {
namespace {

constexpr std::size_t kRowGrain = 16;

void find_hits(const GBuffer& g, BitRows& hit) {
    const auto width = static_cast<std::size_t>(g.width);
    parallel_blocks(
        static_cast<std::size_t>(g.height), kRowGrain, [&](std::size_t begin, std::size_t end) {
            for (std::size_t y = begin; y < end; ++y)
                for (std::size_t x = 0; x < width; x += kLanes)
                    hit.add(static_cast<std::ptrdiff_t>(y), static_cast<std::ptrdiff_t>(x),
                            bits_of_bytes(&g.hit[y * width + x],
                                          std::min<std::size_t>(kLanes, width - x)));
        });
}

/// Places and normals of some pixels.
struct PixelLanes {
    LanesOfVec point, normal;
    PixelLanes(const GBuffer& g, std::size_t i)
        : point(lanes_at(g.position, i)), normal(lanes_at(g.normal, i)) {}
};

/// Those of the pairs `both` that breaks_off tells apart. What depends on N.v is seldom asked for:
/// one by one.
std::uint32_t broken(const LineScene& s, std::size_t i, std::size_t stride, const PixelLanes& a,
                     const FloatV& width, const PixelLanes& b, std::uint32_t both) {
    const LanesOfVec d = b.point - a.point;
    const FloatV off = stdx::max(stdx::abs(d.dot(a.normal)), stdx::abs(d.dot(b.normal)));
    const auto apart = d.dot(d) > kSheetGap * kSheetGap * width * width;
    auto bits = static_cast<std::uint32_t>(lane_bits(apart && off > kSheetGap * width)) & both;
    for_each_bit(static_cast<std::uint32_t>(lane_bits(apart && off > width)) & both & ~bits,
                 [&](std::size_t k) {
                     if (breaks_off(s, i + k, i + k + stride)) bits |= 1u << k;
                 });
    return bits;
}

void put_edges(const LineScene& s, std::size_t y, std::size_t x, bool down, const PixelLanes& a,
               const FloatV& width, std::uint32_t both, SheetEdges& edges) {
    if (both == 0) return;
    const std::size_t stride = down ? static_cast<std::size_t>(s.buffer.width) : 1;
    const std::size_t i = y * static_cast<std::size_t>(s.buffer.width) + x;
    const PixelLanes b(s.buffer, i + stride);
    const FloatV turn = a.normal.dot(b.normal);
    const std::uint32_t unbroken = both & ~broken(s, i, stride, a, width, b, both);
    const auto row = static_cast<std::ptrdiff_t>(y), column = static_cast<std::ptrdiff_t>(x);
    edges.unbroken.add(row, column, unbroken);
    edges.joined.add(row, column,
                     unbroken & static_cast<std::uint32_t>(lane_bits(turn > kSheetTurn)));
    edges.creased.add(row, column,
                      unbroken & static_cast<std::uint32_t>(lane_bits(turn < kCreaseTurn)));
}

SheetEdges no_edges(const GBuffer& g, std::size_t margin) {
    const BitRows none(static_cast<std::size_t>(g.width), static_cast<std::size_t>(g.height),
                       margin);
    return {none, none, none};
}

}  // namespace

std::size_t blur_reach(int picture_width, int picture_height) {
    constexpr double kReachAt1000 = 3;
    const double at = kReachAt1000 * std::min(picture_width, picture_height) / 1000;
    return static_cast<std::size_t>(std::max(1.0, std::round(at)));
}

Sheets::Sheets(const LineScene& s)
    : width(static_cast<std::size_t>(s.buffer.width)),
      height(static_cast<std::size_t>(s.buffer.height)),
      reach(blur_reach(s.buffer.width, s.picture_height())),
      hit(width, height, reach),
      right(no_edges(s.buffer, reach)),
      down(right) {
    find_hits(s.buffer, hit);
    parallel_blocks(height, kRowGrain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t y = begin; y < end; ++y)
            for (std::size_t x = 0; x < width; x += kLanes) {
                const auto row = static_cast<std::ptrdiff_t>(y),
                           column = static_cast<std::ptrdiff_t>(x);
                const std::uint32_t own = hit.at(row, column);
                if (own == 0) continue;
                const PixelLanes a(s.buffer, y * width + x);
                const FloatV footprint = footprints(s, a.point);
                put_edges(s, y, x, false, a, footprint, own & hit.at(row, column + 1), right);
                put_edges(s, y, x, true, a, footprint, own & hit.at(row + 1, column), down);
            }
    });
}

}  // namespace slim
