#include "raytrace/picture_edges.h"

#include "slim/base/check.h"
#include "slim/base/parallel.h"
#include "slim/base/simd.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstring>

namespace slim {
namespace {

constexpr std::size_t kRowGrain = 32, kChannels = 4;
static_assert(kLanes % kChannels == 0);

/// A strip of this many pixels is taken from top to bottom, so that its rows stay in the cache.
constexpr int kStrip = 64;

/// A row's channels in a strip, with the pixels before and after it (at the picture's sides its
/// first and last once more), and room for lanes.
using Row = std::vector<float>;

FloatV load(const Row& row, std::size_t i) { return FloatV(&row[i], stdx::element_aligned); }

/// The columns of a strip, and the ones that it touches.
struct Strip {
    int first, n, left, right;  ///< left, right: one pixel more to either side, within the picture
    Strip(int x, int width)
        : first(x), n(std::min(kStrip, width - x)), left(std::max(0, x - 1)),
          right(std::min(width, x + n + 1)) {}
};

/// The square roots of a row of the picture.
void take_roots(const Picture& picture, const Strip& strip, int y, Row& out) {
    const auto n = kChannels * static_cast<std::size_t>(strip.n);
    float* const inner = out.data() + kChannels;
    std::copy_n(picture.pixel(strip.first, y), n, inner);
    std::copy_n(picture.pixel(strip.left, y), kChannels, out.data());
    std::copy_n(picture.pixel(strip.right - 1, y), kChannels, inner + n);
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

/// The roots of a picture's rows in a strip, of which some may be known to be 0 all over.
class StripRows {
public:
    StripRows(const Picture& picture, std::span<const std::uint8_t> covered, const Strip& strip)
        : picture_(picture), covered_(covered), strip_(strip),
          rows_(kChannels * (kStrip + 2) + 2 * kLanes) {}

    /// Rows [begin, end).
    void mark(int begin, int end, float contrast, std::vector<std::uint8_t>& marks) {
        const int last = picture_.height - 1;
        take(std::max(0, begin - 1), rows_.above, any_[0]);
        take(begin, rows_.own, any_[1]);
        for (int y = begin; y < end; ++y) {
            take(std::min(last, y + 1), rows_.below, any_[2]);
            if (any_[0] || any_[1] || any_[2]) {
                const auto n = static_cast<std::size_t>(strip_.n);
                rows_.find_spans(kChannels * (n + 2));
                rows_.mark(n, contrast, &marks[picture_.index(strip_.first, y)]);
            }
            rows_.above.swap(rows_.own), rows_.own.swap(rows_.below);
            any_ = {any_[1], any_[2], any_[0]};  // a row that is empty is cleared already
        }
    }

private:
    bool is_covered(int y) const {
        if (covered_.empty()) return true;
        return std::memchr(covered_.data() + picture_.index(strip_.left, y), 1,
                           static_cast<std::size_t>(strip_.right - strip_.left)) != nullptr;
    }
    void take(int y, Row& row, bool& any) {
        const bool was = any;
        any = is_covered(y);
        if (any) take_roots(picture_, strip_, y, row);
        else if (was)
            std::fill(row.begin(), row.end(), 0.0f);
    }

    const Picture& picture_;
    std::span<const std::uint8_t> covered_;
    Strip strip_;
    ThreeRows rows_;
    std::array<bool, 3> any_{};  ///< whether the rows above, own and below may hold anything
};

}  // namespace

std::vector<std::uint8_t> edge_pixels(const Picture& picture, float contrast,
                                      std::span<const std::uint8_t> covered) {
    std::vector<std::uint8_t> marks(picture.n_pixels());
    if (!covered.empty()) SLIM_CHECK(covered.size(), ==, marks.size());
    parallel_blocks(static_cast<std::size_t>(picture.height), kRowGrain,
                    [&](std::size_t begin, std::size_t end) {
                        for (int x = 0; x < picture.width; x += kStrip)
                            StripRows(picture, covered, Strip(x, picture.width))
                                .mark(static_cast<int>(begin), static_cast<int>(end), contrast,
                                      marks);
                    });
    return marks;
}

}  // namespace slim
