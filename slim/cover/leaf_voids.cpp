#include "slim/cover/leaf_voids.h"

#include "slim/cover/leaf_reach.h"
#include "slim/cover/void_ends.h"
#include "slim/model/surfel.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

namespace slim {
namespace {

constexpr std::size_t kLeastPoints = 100;  // of a leaf: of fewer no void fits its disc
constexpr double kWidth = 5;      // spacings: a square of random points is empty once in e^25
constexpr std::size_t kDepth = 3;     // cells of it that a leaf must draw
constexpr double kBesideVoid = 20;  // points of a square as large beside it: chance leaves one of
                                    // the two empty once in ten million places
constexpr double kOfSmaller = 0.05;  // share of places that are first of a smaller empty square:
                                     // such are usual here, as between scan lines,
constexpr double kUsualTimes = 2.5;  // and a void is so much wider
constexpr double kLeastThick = 0.5;  // of the cells that are no void: thicker than a line
constexpr std::size_t kThick = 3;    // cells
constexpr std::size_t kRagged = 2;   // cells about a void that its squares do not fill
constexpr double kSparseShare = 0.15;  // of the density elsewhere, about a point in sparse parts;
constexpr std::size_t kVouches = 2;    // widths about it where it shows a surface all the same

/// The drawn disc, for every number of cells.
const CellMask& drawn_disc(std::size_t n) {
    static const auto discs = [] {
        std::array<CellMask, 65> out;
        for (std::size_t i = 1; i < out.size(); ++i) out[i] = disc_of_cells(i, kHitTrim);
        return out;
    }();
    return discs[n];
}

/// The cells of the whole ball's.
const CellMask& whole_disc(std::size_t n) {
    static const auto discs = [] {
        std::array<CellMask, 65> out;
        for (std::size_t i = 1; i < out.size(); ++i) out[i] = disc_of_cells(i, 1);
        return out;
    }();
    return discs[n];
}

bool is_deep(const CellMask& bridged) { return bridged.corners_of_squares(kDepth).any(); }

/// Cells that are kWidth spacings of n points over so many cells.
std::size_t width_in_cells(double n, double n_cells) {
    return std::max<std::size_t>(
        2, static_cast<std::size_t>(std::ceil(kWidth * std::sqrt(n_cells / n) - 1e-9)));
}

double cells_of_disc(const PointRaster& raster) {
    return std::numbers::pi / (raster.cell * raster.cell);
}

/// Points by cell, summed from the first one on.
class CellCounts {
public:
    explicit CellCounts(std::size_t n) : n_(n), sums_((n + 1) * (n + 1), 0) {}
    void add(std::size_t x, std::size_t y) { ++sums_[(y + 1) * (n_ + 1) + x + 1]; }
    void sum_up() {
        for (std::size_t y = 1; y <= n_; ++y)
            for (std::size_t x = 1; x <= n_; ++x)
                at(x, y) += at(x - 1, y) + at(x, y - 1) - at(x - 1, y - 1);
    }
    /// Of the part of a square that is in the grid; its first cell may be outside.
    double in_square(long x, long y, long size) const {
        const auto clamp = [&](long i) {
            return static_cast<std::size_t>(std::clamp(i, 0L, static_cast<long>(n_)));
        };
        const std::size_t x0 = clamp(x), y0 = clamp(y), x1 = clamp(x + size), y1 = clamp(y + size);
        return static_cast<double>(get(x1, y1) + get(x0, y0)) -
               static_cast<double>(get(x0, y1) + get(x1, y0));
    }

private:
    std::uint32_t& at(std::size_t x, std::size_t y) { return sums_[y * (n_ + 1) + x]; }
    std::uint32_t get(std::size_t x, std::size_t y) const { return sums_[y * (n_ + 1) + x]; }
    std::size_t n_;
    std::vector<std::uint32_t> sums_;
};

class VoidSearch {
public:
    VoidSearch(const CoveringSurfel& leaf, const BallPoints<double>& ball)
        : raster_(leaf.covered.size()), counts_(raster_.cells()) {
        for (const Covered& p : leaf.covered) add(p.u, p.v);
        // those that it does not explain say where data are as well
        const Frame<double>& frame = leaf.fitted.surfel.frame;
        for (std::size_t i = 0; i < ball.n; ++i) {
            if (!(ball.sq[i] < 1)) continue;
            const Vec3d p = frame.local_from_world(ball.place(i));
            if (std::abs(p.z) < 2 * kBelongs)
                raster_.add(static_cast<float>(p.x), static_cast<float>(p.y));
        }
        counts_.sum_up();
        n_ = static_cast<double>(leaf.covered.size());
        disc_ = whole_disc(raster_.cells());
        empty_ = disc_.without(raster_.filled);
        all_ = disc_of_cells(raster_.cells(), 2);
    }

    /// The voids, squares of the least width that is no usual one here.
    CellMask find() {
        for (width_ = width_in_cells(n_, cells_of_disc(raster_)); 2 * width_ <= raster_.cells();
             width_ += (width_ + 1) / 2) {
            const CellMask first = empty_.corners_of_squares(width_);
            if (!first.any()) break;
            const CellMask open = first.squares_at_corners(width_), rest = disc_.without(open);
            // what lies outside of the ball is taken for filled
            const CellMask thick = all_.without(open).opened(kThick);
            if (static_cast<double>((thick & disc_).count()) <
                kLeastThick * static_cast<double>(rest.count()))
                continue;
            const double usual = usual_width(rest.without(open.grown(kRagged)));
            if (static_cast<double>(width_) < kUsualTimes * usual + 2) continue;
            return surely_empty(first, open, thick);
        }
        CellMask none;
        none.n = raster_.cells();
        return none;
    }
    std::size_t width() const { return width_; }
    const PointRaster& raster() const { return raster_; }
    double n_points() const { return n_; }

private:
    void add(float u, float v) {
        raster_.add(u, v);
        counts_.add(raster_.cell_of(u), raster_.cell_of(v));
    }
    /// The width of empty squares that stand all over the rest.
    double usual_width(const CellMask& rest) const {
        const CellMask empty = empty_ & rest;
        const double few = kOfSmaller * static_cast<double>(rest.count());
        std::size_t width = 0;
        while (width < width_ &&
               static_cast<double>(empty.corners_of_squares(width + 1).count()) > few)
            ++width;
        return static_cast<double>(width);
    }
    /// Of the empty squares those beside which points lie as densely as chance cannot.
    CellMask beside_dense(const CellMask& first) const {
        CellMask out;
        out.n = first.n;
        const long size = static_cast<long>(width_), step = size + 1;
        for_cells(first, [&](std::size_t x, std::size_t y) {
            double most = 0;
            for (const long dy : {-step, 0L, step})
                for (const long dx : {-step, 0L, step})
                    most = std::max(most, counts_.in_square(static_cast<long>(x) + dx,
                                                            static_cast<long>(y) + dy, size));
            if (most >= kBesideVoid) out.set(x, y);
        });
        return out;
    }
    /// Points that have hardly any others about them, though many are elsewhere.
    CellMask sparse(const CellMask& thick, const CellMask& open) const {
        const CellMask inner = disc_of_cells(raster_.cells(), 1 - kThick * raster_.cell);
        CellMask out = (raster_.filled & inner).without(thick.grown(kRagged));
        CellCounts cells(raster_.cells());
        for_cells(disc_, [&](std::size_t x, std::size_t y) { cells.add(x, y); });
        cells.sum_up();
        const double dense =
            n_ / static_cast<double>(disc_.count() - std::min(disc_.count() - 1, open.count()));
        const long reach = static_cast<long>(width_), size = 2 * reach + 1;
        for_cells(raster_.filled & disc_, [&](std::size_t i, std::size_t j) {
            const long x = static_cast<long>(i) - reach, y = static_cast<long>(j) - reach;
            const double n_cells = cells.in_square(x, y, size);
            if (3 * n_cells > static_cast<double>(size * size) &&
                counts_.in_square(x, y, size) < kSparseShare * dense * n_cells)
                out.set(i, j);
        });
        return out;
    }
    CellMask surely_empty(const CellMask& first, const CellMask& open,
                          const CellMask& thick) const {
        CellMask voids = open & beside_dense(first).squares_at_corners(width_).grown(width_);
        const CellMask few = sparse(thick, open);
        if (few.any()) voids = voids.without(few.grown(kVouches * width_));
        return voids.opened(width_);
    }

    PointRaster raster_;
    CellCounts counts_;
    double n_ = 0;
    CellMask disc_, empty_, all_;
    std::size_t width_ = 0;
};

}  // namespace

bool may_bridge(const CoveringSurfel& leaf) {
    if (leaf.fitted.surfel.sharp || leaf.covered.size() < kLeastPoints) return false;
    PointRaster raster(leaf.covered.size());
    for (const Covered& p : leaf.covered) raster.add(p.u, p.v);
    const std::size_t width =
        width_in_cells(static_cast<double>(leaf.covered.size()), cells_of_disc(raster));
    const CellMask first =
        whole_disc(raster.cells()).without(raster.filled).corners_of_squares(width);
    if (!first.any()) return false;
    return is_deep(first.squares_at_corners(width) & drawn_disc(raster.cells()));
}

LeafVoids voids_of(const CoveringSurfel& leaf, const BallPoints<double>& ball, PackedRims rims) {
    LeafVoids out;
    VoidSearch search(leaf, ball);
    out.voids = search.find();
    out.raster = search.raster();
    if (!out.voids.any()) return out;
    const CellMask& disc = drawn_disc(out.raster.cells());
    CellMask drawn = within(out.raster, disc, unpack_rim(rims.first));
    drawn = within(out.raster, drawn, unpack_rim(rims.second));
    if (!is_deep(out.voids & drawn)) return out;
    out.any = true;
    const CellMask filled = disc.without(out.voids), voids = disc & out.voids;
    const double n_cells = cells_of_disc(out.raster) - static_cast<double>(out.voids.count());
    out.spacing = out.raster.cell * std::sqrt(std::max(1.0, n_cells) / search.n_points());
    find_ends(voids, filled, out);
    return out;
}

}  // namespace slim
