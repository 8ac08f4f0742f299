#pragma once

#include "raytrace/lines/line_lanes.h"
#include "raytrace/lines/sheets.h"
#include "slim/base/simd.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <vector>

namespace slim {

/// Means over (2 r + 1)^2 pixels of the sheet around each hit, r = Sheets::reach: along rows, then
/// along columns, up to where the sheet ends (joined). A NaN spoils the pixels around it. Rows pass
/// by one after the other: of what is averaged, C numbers a pixel, 2 r + 1 rows are held at a time.
/// cost O(pixels x r x C), in lanes
template <std::size_t C>
class RowBlur {
public:
    /// C numbers for each pixel of a row, from `pad` columns before it to as many after.
    class Row {
    public:
        Row(std::size_t width, std::size_t pad)
            : pad_(pad), stride_(width + 2 * pad + kLanes), v_(C * stride_, 0.0f) {}
        FloatV load(std::size_t c, std::ptrdiff_t x) const {
            return FloatV(place(c, x), stdx::element_aligned);
        }
        void store(std::size_t c, std::ptrdiff_t x, const FloatV& lanes) {
            lanes.copy_to(const_cast<float*>(place(c, x)), stdx::element_aligned);
        }

    private:
        const float* place(std::size_t c, std::ptrdiff_t x) const {
            return v_.data() + static_cast<std::ptrdiff_t>(c * stride_ + pad_) + x;
        }
        std::size_t pad_, stride_;
        std::vector<float> v_;
    };

    explicit RowBlur(const Sheets& sheets)
        : sheets_(sheets),
          raw_(sheets.width, sheets.reach),
          rows_(window(), Row(sheets.width, sheets.reach)),
          around_(window()) {}

    /// For each row y of [begin, end) in turn sink(y, mean), where mean(x) is an array of C FloatV,
    /// the means of pixels x, x + 1, ...; source(y, x) gives what is averaged in the same form, and
    /// is asked where one is hit only.
    template <class Source, class Sink>
    void run(std::size_t begin, std::size_t end, const Source& source, const Sink& sink) {
        const std::size_t reach = sheets_.reach, first = begin > reach ? begin - reach : 0;
        for (std::size_t y = first; y < end + reach; ++y) {
            if (y < sheets_.height) along_row(y, source);
            if (y < begin + reach) continue;
            const std::size_t done = y - reach;
            for (std::size_t k = 0; k < window(); ++k) around_[k] = &row(done + reach + 1 + k);
            sink(
                done, [&](std::size_t x)
                          __attribute__((always_inline)) { return mean_down(done, x); });
        }
    }

private:
    using Means = std::array<FloatV, C>;
    using Signed = std::ptrdiff_t;

    std::size_t window() const { return 2 * sheets_.reach + 1; }
    Row& row(std::size_t y) { return rows_[y % window()]; }

    template <class Source>
    void along_row(std::size_t y, const Source& source) {
        const auto at = static_cast<Signed>(y);
        for (std::size_t x = 0; x < sheets_.width; x += kLanes) {
            const auto column = static_cast<Signed>(x);
            const bool any = sheets_.hit.at(at, column) != 0;
            const Means v = any ? source(y, x) : zeros();
            for (std::size_t c = 0; c < C; ++c) raw_.store(c, column, v[c]);
        }
        const auto joined = [&](Signed x) { return sheets_.right.joined.at(at, x); };
        Row& out = row(y);
        for (std::size_t x = 0; x < sheets_.width; x += kLanes) {
            const auto column = static_cast<Signed>(x);
            Means mean = zeros();
            if (sheets_.hit.at(at, column) != 0)
                mean = means([&](Signed k) { return joined(column + k); },
                             [&](std::size_t c, Signed k) __attribute__((always_inline)) {
                                 return raw_.load(c, column + k);
                             });
            for (std::size_t c = 0; c < C; ++c) out.store(c, column, mean[c]);
        }
    }

    [[gnu::always_inline]] Means mean_down(std::size_t y, std::size_t x) {
        const auto row = static_cast<Signed>(y), column = static_cast<Signed>(x);
        const Row* const* own = around_.data() + sheets_.reach;
        return means([&](Signed k) { return sheets_.down.joined.at(row + k, column); },
                     [&](std::size_t c, Signed k)
                         __attribute__((always_inline)) { return own[k]->load(c, column); });
    }

    /// joined(k): bits of the pixels k steps on that go on to the next; at(c, k): their values. The
    /// whole windows' sums, and of those that the sheet's end cuts what there is of them.
    template <class Joined, class At>
    [[gnu::always_inline]] Means means(const Joined& joined, const At& at) const {
        const auto reach = static_cast<Signed>(sheets_.reach);
        std::uint32_t whole = kAllLanes;
        for (Signed k = -reach; k < reach; ++k) whole &= joined(k);
        if (whole == 0) return parts(joined, at);
        const FloatV share(1 / static_cast<float>(2 * reach + 1));
        Means mean = zeros();
        for (Signed k = -reach; k <= reach; ++k)
            for (std::size_t c = 0; c < C; ++c) mean[c] += share * at(c, k);
        if (whole == kAllLanes) return mean;
        const Means part = parts(joined, at);
        for (std::size_t c = 0; c < C; ++c)
            mean[c] = select<FloatV>(lanes_of_bits(whole), mean[c], part[c]);
        return mean;
    }

    template <class Joined, class At>
    [[gnu::always_inline]] Means parts(const Joined& joined, const At& at) const {
        Means sum;
        for (std::size_t c = 0; c < C; ++c) sum[c] = at(c, 0);
        FloatV count(1.0f);
        for (const Signed side : {Signed{1}, Signed{-1}}) {
            std::uint32_t bits = kAllLanes;
            for (Signed k = 1; k <= static_cast<Signed>(sheets_.reach); ++k) {
                bits &= joined(side > 0 ? k - 1 : -k);
                if (bits == 0) break;
                const auto there = lanes_of_bits(bits);
                for (std::size_t c = 0; c < C; ++c)
                    sum[c] += select<FloatV>(there, at(c, side * k), FloatV(0.0f));
                count += select<FloatV>(there, FloatV(1.0f), FloatV(0.0f));
            }
        }
        for (std::size_t c = 0; c < C; ++c) sum[c] /= count;
        return sum;
    }

    static Means zeros() {
        Means none;
        for (FloatV& v : none) v = 0.0f;
        return none;
    }

    const Sheets& sheets_;
    Row raw_;
    std::vector<Row> rows_;             ///< averaged along themselves; row y
                                        ///< at y modulo their number
    std::vector<const Row*> around_;  ///< rows y - reach to y + reach
};

/// Rows that a RowBlur works on in one go: fewer would pass the rows around them again and again.
inline std::size_t blur_band(const Sheets& sheets) {
    return std::max<std::size_t>(64, 8 * sheets.reach);
}

/// The means of a whole plane, of pixels without a hit 0. Parallel;
/// the same for any number of threads.
std::vector<float> blurred(const Sheets& sheets, const std::vector<float>& plane);

}  // namespace slim
