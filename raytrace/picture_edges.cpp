#include "raytrace/picture_edges.h"

#include "slim/base/parallel.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace slim {
namespace {

constexpr std::size_t kRowGrain = 32;

/// Least and most of each channel over a row and the rows beside it, with their roots taken.
struct RowSpan {
    std::vector<float> least, most;
};

void take_roots(const Picture& picture, int y, std::vector<float>& out) {
    const float* from = picture.pixel(0, y);
    for (std::size_t i = 0; i < out.size(); ++i) out[i] = std::sqrt(std::max(from[i], 0.0f));
}

/// The span of three rows of roots.
void span_of(const std::vector<float>& a, const std::vector<float>& b, const std::vector<float>& c,
             RowSpan& out) {
    for (std::size_t i = 0; i < a.size(); ++i) {
        out.least[i] = std::min(std::min(a[i], b[i]), c[i]);
        out.most[i] = std::max(std::max(a[i], b[i]), c[i]);
    }
}

/// Marks of a row: its roots against the span of three rows, at three columns.
void mark_row(const std::vector<float>& own, const RowSpan& span, float contrast,
              std::uint8_t* out) {
    const std::size_t n = own.size() / 4;
    for (std::size_t x = 0; x < n; ++x) {
        const std::size_t left = 4 * (x > 0 ? x - 1 : 0), here = 4 * x,
                          right = 4 * (x + 1 < n ? x + 1 : x);
        float apart = 0;
        for (std::size_t c = 0; c < 4; ++c) {
            const float least = std::min({span.least[left + c], span.least[here + c],
                                          span.least[right + c]}),
                        most = std::max({span.most[left + c], span.most[here + c],
                                         span.most[right + c]});
            apart = std::max({apart, most - own[here + c], own[here + c] - least});
        }
        out[x] = apart > contrast;
    }
}

}  // namespace

std::vector<std::uint8_t> edge_pixels(const Picture& picture, float contrast) {
    std::vector<std::uint8_t> marks(picture.n_pixels());
    const std::size_t n = 4 * static_cast<std::size_t>(picture.width);
    parallel_blocks(
        static_cast<std::size_t>(picture.height), kRowGrain,
        [&](std::size_t begin, std::size_t end) {
            std::vector<float> above(n), own(n), below(n);
            RowSpan span{std::vector<float>(n), std::vector<float>(n)};
            const int first = static_cast<int>(begin), last = picture.height - 1;
            take_roots(picture, std::max(0, first - 1), above);
            take_roots(picture, first, own);
            for (int y = first; y < static_cast<int>(end); ++y) {
                take_roots(picture, std::min(last, y + 1), below);
                span_of(above, own, below, span);
                mark_row(own, span, contrast, &marks[picture.index(0, y)]);
                above.swap(own), own.swap(below);
            }
        });
    return marks;
}

}  // namespace slim
