#include "raytrace/picture_edges.h"

#include "slim/base/parallel.h"
#include "slim/base/simd.h"

#include <algorithm>
#include <cstddef>

namespace slim {
namespace {

constexpr std::size_t kRowGrain = 32, kChannels = 4;
static_assert(kLanes % kChannels == 0);

/// A row's channels, with its first and last pixel once more at its ends, and room for lanes.
using Row = std::vector<float>;

FloatV load(const Row& row, std::size_t i) { return FloatV(&row[i], stdx::element_aligned); }

/// The square roots of a row of the picture.
void take_roots(const Picture& picture, int y, Row& out) {
    const std::size_t n = kChannels * static_cast<std::size_t>(picture.width);
    float* const inner = out.data() + kChannels;
    std::copy_n(picture.pixel(0, y), n, inner);
    std::copy_n(inner, kChannels, out.data());
    std::copy_n(inner + n - kChannels, kChannels, inner + n);
    for (std::size_t i = 0; i < n + 2 * kChannels; i += kLanes)
        stdx::sqrt(stdx::max(load(out, i), FloatV(0.0f))).copy_to(&out[i], stdx::element_aligned);
}

/// Three rows of roots, the middle one of which is to be marked.
struct ThreeRows {
    Row above, own, below, least, most;

    explicit ThreeRows(std::size_t n) : above(n), own(n), below(n), least(n), most(n) {}

    /// Of each column.
    void find_spans(std::size_t n) {
        for (std::size_t i = 0; i < n; i += kLanes) {
            const FloatV a = load(above, i), b = load(own, i), c = load(below, i);
            stdx::min(stdx::min(a, b), c).copy_to(&least[i], stdx::element_aligned);
            stdx::max(stdx::max(a, b), c).copy_to(&most[i], stdx::element_aligned);
        }
    }

    /// `n` pixels; what is not marked stays as it is.
    void mark(std::size_t n, float contrast, std::uint8_t* out) const {
        for (std::size_t i = 0; i < kChannels * n; i += kLanes) {
            // The columns beside a pixel begin four numbers before and after it.
            const FloatV low = stdx::min(stdx::min(load(least, i), load(least, i + kChannels)),
                                         load(least, i + 2 * kChannels));
            const FloatV high = stdx::max(stdx::max(load(most, i), load(most, i + kChannels)),
                                          load(most, i + 2 * kChannels));
            const FloatV at = load(own, i + kChannels);
            std::uint64_t bits = lane_bits(stdx::max(high - at, at - low) > contrast);
            for (std::size_t x = i / kChannels; bits != 0 && x < n; ++x, bits >>= kChannels)
                if (bits & ((1u << kChannels) - 1)) out[x] = 1;
        }
    }
};

}  // namespace

std::vector<std::uint8_t> edge_pixels(const Picture& picture, float contrast) {
    std::vector<std::uint8_t> marks(picture.n_pixels());
    const auto width = static_cast<std::size_t>(picture.width);
    const std::size_t n = kChannels * (width + 2);
    parallel_blocks(static_cast<std::size_t>(picture.height), kRowGrain,
                    [&](std::size_t begin, std::size_t end) {
                        ThreeRows rows(n + 2 * kLanes);
                        const int first = static_cast<int>(begin), last = picture.height - 1;
                        take_roots(picture, std::max(0, first - 1), rows.above);
                        take_roots(picture, first, rows.own);
                        for (int y = first; y < static_cast<int>(end); ++y) {
                            take_roots(picture, std::min(last, y + 1), rows.below);
                            rows.find_spans(n);
                            rows.mark(width, contrast, &marks[picture.index(0, y)]);
                            rows.above.swap(rows.own), rows.own.swap(rows.below);
                        }
                    });
    return marks;
}

}  // namespace slim
